"""Captured reaches made ready for learning: on the arm's links, resampled, start fitted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import CaptureError
from armsyn.ik import fit_posture
from armsyn.kernels.rollout import Captures
from armsyn.motion.captures import Capture
from armsyn.motion.resample import interpolate, uniform_times
from armsyn.motion.retargeting import on_arm

FloatArray = NDArray[np.float64]

START_TOLERANCE_M = 0.03
"""A start that the arm misses by more, on the mean over its landmarks, cannot be compared."""

LEAST_PATH_M = 0.02
LEAST_SEGMENT_M = 1e-3


@dataclass(frozen=True)
class Training:
    """One captured reach as learning sees it.

    Parameters
    ----------
    capture : Capture
    time : array, shape (frames,)
        s.
    landmarks : array, shape (frames, landmarks, 3)
        Where the arm's landmarks would be, base frame, m.
    start : array, shape (n,)
        Posture fitted to the first frame.
    start_residual : float
        Mean distance of its landmarks to the captured ones, m.
    """

    capture: Capture
    time: FloatArray
    landmarks: FloatArray
    start: FloatArray
    start_residual: float

    @property
    def target(self) -> FloatArray:
        """Where the captured hand ends, m."""
        return np.asarray(self.landmarks[-1, -1])


def prepare(arm: ArmDescription, capture: Capture, rate_hz: float) -> Training:
    """Put a capture on an arm.

    Its landmarks are put there by `armsyn.motion.retargeting.on_arm`.

    Parameters
    ----------
    arm : ArmDescription
    capture : Capture
    rate_hz : float
        Frame rate to bring it to.

    Returns
    -------
    Training

    Raises
    ------
    CaptureError
        Other landmarks than the arm's, gaps, a hand that rests, segments without length, or a
        start that the arm cannot take.
    """
    names = capture.motion.landmark_names
    if capture.motion.landmarks is None or tuple(arm.landmarks) not in (names, names[-1:]):
        raise CaptureError(
            f"{capture.name} has landmarks {', '.join(names) or 'none'};"
            f" {arm.name} has {', '.join(arm.landmarks)}"
        )
    if not np.isfinite(capture.motion.landmarks).all():
        frame = int(np.argmin(np.isfinite(capture.motion.landmarks).all(axis=(1, 2))))
        raise CaptureError(f"{capture.name}: a landmark is missing at frame {frame}")
    time = uniform_times(0.0, capture.motion.duration, rate_hz)
    began = float(capture.motion.time[0])
    captured = interpolate(capture.motion.time, capture.motion.landmarks, began + time)
    _check_usable(capture.name, captured)
    landmarks = on_arm(arm, captured, is_return=capture.kind == "return")
    fit = fit_posture(arm.chain, arm.landmark_frames, landmarks[0], arm.rest)
    if fit.residual > START_TOLERANCE_M:
        raise CaptureError(
            f"{capture.name}: {arm.name} misses its first posture by {fit.residual * 100:.1f} cm"
        )
    return Training(capture, time, landmarks, fit.posture, fit.residual)


def _check_usable(name: str, landmarks: FloatArray) -> None:
    hand = landmarks[:, -1]
    if np.linalg.norm(hand - hand[0], axis=1).max() < LEAST_PATH_M:
        raise CaptureError(f"{name}: the hand stays within {LEAST_PATH_M * 100:g} cm of its start")
    shortest = np.linalg.norm(np.diff(landmarks, axis=1), axis=2).min(initial=np.inf)
    if landmarks.shape[1] < 2 or shortest < LEAST_SEGMENT_M:
        raise CaptureError(f"{name}: needs landmarks that are apart, for the arm's directions")


def as_captures(arm: ArmDescription, trainings: list[Training]) -> Captures:
    """Stack reaches for the kernels, padded with zeros to the longest."""
    frames = np.array([training.time.size for training in trainings])
    landmarks = np.zeros((len(trainings), frames.max(), len(arm.landmarks), 3))
    for row, training in enumerate(trainings):
        landmarks[row, : frames[row]] = training.landmarks
    return Captures(
        landmarks,
        frames,
        np.array(arm.landmark_frames),
        np.array([training.start for training in trainings]),
        np.array([training.target for training in trainings]),
    )
