"""Rotations as matrices: from roll-pitch-yaw, axis-angle and exponential map, and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError

FloatArray = NDArray[np.float64]


def from_rpy(rpy: ArrayLike) -> FloatArray:
    """Rotation matrix of URDF's fixed-axis roll, pitch, yaw.

    Parameters
    ----------
    rpy : array_like, shape (3,)
        Roll about x, pitch about y, yaw about z, all fixed axes, rad.

    Returns
    -------
    array, shape (3, 3)
        Rz(yaw) Ry(pitch) Rx(roll).
    """
    roll, pitch, yaw = np.asarray(rpy, dtype=np.float64)
    return np.asarray(
        from_expmap([0.0, 0.0, yaw]) @ from_expmap([0.0, pitch, 0.0]) @ from_expmap([roll, 0, 0])
    )


def to_rpy(rotation: ArrayLike) -> FloatArray:
    """Fixed-axis roll, pitch, yaw of a rotation matrix.

    The roll is found after the yaw is undone, so that ``from_rpy`` gives the matrix back to
    rounding even where pitch is +-pi/2 and only roll and yaw together are determined.

    Parameters
    ----------
    rotation : array_like, shape (..., 3, 3)
        Rz(yaw) Ry(pitch) Rx(roll).

    Returns
    -------
    array, shape (..., 3)
        Roll, pitch in [-pi/2, pi/2], yaw, rad.
    """
    R = np.asarray(rotation, dtype=np.float64)
    yaw = np.arctan2(R[..., 1, 0], R[..., 0, 0])
    pitch = np.arctan2(-R[..., 2, 0], np.hypot(R[..., 0, 0], R[..., 1, 0]))
    s, c = np.sin(yaw), np.cos(yaw)
    roll = np.arctan2(s * R[..., 0, 2] - c * R[..., 1, 2], c * R[..., 1, 1] - s * R[..., 0, 1])
    return np.stack([roll, pitch, yaw], axis=-1)


def from_expmap(rotation_vector: ArrayLike) -> FloatArray:
    """Rotation matrices of exponential maps (Rodrigues' formula).

    Parameters
    ----------
    rotation_vector : array_like, shape (..., 3)
        Axis times angle, rad.

    Returns
    -------
    array, shape (..., 3, 3)
    """
    w = np.asarray(rotation_vector, dtype=np.float64)
    angle = np.linalg.norm(w, axis=-1)[..., None, None]
    W = skew(w)
    # sin(a)/a and (1 - cos a)/a^2 as sinc, which is right at zero too
    first = np.sinc(angle / np.pi)
    second = 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2
    return np.asarray(np.eye(3) + first * W + second * (W @ W))


def skew(vector: ArrayLike) -> FloatArray:
    """Matrices [v]x with [v]x u = v x u; shape (..., 3) to (..., 3, 3)."""
    v = np.asarray(vector, dtype=np.float64)
    W = np.zeros((*v.shape, 3))
    W[..., 0, 1], W[..., 0, 2], W[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    W[..., 1, 0], W[..., 2, 0], W[..., 2, 1] = v[..., 2], -v[..., 1], v[..., 0]
    return W


def from_quaternion_xyzw(quaternion: ArrayLike) -> FloatArray:
    """Rotation matrices of unit quaternions in the order x, y, z, w; (..., 4) to (..., 3, 3)."""
    q = np.asarray(quaternion, dtype=np.float64)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    W = skew(q[..., :3])
    return np.asarray(np.eye(3) + 2.0 * q[..., 3, None, None] * W + 2.0 * (W @ W))


def turning_z_to(axis: ArrayLike) -> FloatArray:
    """Return the smallest rotation that takes the z axis to `axis`, shape (3, 3)."""
    x, y, z = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
    across = x * x + y * y
    if z < 0.0 and across < 1e-200:
        return np.diag([1.0, -1.0, -1.0])
    W = skew([-y, x, 0.0])
    # 1 / (1 + z), which near -z would lose all its digits
    inverse = (1.0 - z) / across if z < 0.0 else 1.0 / (1.0 + z)
    return np.asarray(np.eye(3) + W + (W @ W) * inverse)


def checked_rotation(orientation: ArrayLike) -> FloatArray:
    """Return a copy of a rotation matrix, shape (3, 3), contiguous.

    Raises
    ------
    InputError
        Another shape, not orthogonal to 1e-6, or a mirror.
    """
    R = np.array(orientation, dtype=np.float64, order="C")
    if R.shape != (3, 3) or not np.allclose(R @ R.T, np.eye(3), atol=1e-6):
        raise InputError("an orientation is a 3 x 3 rotation matrix")
    if np.linalg.det(R) < 0:
        raise InputError(
            "an orientation is a 3 x 3 rotation matrix, which must not mirror: its determinant is"
            " negative"
        )
    return R
