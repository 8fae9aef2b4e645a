"""Self-motions of a chain: the hand goes on doing its task while the other joints move.

Tasks are as in `armsyn.kernels.settling`.
"""

from __future__ import annotations

import math

import numpy as np

from armsyn.kernels.chain import ChainArrays, forward
from armsyn.kernels.compiling import kernel
from armsyn.kernels.linear import eigen_symmetric, gram
from armsyn.kernels.settling import settle, task_left
from armsyn.kernels.types import FloatArray

FREE = 1e-3
"""Share of the greatest speed of the hand, or of the arm's reach, below which nothing moves."""
SHORT_M, TURNED = 5e-4, 5e-3
"""What the hand may miss on its way, m and rad."""
STEP = 0.1
"""rad of the joint that turns most."""
_SETTLING = 8


@kernel
def next_swivel(
    chain: ChainArrays,
    goal: FloatArray,
    angles: int,
    wanted: FloatArray,
    axis: FloatArray,
    reach: float,
    origins: FloatArray,
    least: float,
    steps: int,
    q: FloatArray,
    direction: FloatArray,
) -> tuple[int, float]:
    """Go on along a self-motion, in place, until some joint is so far from where it was.

    Parameters
    ----------
    reach : float
        Of the arm, m.
    origins : array, shape (n + 1, 3)
        Where the joints were, m.
    least : float
        How far the one that moved most is to be from there, m.
    steps : int
        At most.
    q : array, shape (n,)
        Posture, in which the hand does its task.
    direction : array, shape (n,)
        Where to go on to; all 0 where there is nowhere.

    Returns
    -------
    tuple of (int, float)
        Steps that are left, and how far that joint is, m; negative where the way ends before.
    """
    n, m = q.shape[0], 6 if angles else 3
    left, J = np.empty(m), np.empty((m, n))
    there, onward, places = np.empty(n), np.empty(n), np.empty((n + 1, 3))
    while steps > 0 and np.abs(direction).max() > 0.0:
        steps -= 1
        for j in range(n):
            there[j] = q[j] + STEP * direction[j]
        settle(chain, goal, angles, wanted, axis, reach, _SETTLING, there)
        task_left(chain, goal, angles, wanted, axis, there, left, J)
        gone = np.abs(there - q).max()
        if norm(left[:3]) > SHORT_M or norm(left[3:]) > TURNED or gone < 0.2 * STEP:
            break
        q[:] = there
        self_motion(chain, J, reach, q, onward, places)
        along = 0.0
        for j in range(n):
            along += onward[j] * direction[j]
        for j in range(n):
            direction[j] = onward[j] if along >= 0.0 else -onward[j]
        moved = 0.0
        for i in range(n + 1):
            moved = max(moved, norm(places[i] - origins[i]))
        if moved >= least:
            return steps, moved
    return steps, -1.0


@kernel
def self_motion(
    chain: ChainArrays,
    J: FloatArray,
    reach: float,
    q: FloatArray,
    direction: FloatArray,
    origins: FloatArray,
) -> None:
    """Fill the change of posture that leaves the hand's task and moves the joints most.

    Parameters
    ----------
    J : array, shape (m, n)
        Jacobian of the task.
    direction : array, shape (n,)
        Filled: its greatest entry is 1; all 0 where nothing can move.
    origins : array, shape (n + 1, 3)
        Filled: of the joints, and the tip, m.
    """
    n = q.shape[0]
    B, V = np.empty((n, n)), np.empty((n, n))
    gram(np.ascontiguousarray(J.T), B)
    eigen_symmetric(B, V)
    most = 0.0
    for j in range(n):
        most = max(most, B[j, j])
    free = [j for j in range(n) if B[j, j] <= FREE * FREE * most]
    direction[:] = 0.0
    W = joint_speeds(chain, q, origins)
    A, mixes = np.zeros((len(free), len(free))), np.empty((len(free), len(free)))
    for a in range(len(free)):
        for b in range(len(free)):
            for i in range(n):
                for j in range(n):
                    A[a, b] += V[i, free[a]] * W[i, j] * V[j, free[b]]
    eigen_symmetric(A, mixes)
    best = 0
    for a in range(len(free)):
        best = a if A[a, a] > A[best, best] else best
    if not free or A[best, best] < (FREE * reach) ** 2:  # the hand's own roll, which moves nothing
        return
    for a in range(len(free)):
        direction += mixes[a, best] * V[:, free[a]]
    direction /= direction[np.argmax(np.abs(direction))]


@kernel
def joint_speeds(chain: ChainArrays, q: FloatArray, origins: FloatArray) -> FloatArray:
    """Return W, shape (n, n): v^T W v is the sum of the joints' squared speeds, (m/rad)^2.

    Fills `origins`, shape (n + 1, 3), where the joints and the tip are, m.
    """
    n = q.shape[0]
    axes, work = np.empty((n, 3)), np.empty((2, n))
    tip = np.empty((0, 0))
    forward(
        chain.rotation,
        chain.translation,
        chain.prismatic,
        q,
        work[0],
        work[1],
        origins,
        axes,
        tip,
    )
    W, speeds, squares = np.zeros((n, n)), np.zeros((n, 3)), np.empty((n, n))
    for i in range(n + 1):
        for j in range(min(i + 1, n)):  # the speed of joint i's origin, of joint j
            x, y, z = axes[j]
            if not chain.prismatic[j]:
                dx, dy, dz = origins[i] - origins[j]
                x, y, z = y * dz - z * dy, z * dx - x * dz, x * dy - y * dx
            speeds[j, 0], speeds[j, 1], speeds[j, 2] = x, y, z
        gram(speeds, squares)
        W += squares
    return W


@kernel
def norm(vector: FloatArray) -> float:
    """Length of a vector; 0 of an empty one."""
    total = 0.0
    for k in range(vector.shape[0]):
        total += vector[k] * vector[k]
    return math.sqrt(total)
