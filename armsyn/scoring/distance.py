"""Distances between a captured motion and another one, on landmark positions, in metres.

All of them average over landmarks, the joints and once more the end effector, each with the weight
1 / (l + 1) for l joints: a plain mean over the landmarks of a motion.
"""

from __future__ import annotations

import numpy as np

from armsyn.errors import InputError
from armsyn.motion import FloatArray, Motion
from armsyn.motion.rebuilding import segment_lengths
from armsyn.scoring.pairing import Pair, Trimmed, pair_up

MOVING_EXTENT = 0.02
"""Share of the arm's length that a landmark must leave its place by to count as moving."""


def landmark_errors(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return how far apart the landmarks of two motions are.

    Parameters
    ----------
    first, second : array, shape (frames, landmarks, 3)
        m.

    Returns
    -------
    array, shape (frames, landmarks)
        m.

    Raises
    ------
    InputError
        When the shapes differ.
    """
    if first.shape != second.shape or first.ndim != 3 or first.shape[2] != 3:
        raise InputError(f"landmarks of shapes {first.shape} and {second.shape} do not compare")
    return np.asarray(np.linalg.norm(first - second, axis=2))


def mean_distance(first: FloatArray, second: FloatArray) -> float:
    """Return the paper's distance of two motions that already have one frame rate.

    Parameters
    ----------
    first, second : array, shape (frames, landmarks, 3)
        m, joints first, the end effector last; the longer is read to the end of the shorter.

    Returns
    -------
    float
        m: mean over frames of the sum over landmarks, each weighted 1 / (l + 1).

    Raises
    ------
    InputError
        When landmarks do not fit, or there are no frames.

    References
    ----------
    First paper, section on the metric between motions; its truncation to the shorter motion can
    be gamed, so `held_distance` stands beside it.
    """
    frames = min(len(first), len(second))
    if frames == 0:
        raise InputError("a distance needs at least one frame of each motion")
    return float(landmark_errors(first[:frames], second[:frames]).mean())


def paper_distance(captured: Motion, other: Motion, rate: float | None = None) -> float:
    """Return the paper's distance: one frame rate for both, stop at the shorter.

    Parameters
    ----------
    captured, other : Motion
        With landmarks, in one frame.
    rate : float or None
        Hz; None takes the higher of the two mean rates.

    Returns
    -------
    float
        m.

    Raises
    ------
    FormatError, InputError, CaptureError
        When the motions cannot be paired or resampled.
    """
    pair = pair_up(captured, other)
    rate = pair.rate if rate is None else rate
    return mean_distance(pair.captured.evenly(rate), pair.other.evenly(rate))


def coverage(pair: Pair) -> float:
    """Return the duration of the shorter motion over that of the longer.

    Parameters
    ----------
    pair : Pair
        Two motions.

    Returns
    -------
    float
        0 to 1.
    """
    durations = sorted([pair.captured.duration, pair.other.duration])
    return durations[0] / durations[1]


def held_errors(trimmed: Trimmed) -> FloatArray:
    """Return each landmark's held error.

    The motion that ends first holds its last posture; the sum over the longer is divided by the
    frames of the *captured* one, so that idling, before or after, never pays. Known limit: a motion
    that takes 1.5 times as long as the captured one is charged for longer and can still gain by
    stopping half-way (0.130 against 0.153 m); the endpoint error, always shown beside it, tells.

    Parameters
    ----------
    trimmed : Trimmed
        Both motions from onset to offset.

    Returns
    -------
    array, shape (landmarks,)
        m; their mean is the held distance.
    """
    parts = trimmed.captured.landmarks, trimmed.other.landmarks
    frames = max(len(part) for part in parts)
    held = [np.concatenate([part, part[-1:].repeat(frames - len(part), axis=0)]) for part in parts]
    return np.asarray(landmark_errors(*held).sum(axis=0) / len(parts[0]))


def held_distance(trimmed: Trimmed) -> float:
    """Return the held distance, the headline; see `held_errors`.

    Parameters
    ----------
    trimmed : Trimmed
        Both motions from onset to offset.

    Returns
    -------
    float
        m.
    """
    return float(held_errors(trimmed).mean())


def normalised_distance(trimmed: Trimmed) -> float:
    """Return the distance over normalised time, blind to how long the movements take.

    Parameters
    ----------
    trimmed : Trimmed
        Both motions from onset to offset.

    Returns
    -------
    float
        m; mean over 101 samples.
    """
    return mean_distance(trimmed.captured.normalised, trimmed.other.normalised)


def arm_length(landmarks: FloatArray) -> float:
    """Return the length of the chain of landmarks, from the first to the end effector.

    Parameters
    ----------
    landmarks : array, shape (frames, landmarks, 3)
        m, in the order of the chain.

    Returns
    -------
    float
        m, the sum of the segments' median lengths; 0 for a single landmark.
    """
    return float(segment_lengths(landmarks).sum())


def distance_per_arm_length(trimmed: Trimmed) -> float:
    """Return the held distance over the landmarks that move, in arm lengths.

    Which ones move is read from the captured motion alone: a motion must not dilute its errors by
    moving more joints.

    Parameters
    ----------
    trimmed : Trimmed
        Both motions from onset to offset.

    Returns
    -------
    float
        Dimensionless; NaN when there is no arm to measure (a hand alone).
    """
    captured = trimmed.captured.landmarks
    length = arm_length(captured)
    if length == 0:
        return float("nan")
    extent = np.linalg.norm(captured - captured[:1], axis=2).max(axis=0)
    moving = extent > MOVING_EXTENT * length
    if not moving.any():
        return float("nan")
    return float(held_errors(trimmed)[moving].mean()) / length
