"""Forward kinematics and geometric Jacobian of a serial chain in its z-canonical form.

Every joint is described in a frame turned so that its axis is z, which leaves the variable
part of each joint a rotation of two columns (or a shift along the third).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.compiling import kernel

FloatArray = NDArray[np.float64]


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
    prismatic: NDArray[np.bool_]
    lower: FloatArray
    upper: FloatArray


class ChainState(NamedTuple):
    """What forward kinematics writes.

    Attributes
    ----------
    origins : array, shape (n + 1, 3)
        Positions of every joint's frame and, last, of the tip, in the base frame, m.
    axes : array, shape (n, 3)
        Joint axes in the base frame.
    frames : array, shape (n + 1, 3, 3)
        Orientations of the canonical frames (after the joint's own motion) and of the tip.
    """

    origins: FloatArray
    axes: FloatArray
    frames: FloatArray


@kernel
def forward(chain, q, state):  # type: ignore[no-untyped-def]
    """Fill `state` with the frames of `chain` at posture `q`, shape (n,)."""
    n = q.shape[0]
    r00 = r11 = r22 = 1.0
    r01 = r02 = r10 = r12 = r20 = r21 = 0.0
    x = y = z = 0.0
    for i in range(n + 1):
        t0 = chain.translation[i, 0]
        t1 = chain.translation[i, 1]
        t2 = chain.translation[i, 2]
        x += r00 * t0 + r01 * t1 + r02 * t2
        y += r10 * t0 + r11 * t1 + r12 * t2
        z += r20 * t0 + r21 * t1 + r22 * t2
        f00 = chain.rotation[i, 0, 0]
        f01 = chain.rotation[i, 0, 1]
        f02 = chain.rotation[i, 0, 2]
        f10 = chain.rotation[i, 1, 0]
        f11 = chain.rotation[i, 1, 1]
        f12 = chain.rotation[i, 1, 2]
        f20 = chain.rotation[i, 2, 0]
        f21 = chain.rotation[i, 2, 1]
        f22 = chain.rotation[i, 2, 2]
        a00 = r00 * f00 + r01 * f10 + r02 * f20
        a01 = r00 * f01 + r01 * f11 + r02 * f21
        a02 = r00 * f02 + r01 * f12 + r02 * f22
        a10 = r10 * f00 + r11 * f10 + r12 * f20
        a11 = r10 * f01 + r11 * f11 + r12 * f21
        a12 = r10 * f02 + r11 * f12 + r12 * f22
        a20 = r20 * f00 + r21 * f10 + r22 * f20
        a21 = r20 * f01 + r21 * f11 + r22 * f21
        a22 = r20 * f02 + r21 * f12 + r22 * f22
        r02 = a02
        r12 = a12
        r22 = a22
        if i < n:
            state.axes[i, 0] = a02
            state.axes[i, 1] = a12
            state.axes[i, 2] = a22
            if chain.prismatic[i]:
                x += a02 * q[i]
                y += a12 * q[i]
                z += a22 * q[i]
                r00 = a00
                r01 = a01
                r10 = a10
                r11 = a11
                r20 = a20
                r21 = a21
            else:
                c = math.cos(q[i])
                s = math.sin(q[i])
                r00 = a00 * c + a01 * s
                r01 = a01 * c - a00 * s
                r10 = a10 * c + a11 * s
                r11 = a11 * c - a10 * s
                r20 = a20 * c + a21 * s
                r21 = a21 * c - a20 * s
        else:
            r00 = a00
            r01 = a01
            r10 = a10
            r11 = a11
            r20 = a20
            r21 = a21
        state.origins[i, 0] = x
        state.origins[i, 1] = y
        state.origins[i, 2] = z
        frame = state.frames[i]
        frame[0, 0] = r00
        frame[0, 1] = r01
        frame[0, 2] = r02
        frame[1, 0] = r10
        frame[1, 1] = r11
        frame[1, 2] = r12
        frame[2, 0] = r20
        frame[2, 1] = r21
        frame[2, 2] = r22


@kernel
def jacobian(chain, state, J):  # type: ignore[no-untyped-def]
    """Fill the geometric Jacobian of the tip, shape (3, n) or (6, n): m/rad, then rad/rad."""
    m, n = J.shape
    ex = state.origins[n, 0]
    ey = state.origins[n, 1]
    ez = state.origins[n, 2]
    for i in range(n):
        ax = state.axes[i, 0]
        ay = state.axes[i, 1]
        az = state.axes[i, 2]
        if chain.prismatic[i]:
            J[0, i] = ax
            J[1, i] = ay
            J[2, i] = az
        else:
            dx = ex - state.origins[i, 0]
            dy = ey - state.origins[i, 1]
            dz = ez - state.origins[i, 2]
            J[0, i] = ay * dz - az * dy
            J[1, i] = az * dx - ax * dz
            J[2, i] = ax * dy - ay * dx
        if m == 6:
            turns = not chain.prismatic[i]
            J[3, i] = ax if turns else 0.0
            J[4, i] = ay if turns else 0.0
            J[5, i] = az if turns else 0.0


@kernel
def positions_along(chain, path):  # type: ignore[no-untyped-def]
    """Positions of all joints and the tip along `path`, (frames, n) to (frames, n + 1, 3), m."""
    frames, n = path.shape
    positions = np.empty((frames, n + 1, 3))
    state = ChainState(positions[0], np.empty((n, 3)), np.empty((n + 1, 3, 3)))
    for frame in range(frames):
        forward(chain, path[frame], ChainState(positions[frame], state.axes, state.frames))
    return positions
