"""Exponential maps past pi: one branch along time and across motions.

w and (1 - 2 pi / |w|) w are the same rotation, so 175 and 185 degrees may stand beside each other
as 175 and -175, whose mean is 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
_TURN = 2.0 * np.pi
_NO_AXIS = 1e-6
"""rad; below it the axis of a rotation is that of its neighbour."""


def nearest_branch(w: FloatArray, reference: FloatArray) -> FloatArray:
    """Return the exponential maps of the same rotations that lie nearest to others.

    Parameters
    ----------
    w, reference : array, shape (..., 3)
        rad, of any length.

    Returns
    -------
    array, shape (..., 3)
        rad; `w` itself, to the bit, where it is the nearest already.
    """
    axis, turns = _whole_turns(w, reference)
    return np.where(turns == 0.0, w, w + turns * _TURN * axis)


def _whole_turns(w: FloatArray, reference: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Axes, and how many turns about them lead from w to nearest the reference."""
    angle = np.sqrt(np.sum(w * w, axis=-1, keepdims=True))
    length = np.sqrt(np.sum(reference * reference, axis=-1, keepdims=True))
    axis = np.divide(w, angle, out=np.zeros_like(w), where=angle > _NO_AXIS)
    other = np.divide(reference, length, out=np.zeros_like(w), where=length > _NO_AXIS)
    axis = np.where(angle > _NO_AXIS, axis, other)
    turns = np.round((np.sum(axis * reference, axis=-1, keepdims=True) - angle) / _TURN)
    return axis, turns


def unwrapped(w: FloatArray, first: FloatArray | None = None) -> FloatArray:
    """Return exponential maps along a path without jumps between branches.

    Parameters
    ----------
    w : array, shape (frames, ..., 3)
        rad.
    first : array, shape (..., 3), optional
        What the first frame shall lie nearest to; itself by default.

    Returns
    -------
    array, shape (frames, ..., 3)
        rad, each frame on the branch nearest to the frame before.
    """
    path = np.array(w)
    if first is not None:
        path[0] = nearest_branch(path[0], first)
    while True:
        _, turns = _whole_turns(path[1:], path[:-1])
        jumps = np.flatnonzero(turns.reshape(len(turns), -1).any(axis=-1))
        if not jumps.size:
            return path
        # Most paths have no jump at all; after one, the next frames tend to jump as well
        for frame in range(int(jumps[0]) + 1, len(path)):
            path[frame] = nearest_branch(path[frame], path[frame - 1])


def unwrapped_poses(
    poses: FloatArray, turns: NDArray[np.int64], first: FloatArray | None = None
) -> FloatArray:
    """Unwrap the exponential maps among the columns of pose vectors.

    Parameters
    ----------
    poses : array, shape (frames, ..., n)
    turns : array of int, shape (k,)
        First columns of the exponential maps.
    first : array, shape (n,), optional
        The pose whose branches the first frame takes.

    Returns
    -------
    array, shape (frames, ..., n)
    """
    if not turns.size:
        return poses
    columns = turns[:, None] + np.arange(3)
    path = np.array(poses)
    start = None if first is None else first[..., columns]
    path[..., columns] = unwrapped(poses[..., columns], start)
    return path


def rewrapped_poses(
    poses: FloatArray, turns: NDArray[np.int64], captured: FloatArray
) -> FloatArray:
    """Return poses, shape (frames, n), on the branches of captured ones, frame by frame."""
    if not turns.size:
        return poses
    columns = turns[:, None] + np.arange(3)
    path = np.array(poses)
    path[:, columns] = nearest_branch(poses[:, columns], captured[:, columns])
    return path
