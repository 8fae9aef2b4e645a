"""Gaps: frames in which a landmark was not seen. Found always, filled only on request, and marked.

A gap is filled by the cubic spline through the frames on both sides of it. Nothing is filled
before the first or after the last frame in which a landmark was seen.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from armsyn.errors import InputError
from armsyn.motion.motion import BoolArray, FloatArray, Motion

NEIGHBOURS = 10
"""Seen frames on either side that the spline goes through."""
_FEWEST = 4  # points of a cubic
_ROUNDING = 1e-6  # of time stamps: 1.23 - 1.18 is more than 0.05


class Gap(NamedTuple):
    """Frames in which one landmark was not seen.

    Attributes
    ----------
    landmark : str
    first, last : int
        Frames, both included.
    seconds : float
        Between the frames on either side in which it was seen; infinite at the motion's ends.
    """

    landmark: str
    first: int
    last: int
    seconds: float


def find_gaps(motion: Motion) -> list[Gap]:
    """Return the gaps of a motion, landmark by landmark.

    Parameters
    ----------
    motion : Motion
        A landmark with any coordinate NaN was not seen.

    Returns
    -------
    list of Gap
        Empty when there are none, or no landmarks.
    """
    if motion.landmarks is None:
        return []
    unseen = np.array(np.isnan(motion.landmarks).any(axis=2))
    return [
        Gap(name, first, last, _seconds(motion.time, first, last))
        for name, column in zip(motion.landmark_names, unseen.T, strict=True)
        for first, last in _runs(column)
    ]


def _runs(unseen: BoolArray) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], unseen, [False]]).astype(np.int8)))
    return [(int(first), int(end) - 1) for first, end in edges.reshape(-1, 2)]


def _seconds(time: FloatArray, first: int, last: int) -> float:
    if first == 0 or last == time.size - 1:
        return np.inf
    return float(time[last + 1] - time[first - 1])


def fill_gaps(motion: Motion, longest: float) -> Motion:
    """Fill the gaps that are short enough, and mark where.

    Parameters
    ----------
    motion : Motion
    longest : float
        Seconds between the frames on either side of a gap; longer ones stay gaps.

    Returns
    -------
    Motion
        The same object when there is nothing to fill; else with `filled` set where positions were
        filled in, beside those that already were.

    Raises
    ------
    InputError
        When `longest` is not a positive number.
    """
    if not 0 < longest < np.inf:
        raise InputError(f"gaps of up to {longest:g} s: give a positive number of seconds")
    short = [gap for gap in find_gaps(motion) if gap.seconds <= longest * (1 + _ROUNDING)]
    if not short or motion.landmarks is None:
        return motion
    landmarks = np.array(motion.landmarks)
    filled = np.zeros(landmarks.shape[:2], dtype=np.bool_)
    if motion.filled is not None:
        filled |= motion.filled
    for gap in short:
        column = motion.landmark_names.index(gap.landmark)
        inside = slice(gap.first, gap.last + 1)
        found = _bridge(motion.time, motion.landmarks[:, column], gap)
        if found is not None:
            landmarks[inside, column] = found
            filled[inside, column] = True
    return dataclasses.replace(motion, landmarks=landmarks, filled=filled)


def _bridge(time: FloatArray, path: FloatArray, gap: Gap) -> FloatArray | None:
    """Positions inside a gap, or None where too few frames are seen around it."""
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  heavy, only filling needs it

    seen = np.flatnonzero(~np.isnan(path).any(axis=1))
    before, after = seen[seen < gap.first][-NEIGHBOURS:], seen[seen > gap.last][:NEIGHBOURS]
    around = np.concatenate([before, after])
    if around.size < _FEWEST:
        return None
    return np.asarray(CubicSpline(time[around], path[around])(time[gap.first : gap.last + 1]))
