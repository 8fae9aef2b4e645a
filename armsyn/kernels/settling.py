"""A hand's task, a position and perhaps how the hand is turned, and postures that do it.

`armsyn.planning.posing` says what a task is; here it is ``goal``, shape (3,); ``angles`` that are
asked for (0, 2 of a direction, 3 of a whole orientation); ``wanted``, shape (3, 3), the orientation
or, as its first row, the direction; and ``axis``, shape (3,), which points in the tip's frame.
"""

from __future__ import annotations

import math

import numpy as np

from armsyn.kernels.chain import ChainArrays, forward, jacobian
from armsyn.kernels.compiling import kernel
from armsyn.kernels.linear import solve_positive
from armsyn.kernels.plain import task_error
from armsyn.kernels.types import BoolArray, FloatArray

DAMPING = 1e-3
LARGEST_STEP = 0.3
PROGRESS, PATIENCE = 0.995, 8
"""Steps that bring less than that count as none; after so many of them there is nothing to come."""
CLOSE = 1e-5
"""m (with turns weighed by a share of the reach) that are there."""
TURN_SHARE = 0.3
"""Of the arm's reach, m, that a radian of the hand's turn weighs."""


@kernel
def task_left(
    chain: ChainArrays,
    goal: FloatArray,
    angles: int,
    wanted: FloatArray,
    axis: FloatArray,
    q: FloatArray,
    left: FloatArray,
    J: FloatArray,
) -> None:
    """Fill what is left of a task at posture q, shape (n,), and the Jacobian of it.

    Parameters
    ----------
    left : array, shape (3,) or (6,)
        Filled: m, then, of a task with angles, a rotation vector, rad.
    J : array, shape (3, n) or (6, n)
        Filled.
    """
    n = q.shape[0]
    origins, axes, tip = np.empty((n + 1, 3)), np.empty((n, 3)), np.empty((3, 3))
    forward(
        chain.rotation,
        chain.translation,
        chain.prismatic,
        q,
        np.empty(n),
        np.empty(n),
        origins,
        axes,
        tip,
    )
    jacobian(chain.prismatic, origins, axes, J)
    if angles == 3:
        task_error(goal, wanted, origins[n], tip, left)
        return
    for k in range(3):
        left[k] = goal[k] - origins[n, k]
    if angles == 2:
        _direction_left(wanted[0], axis, tip, left[3:], J[3:])


@kernel
def _direction_left(
    wanted: FloatArray, axis: FloatArray, tip: FloatArray, turn: FloatArray, J: FloatArray
) -> None:
    """Fill the turn to a direction, shape (3,); take turns about it out of J, shape (3, n)."""
    points, across = np.empty(3), np.empty(3)
    cosine = 0.0
    for i in range(3):
        points[i] = tip[i, 0] * axis[0] + tip[i, 1] * axis[1] + tip[i, 2] * axis[2]
        cosine += points[i] * wanted[i]
    _cross(points, wanted, across)
    sine = math.sqrt(across[0] ** 2 + across[1] ** 2 + across[2] ** 2)
    if sine < 1e-9 and cosine < 0.0:  # the other way: half a turn about any axis across
        least = 0
        for i in range(1, 3):
            if abs(points[i]) < abs(points[least]):
                least = i
        turn[:] = 0.0
        turn[least] = 1.0
        _cross(points, turn, across)
        length = math.sqrt(across[0] ** 2 + across[1] ** 2 + across[2] ** 2)
        scale = math.pi / length
    else:
        scale = math.atan2(sine, cosine) / max(sine, 1e-12)
    for i in range(3):
        turn[i] = across[i] * scale
    for j in range(J.shape[1]):
        along = points[0] * J[0, j] + points[1] * J[1, j] + points[2] * J[2, j]
        for i in range(3):
            J[i, j] -= points[i] * along


@kernel
def _cross(a: FloatArray, b: FloatArray, result: FloatArray) -> None:
    result[0] = a[1] * b[2] - a[2] * b[1]
    result[1] = a[2] * b[0] - a[0] * b[2]
    result[2] = a[0] * b[1] - a[1] * b[0]


@kernel
def settle(
    chain: ChainArrays,
    goal: FloatArray,
    angles: int,
    wanted: FloatArray,
    axis: FloatArray,
    reach: float,
    steps: int,
    best: FloatArray,
) -> None:
    """Move a posture, shape (n,), in place to one nearby in which the hand does its task best.

    See `armsyn.planning.posing.settled`; `reach` of the arm, m.
    """
    n, m = best.shape[0], 6 if angles else 3
    left, J, q = np.empty(m), np.empty((m, n)), np.empty(n)
    dq, B, y = np.empty(n), np.empty((m, m)), np.empty(m)
    free = np.ones(n, dtype=np.bool_)
    for j in range(n):
        q[j] = best[j] = min(max(best[j], chain.lower[j]), chain.upper[j])
    least, stale = np.inf, 0
    for _ in range(steps):
        task_left(chain, goal, angles, wanted, axis, q, left, J)
        left[3:] *= TURN_SHARE * reach
        J[3:] *= TURN_SHARE * reach
        miss = 0.0
        for i in range(m):
            miss += left[i] * left[i]
        miss = math.sqrt(miss)
        stale = 0 if miss < PROGRESS * least else stale + 1
        if miss < least:
            least = miss
            best[:] = q
        if miss < CLOSE or stale > PATIENCE:
            break
        damping = DAMPING * reach * min(1.0, miss / reach)
        _step(chain.lower, chain.upper, q, left, J, damping**2 + 1e-12, free, B, y, dq)
        for j in range(n):
            q[j] = min(max(q[j] + dq[j], chain.lower[j]), chain.upper[j])


@kernel
def _step(
    lower: FloatArray,
    upper: FloatArray,
    q: FloatArray,
    left: FloatArray,
    J: FloatArray,
    damping: float,
    free: BoolArray,
    B: FloatArray,
    y: FloatArray,
    dq: FloatArray,
) -> None:
    """Fill a damped least squares step; joints that press against their limits are left out.

    `free`, `B` and `y` are workspace.
    """
    m, n = J.shape
    free[:] = True
    for _ in range(n):
        for a in range(m):
            for b in range(a, m):
                total = damping if a == b else 0.0
                for j in range(n):
                    if free[j]:
                        total += J[a, j] * J[b, j]
                B[a, b] = B[b, a] = total
            y[a] = left[a]
        solve_positive(B, y)
        pressing = False
        for j in range(n):
            dq[j] = 0.0
            if free[j]:
                for a in range(m):
                    dq[j] += J[a, j] * y[a]
                if (q[j] <= lower[j] and dq[j] < 0.0) or (q[j] >= upper[j] and dq[j] > 0.0):
                    free[j] = False
                    pressing = True
        if not pressing:
            break
    largest = 1e-12
    for j in range(n):
        largest = max(largest, abs(dq[j]))
    dq *= min(1.0, LARGEST_STEP / largest)
