"""Captured reaches as predictors learn from them: joint angles over normalised time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription, load_arm
from armsyn.errors import CaptureError
from armsyn.kinematics import SerialChain
from armsyn.motion import Motion
from armsyn.motion.captures import Capture, load_captures
from armsyn.motion.filtering import LOWEST_RATE, hand_speed, low_pass
from armsyn.motion.resample import interpolate, uniform_times
from armsyn.motion.retargeting import retarget
from armsyn.motion.segmentation import movement_times
from armsyn.planning.continuous import continuous_postures

FloatArray = NDArray[np.float64]

PHASES = 101
"""Samples of a normalised motion, onset and offset included."""
PHASE = np.linspace(0.0, 1.0, PHASES)

Cut = Literal["movement", "segment"]
"""What is normalised: onset to offset (5 % of the hand's peak speed), or the segment as cut."""


@dataclass(frozen=True)
class Examples:
    """Captured reaches on one chain, over normalised time.

    Parameters
    ----------
    chain : SerialChain
        Its tip is the hand.
    names : tuple of str
        Of the reaches, as `armsyn.motion.captures` names them.
    subjects : tuple of str
        Whose each is: ``S01``, ``garza``.
    places : tuple of str
        Which target it goes to; repeats share it.
    angles : array, shape (N, PHASES, n)
        rad or m.
    durations : array, shape (N,)
        Movement times, s.
    targets : array, shape (N, 3)
        Where the hand ends, base frame, m.
    """

    chain: SerialChain
    names: tuple[str, ...]
    subjects: tuple[str, ...]
    places: tuple[str, ...]
    angles: FloatArray
    durations: FloatArray
    targets: FloatArray

    @property
    def size(self) -> int:
        """Number of reaches."""
        return len(self.names)

    @property
    def starts(self) -> FloatArray:
        """First postures, shape (N, n)."""
        return np.asarray(self.angles[:, 0])

    def only(self, rows: Sequence[int] | NDArray[np.int64] | NDArray[np.bool_]) -> Examples:
        """Return some of the reaches.

        Parameters
        ----------
        rows : sequence of int, or array of bool, shape (N,)

        Returns
        -------
        found : Examples
        --------
            In the order of `rows`.
        """
        kept = np.arange(self.size)[np.asarray(rows)]
        return Examples(
            self.chain,
            tuple(self.names[row] for row in kept),
            tuple(self.subjects[row] for row in kept),
            tuple(self.places[row] for row in kept),
            self.angles[kept],
            self.durations[kept],
            self.targets[kept],
        )


def examples_of_people(subject: str, cut: Cut = "movement") -> Examples:
    """Load every usable reach of a person of the HuG-MP set, with its own joint angles.

    Parameters
    ----------
    subject : str
        ``S01`` to ``S04``.
    cut : {"movement", "segment"}

    Returns
    -------
    found : Examples
    --------
        On the chain of ``hug_mp4``.

    Raises
    ------
    CaptureError, FormatError
        As `armsyn.motion.captures.load_captures`.
    """
    chain = load_arm("hug_mp4", calibrated=False).chain
    captures = load_captures(f"hug_mp:{subject}:all")

    def own(capture: Capture, first: float, last: float) -> FloatArray:
        motion = capture.motion
        if motion.angles is None:
            raise CaptureError(f"{capture.name}: no joint angles to learn from")
        return _over_phase((motion.time, motion.angles), first, last)

    return _examples(chain, captures, own, cut)


def examples_on_arm(
    arm: ArmDescription,
    captures: Sequence[Capture],
    cut: Cut = "movement",
    on_progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> Examples:
    """Put captured reaches on an arm by their landmarks.

    Landmarks are laid on the arm's own links (`armsyn.motion.retargeting.on_arm`) and filtered, for
    captures of 30 Hz have corners at every frame; then whole motions of the arm's joints are fitted
    to them (`armsyn.planning.continuous`).

    Parameters
    ----------
    arm : ArmDescription
    captures : sequence of Capture
    cut : {"movement", "segment"}
    on_progress : callable
        Given how many reaches are done, and of how many, after each.

    Returns
    -------
    found : Examples
    --------

    Raises
    ------
    CaptureError
        Captures without the arm's landmarks, or with gaps; none at all.
    """
    done = iter(range(1, len(captures) + 1))

    def fitted(capture: Capture, first: float, last: float) -> FloatArray:
        motion = retarget(capture.motion, arm, is_return=capture.kind == "return")
        landmarks = _over_phase(_filtered(motion), first, last)
        angles = continuous_postures(arm.chain, arm.landmark_frames, landmarks, arm.rest)
        on_progress(next(done), len(captures))
        return angles

    return _examples(arm.chain, captures, fitted, cut)


def _examples(
    chain: SerialChain,
    captures: Sequence[Capture],
    fitted: Callable[[Capture, float, float], FloatArray],
    cut: Cut,
) -> Examples:
    if not captures:
        raise CaptureError("no captured reaches to learn from")
    spans = [_span(capture.motion, cut) for capture in captures]
    angles = np.array([fitted(one, *span) for one, span in zip(captures, spans, strict=True)])
    parts = [capture.name.split(":") for capture in captures]
    return Examples(
        chain,
        tuple(capture.name for capture in captures),
        tuple(part[1] if part[0] == "hug_mp" else part[0] for part in parts),
        tuple(part[-1] if part[0] == "hug_mp" else ":".join(part[1:]) for part in parts),
        angles,
        np.array([last - first for first, last in spans]),
        np.asarray(chain.positions(angles[:, -1])[:, -1]),
    )


def _span(motion: Motion, cut: Cut) -> tuple[float, float]:
    """When the motion that is normalised begins and ends, s."""
    first, last = float(motion.time[0]), float(motion.time[-1])
    if cut == "segment":
        return first, last
    profile = hand_speed(motion.time, motion.hand)
    onset, offset = movement_times(profile.time, profile.speed)
    return max(onset, first), min(offset, last)


def _filtered(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Return even times, s, and the landmarks then, low-passed as hands are for their speed."""
    assert motion.landmarks is not None  # noqa: S101 - retarget gives them
    rate = max(motion.rate, LOWEST_RATE)
    time = uniform_times(float(motion.time[0]), float(motion.time[-1]), rate)
    return time, low_pass(interpolate(motion.time, motion.landmarks, time), rate)


def _over_phase(track: tuple[FloatArray, FloatArray], first: float, last: float) -> FloatArray:
    """Return values at times, each (frames, ...), at the phases of a part of them."""
    return interpolate(*track, first + PHASE * (last - first))
