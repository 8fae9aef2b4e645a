"""Forward kinematics and geometric Jacobian of a serial chain in its z-canonical form.

Every joint is described in a frame turned so that its axis is z, which leaves the variable
part of each joint a rotation of two columns (or a shift along the third).

Kernels that run inside a step take plain arrays: a tuple of arrays handed from kernel to kernel
costs a reference count for each, which made a step three times slower.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from armsyn.kernels.compiling import kernel
from armsyn.kernels.trigonometry import sines_and_cosines
from armsyn.kernels.types import BoolArray, FloatArray


class ChainArrays(NamedTuple):
    """A serial chain as kernels see it.

    Attributes
    ----------
    rotation : array, shape (n + 1, 3, 3)
        Fixed rotation from canonical frame i - 1 (the base for i = 0) to i; the last is the tip.
    translation : array, shape (n + 1, 3)
        Fixed translation in canonical frame i - 1, m; the last is the tip.
    prismatic : array of bool, shape (n,)
        Joints that slide along z instead of turning about it.
    lower, upper : array, shape (n,)
        Joint limits, rad or m.
    """

    rotation: FloatArray
    translation: FloatArray
    prismatic: BoolArray
    lower: FloatArray
    upper: FloatArray


@kernel
def forward(
    rotation: FloatArray,
    translation: FloatArray,
    prismatic: BoolArray,
    q: FloatArray,
    sines: FloatArray,
    cosines: FloatArray,
    origins: FloatArray,
    axes: FloatArray,
    tip: FloatArray,
) -> None:
    """Forward kinematics of posture q, shape (n,).

    Fills `origins`, shape (n + 1, 3), positions of every joint and the tip, m; `axes`, shape
    (n, 3), the joints' axes; and `tip`, shape (3, 3), the tip's orientation (not worked out for
    one of shape (0, 0)); all in the base frame. `sines` and `cosines`, shape (n,), are workspace.
    """
    n = axes.shape[0]
    sines_and_cosines(q, sines, cosines)
    r00 = r11 = r22 = 1.0
    r01 = r02 = r10 = r12 = r20 = r21 = 0.0
    x = y = z = 0.0
    for i in range(n + 1):
        t0 = translation[i, 0]
        t1 = translation[i, 1]
        t2 = translation[i, 2]
        x += r00 * t0 + r01 * t1 + r02 * t2
        y += r10 * t0 + r11 * t1 + r12 * t2
        z += r20 * t0 + r21 * t1 + r22 * t2
        if i == n:
            origins[i, 0] = x
            origins[i, 1] = y
            origins[i, 2] = z
            if tip.shape[0] == 0:
                return
        f00 = rotation[i, 0, 0]
        f01 = rotation[i, 0, 1]
        f02 = rotation[i, 0, 2]
        f10 = rotation[i, 1, 0]
        f11 = rotation[i, 1, 1]
        f12 = rotation[i, 1, 2]
        f20 = rotation[i, 2, 0]
        f21 = rotation[i, 2, 1]
        f22 = rotation[i, 2, 2]
        a00 = r00 * f00 + r01 * f10 + r02 * f20
        a01 = r00 * f01 + r01 * f11 + r02 * f21
        a02 = r00 * f02 + r01 * f12 + r02 * f22
        a10 = r10 * f00 + r11 * f10 + r12 * f20
        a11 = r10 * f01 + r11 * f11 + r12 * f21
        a12 = r10 * f02 + r11 * f12 + r12 * f22
        a20 = r20 * f00 + r21 * f10 + r22 * f20
        a21 = r20 * f01 + r21 * f11 + r22 * f21
        a22 = r20 * f02 + r21 * f12 + r22 * f22
        s = 0.0
        c = 1.0
        if i < n:
            axes[i, 0] = a02
            axes[i, 1] = a12
            axes[i, 2] = a22
            if prismatic[i]:
                x += a02 * q[i]
                y += a12 * q[i]
                z += a22 * q[i]
            else:
                s = sines[i]
                c = cosines[i]
            origins[i, 0] = x
            origins[i, 1] = y
            origins[i, 2] = z
        r00 = a00 * c + a01 * s
        r01 = a01 * c - a00 * s
        r02 = a02
        r10 = a10 * c + a11 * s
        r11 = a11 * c - a10 * s
        r12 = a12
        r20 = a20 * c + a21 * s
        r21 = a21 * c - a20 * s
        r22 = a22
    tip[0, 0] = r00
    tip[0, 1] = r01
    tip[0, 2] = r02
    tip[1, 0] = r10
    tip[1, 1] = r11
    tip[1, 2] = r12
    tip[2, 0] = r20
    tip[2, 1] = r21
    tip[2, 2] = r22


@kernel
def jacobian(prismatic: BoolArray, origins: FloatArray, axes: FloatArray, J: FloatArray) -> None:
    """Fill the geometric Jacobian of the tip, shape (3, n) or (6, n): m/rad, then rad/rad."""
    m, n = J.shape
    ex = origins[n, 0]
    ey = origins[n, 1]
    ez = origins[n, 2]
    # As if every joint turned: without a branch the loop runs several joints at a time
    for i in range(n):
        dx = ex - origins[i, 0]
        dy = ey - origins[i, 1]
        dz = ez - origins[i, 2]
        J[0, i] = axes[i, 1] * dz - axes[i, 2] * dy
        J[1, i] = axes[i, 2] * dx - axes[i, 0] * dz
        J[2, i] = axes[i, 0] * dy - axes[i, 1] * dx
    for k in range(3, m):
        for i in range(n):
            J[k, i] = axes[i, k - 3]
    for i in range(n):
        if prismatic[i]:
            for k in range(3):
                J[k, i] = axes[i, k]
            for k in range(3, m):
                J[k, i] = 0.0


@kernel
def positions_along(chain: ChainArrays, path: FloatArray) -> FloatArray:
    """Positions of all joints and the tip along `path`, (frames, n) to (frames, n + 1, 3), m."""
    frames, n = path.shape
    positions = np.empty((frames, n + 1, 3))
    # Padded to whole vectors, else seven sines are worked out one by one
    q = np.zeros((n + 7) // 8 * 8)
    sines, cosines = np.empty_like(q), np.empty_like(q)
    axes = np.empty((n, 3))
    tip = np.empty((0, 0))
    for frame in range(frames):
        for i in range(n):
            q[i] = path[frame, i]
        forward(
            chain.rotation,
            chain.translation,
            chain.prismatic,
            q,
            sines,
            cosines,
            positions[frame],
            axes,
            tip,
        )
    return positions


@kernel
def jacobian_at(chain: ChainArrays, q: FloatArray, J: FloatArray) -> None:
    """Fill the geometric Jacobian of the tip at posture q, shape (3, n) or (6, n)."""
    n = q.shape[0]
    origins = np.empty((n + 1, 3))
    axes = np.empty((n, 3))
    forward(
        chain.rotation,
        chain.translation,
        chain.prismatic,
        q,
        np.empty(n),
        np.empty(n),
        origins,
        axes,
        np.empty((0, 0)),
    )
    jacobian(chain.prismatic, origins, axes, J)
