"""The human floor: how close the mean of a person's other repeats comes to one captured reach.

No prediction of a reach can be expected to come closer than the same person's other reaches to the
same target do. A repeat is predicted by their mean, so the floor is the held distance to that mean,
not to another repeat: a mean is closer to each repeat than repeats are to each other, so even a
poor predictor beats the plain distance between two repeats, which is shown but judges nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armsyn.errors import CaptureError
from armsyn.ik import solve_ik
from armsyn.kinematics import SerialChain
from armsyn.motion import FloatArray, Motion
from armsyn.motion.filtering import CUTOFF
from armsyn.motion.resample import interpolate
from armsyn.motion.segmentation import CUT_FRACTION
from armsyn.scoring.distance import held_distance
from armsyn.scoring.joint_map import mapped
from armsyn.scoring.pairing import pair_up, trim, uncut

FEWEST_REPEATS = 2
"""Others, for a mean that is one."""
_PHASE = np.linspace(0.0, 1.0, 101)


@dataclass(frozen=True)
class Person:
    """How the joint angles of a set of captures become landmarks.

    Parameters
    ----------
    chain : SerialChain
        One joint a column of the captures' angles; its tip is the hand.
    rows : tuple of int
        Which of the chain's positions the landmarks are, the tip (-1) last.
    """

    chain: SerialChain
    rows: tuple[int, ...]

    def landmarks(self, angles: FloatArray) -> FloatArray:
        """Return the landmarks of postures (frames, joints), shape (frames, landmarks, 3), m."""
        return self.chain.positions(angles)[:, list(self.rows)]


@dataclass(frozen=True)
class HumanFloor:
    """What the same person's other reaches to the same target say about one of them.

    Parameters
    ----------
    distance : float
        m, the floor: held distance of the reach to the mean of the others.
    repeat_distance : float
        m, the mean held distance of the reach to each of the others; judges nothing.
    repeats : int
        How many others.
    """

    distance: float
    repeat_distance: float
    repeats: int


def human_floor(
    captured: Motion,
    others: Sequence[Motion],
    person: Person,
    *,
    landmarks: Sequence[str] = (),
    cutoff: float | None = CUTOFF,
    fraction: float = CUT_FRACTION,
    as_cut: bool = False,
) -> HumanFloor:
    """Return the human floor of one captured reach.

    Parameters
    ----------
    captured : Motion
        With joint angles and the landmarks that `person` makes of them.
    others : sequence of Motion
        The same person's other reaches to the same target.
    person : Person
        Whose angles they are.
    landmarks : sequence of str
        To compare, the hand last; empty for all.
    cutoff, fraction : float
        Of the held distance; see `armsyn.scoring.pairing.trim`.
    as_cut : bool
        Take whole motions as they are instead of onset to offset, as published floors do.

    Returns
    -------
    HumanFloor
        Taken like the held distance that it is to be set against.

    Raises
    ------
    CaptureError
        When there are fewer than two others, one has no angles, or the mean of the others cannot
        be led to where the reach ends.
    """
    if len(others) < FEWEST_REPEATS:
        raise CaptureError(f"{captured.source}: {len(others)} other repeats: a floor needs two")

    chosen = tuple((name, name) for name in landmarks)
    own = mapped(captured, chosen, other=False)

    def distance(other: Motion) -> float:
        pair = pair_up(own, mapped(other, chosen, other=True))
        cut = uncut(pair) if as_cut else trim(pair, cutoff=cutoff, fraction=fraction)
        return held_distance(cut)

    return HumanFloor(
        distance=distance(mean_of_repeats(captured, others, person)),
        repeat_distance=float(np.mean([distance(other) for other in others])),
        repeats=len(others),
    )


def mean_of_repeats(captured: Motion, others: Sequence[Motion], person: Person) -> Motion:
    """Predict a captured reach by the mean of its repeats, moved to its own start and end.

    Joint angles are averaged over normalised time and the duration is the mean of the others'. The
    offset to the captured start is faded out linearly; the end is led to the captured hand's end
    along minimum jerk, 6 s^5 - 15 s^4 + 10 s^3, by the change of posture that IK finds there.

    Parameters
    ----------
    captured : Motion
        Gives the first posture and the hand's last position, and nothing else.
    others : sequence of Motion
        With the same joint angles.
    person : Person
        Whose angles they are.

    Returns
    -------
    Motion
        Angles and landmarks, at the captured rate.

    Raises
    ------
    CaptureError
        When one has no angles, or no posture near the mean's last one reaches the captured end.
    """
    mean = np.mean([_angles_over_phase(motion) for motion in others], axis=0)
    start = _angles_over_phase(captured)[0] - mean[0]
    mean += start * (1 - _PHASE[:, None])
    solved = solve_ik(person.chain, captured.hand[-1], mean[-1])
    if not solved.success:
        raise CaptureError(
            f"{captured.source}: no posture takes the mean of its repeats to where it ends:"
            f" {solved.position_error * 100:.1f} cm short"
        )
    share = _PHASE**3 * (10 - 15 * _PHASE + 6 * _PHASE**2)
    mean += (solved.posture - mean[-1]) * share[:, None]
    duration = float(np.mean([motion.duration for motion in others]))
    time = np.linspace(0.0, duration, round(duration * captured.rate) + 1)
    angles = interpolate(_PHASE * duration, mean, time)
    return Motion(
        time=time,
        joint_names=captured.joint_names,
        angles=angles,
        landmark_names=captured.landmark_names,
        landmarks=person.landmarks(angles),
        source=f"mean of {len(others)} repeats of {captured.source}",
    )


def _angles_over_phase(motion: Motion) -> FloatArray:
    if motion.angles is None:
        raise CaptureError(f"{motion.source}: no joint angles to average")
    phase = (motion.time - motion.time[0]) / motion.duration
    return interpolate(phase, motion.angles, _PHASE)
