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
    angle = np.linalg.norm(w, axis=-1, keepdims=True)
    length = np.linalg.norm(reference, axis=-1, keepdims=True)
    axis = np.divide(w, angle, out=np.zeros_like(w), where=angle > _NO_AXIS)
    other = np.divide(reference, length, out=np.zeros_like(w), where=length > _NO_AXIS)
    axis = np.where(angle > _NO_AXIS, axis, other)
    turns = np.round((np.sum(axis * reference, axis=-1, keepdims=True) - angle) / _TURN)
    return np.where(turns == 0.0, w, w + turns * _TURN * axis)


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
    before = path[0] if first is None else first
    for frame in range(len(path)):
        path[frame] = nearest_branch(path[frame], before)
        before = path[frame]
    return path


def unwrapped_poses(
    poses: FloatArray, turns: NDArray[np.int64], first: FloatArray | None = None
) -> FloatArray:
    """Unwrap the exponential maps among the columns of pose vectors, shape (frames, n).

    Parameters
    ----------
    poses : array, shape (frames, n)
    turns : array of int, shape (k,)
        First columns of the exponential maps.
    first : array, shape (n,), optional
        The pose whose branches the first frame takes.

    Returns
    -------
    array, shape (frames, n)
    """
    if not turns.size:
        return poses
    columns = turns[:, None] + np.arange(3)
    path = np.array(poses)
    path[:, columns] = unwrapped(poses[:, columns], None if first is None else first[columns])
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
