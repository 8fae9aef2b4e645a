"""A planar arm of .30 + .26 + .08 m for scores whose answer is known."""

import numpy as np
from numpy.typing import NDArray

from armsyn.motion import Motion

Array = NDArray[np.float64]
NAMES = ("shoulder", "elbow", "wrist", "hand")
LENGTHS = np.array([0.30, 0.26, 0.08])


def posture(upper_arm: Array, forearm: Array) -> Array:
    """Return landmarks (..., 4, 3) of arms whose segments point along directions (..., 3)."""
    ends = [LENGTHS[0] * upper_arm, LENGTHS[1] * forearm, LENGTHS[2] * forearm]
    return np.cumsum(np.stack([np.zeros_like(upper_arm), *ends], axis=-2), axis=-2)


def reach(
    *,
    duration: float = 1.0,
    rest: float = 0.4,
    rate: float = 100.0,
    swing: float = 0.9,
    skew: float = 1.0,
    side: float = 1.0,
) -> Motion:
    """Return a reach from hanging to forward; `side` mirrors where the elbow goes."""
    time = np.arange(round((duration + 2 * rest) * rate) + 1) / rate
    phase = np.clip((time - rest) / duration, 0, 1) ** skew
    share = 10 * phase**3 - 15 * phase**4 + 6 * phase**5
    landmarks = _raised(swing * share, side)
    return Motion(time=time, landmark_names=NAMES, landmarks=landmarks, source="reach")


def _raised(share: Array, side: float) -> Array:
    raised, bent, out = share, 0.4 + 0.9 * share, 0.5 * share * side
    upper_arm = np.stack(
        [np.sin(raised) * np.cos(out), np.sin(out), -np.cos(raised) * np.cos(out)], axis=-1
    )
    forearm = np.stack([np.sin(raised + bent), -np.sin(out), -np.cos(raised + bent)], axis=-1)
    return posture(upper_arm, forearm / np.linalg.norm(forearm, axis=-1, keepdims=True))


def still(landmarks: Array, duration: float = 1.0, rate: float = 100.0) -> Motion:
    time = np.arange(round(duration * rate) + 1) / rate
    return Motion(
        time=time,
        landmark_names=NAMES,
        landmarks=np.repeat(landmarks[None], time.size, axis=0),
        source="still",
    )


def with_landmarks(motion: Motion, landmarks: Array, rate: float = 100.0) -> Motion:
    """Return other landmarks, evenly sampled from time zero."""
    return Motion(
        time=np.arange(len(landmarks)) / rate,
        landmark_names=motion.landmark_names,
        landmarks=landmarks,
        source=motion.source,
    )
