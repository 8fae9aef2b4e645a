"""Unit quaternions in the order x, y, z, w: from Euler angles and matrices, to exponential maps."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


def from_euler(axes: str, angles: ArrayLike) -> FloatArray:
    """Quaternions of rotations about coordinate axes, multiplied from left to right.

    Parameters
    ----------
    axes : str
        Some of ``x``, ``y``, ``z``, such as ``zyx``: Rz Ry Rx, which turns about the moving axes
        z, y, x in this order.
    angles : array_like, shape (..., len(axes))
        One an axis, rad.

    Returns
    -------
    array, shape (..., 4)
        Of unit length; no axes give the identity.
    """
    values = np.asarray(angles, dtype=np.float64)
    q = np.zeros((4, *values.shape[:-1]))
    q[3] = 1.0
    for place, axis in enumerate(axes):
        i = "xyz".index(axis)
        j, k = (i + 1) % 3, (i + 2) % 3
        sine, cosine = np.sin(0.5 * values[..., place]), np.cos(0.5 * values[..., place])
        # q after a turn about axis i alone: most terms of the product are zero
        q[i], q[3] = q[i] * cosine + q[3] * sine, q[3] * cosine - q[i] * sine
        q[j], q[k] = q[j] * cosine + q[k] * sine, q[k] * cosine - q[j] * sine
    return np.moveaxis(q, 0, -1)


def from_expmap(rotation_vector: ArrayLike) -> FloatArray:
    """Unit quaternions of exponential maps of any length.

    Parameters
    ----------
    rotation_vector : array_like, shape (..., 3)
        Axis times angle, rad.

    Returns
    -------
    array, shape (..., 4)
    """
    w = np.asarray(rotation_vector, dtype=np.float64)
    half = 0.5 * np.linalg.norm(w, axis=-1, keepdims=True)
    return np.concatenate([0.5 * np.sinc(half / np.pi) * w, np.cos(half)], axis=-1)


def sign_continuous(quaternions: ArrayLike) -> FloatArray:
    """Choose the signs along a path so that neighbours lie on the same half of the sphere.

    Parameters
    ----------
    quaternions : array_like, shape (frames, ..., 4)

    Returns
    -------
    array, shape (frames, ..., 4)
        The first frame as it was.
    """
    q = np.array(quaternions, dtype=np.float64)
    opposed = np.sum(q[1:] * q[:-1], axis=-1) < 0.0
    q[1:][np.cumsum(opposed, axis=0) % 2 == 1] *= -1.0
    return q


def slerp(first: ArrayLike, second: ArrayLike, share: ArrayLike) -> FloatArray:
    """Spherical linear interpolation (Shoemake 1985) along the arc that the signs choose.

    Parameters
    ----------
    first, second : array_like, shape (..., 4)
        Of unit length.
    share : array_like, broadcast to (...)
        0 at the first, 1 at the second.

    Returns
    -------
    array, shape (..., 4)
        Of unit length.
    """
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    t = np.asarray(share, dtype=np.float64)[..., None]
    # The angle between them from both chords: exact near zero and near opposite
    angle = 2.0 * np.arctan2(
        np.linalg.norm(a - b, axis=-1, keepdims=True),
        np.linalg.norm(a + b, axis=-1, keepdims=True),
    )
    sine = np.sinc(angle / np.pi)
    straight = np.abs(sine) < 1e-12
    divisor = np.where(straight, 1.0, sine)
    left = (1.0 - t) * np.sinc((1.0 - t) * angle / np.pi) / divisor
    right = t * np.sinc(t * angle / np.pi) / divisor
    q = np.where(straight, np.where(t < 0.5, a, b), left * a + right * b)
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def to_expmap(quaternion: ArrayLike) -> FloatArray:
    """Exponential maps (axis times angle) of unit quaternions.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Either sign.

    Returns
    -------
    array, shape (..., 3)
        rad, no longer than pi.
    """
    q = np.asarray(quaternion, dtype=np.float64)
    q = np.where(q[..., 3:] < 0.0, -q, q)
    sine = np.linalg.norm(q[..., :3], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., 3:])
    # Near the identity angle / sine tends to 2
    ratio = np.divide(angle, sine, out=np.full_like(sine, 2.0), where=sine > 1e-12)
    return np.asarray(q[..., :3] * ratio)


def from_matrix(rotation: ArrayLike) -> FloatArray:
    """Quaternions of rotation matrices.

    Of the four ways to write one, each divided by another component, the one with the largest
    divisor is taken (Shepperd 1978), so that no digits are lost at any angle.

    Parameters
    ----------
    rotation : array_like, shape (..., 3, 3)

    Returns
    -------
    array, shape (..., 4)
        Of unit length.
    """
    R = np.asarray(rotation, dtype=np.float64)
    trace = np.trace(R, axis1=-2, axis2=-1)
    # Row i of K is 4 q_i q: symmetric, and its diagonal 4 q_i^2 says which row is the best
    K = np.empty((*R.shape[:-2], 4, 4))
    K[..., :3, :3] = R + R.swapaxes(-1, -2)
    for axis in range(3):
        K[..., axis, axis] = 1.0 - trace + 2.0 * R[..., axis, axis]
    K[..., 3, 3] = 1.0 + trace
    K[..., 3, 0] = K[..., 0, 3] = R[..., 2, 1] - R[..., 1, 2]
    K[..., 3, 1] = K[..., 1, 3] = R[..., 0, 2] - R[..., 2, 0]
    K[..., 3, 2] = K[..., 2, 3] = R[..., 1, 0] - R[..., 0, 1]
    best = np.argmax(np.diagonal(K, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(K, best[..., None, None], axis=-2)[..., 0, :]
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))
