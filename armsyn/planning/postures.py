"""Inverse kinematics of many reaches at once: the posture next to a given one that is there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain

FloatArray = NDArray[np.float64]

TOLERANCE_M = 1e-5
MOST_STEPS = 60
_LONGEST_STEP = 0.1
"""Of the chain's reach: beyond, the linearisation does not hold."""
_DAMPING = 1e-2
"""Of the remaining error: full damping far from the target, none at it (Levenberg-Marquardt)."""


def postures_at(
    chain: SerialChain, near: FloatArray, targets: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Lead postures to where their hands are at the targets, by damped least-squares steps.

    The least change of posture, in steps; joints are clamped to their limits, and one that
    presses against its limit is left out of a step (Baerlocher and Boulic 2004).

    Parameters
    ----------
    chain : SerialChain
    near : array, shape (M, n)
        Postures to start from, rad or m.
    targets : array, shape (M, 3)
        Base frame, m.

    Returns
    -------
    postures : array, shape (M, n)
        Within the limits; the last ones come to where a target is out of reach.
    errors : array, shape (M,)
        Distance of the hand to the target, m.
    """
    q = np.clip(near, chain.lower, chain.upper)
    gap = targets - tips(chain, q)
    errors = np.linalg.norm(gap, axis=1)
    active = np.flatnonzero(errors > TOLERANCE_M)
    for _ in range(MOST_STEPS):
        if not active.size:
            break
        dX = _shortened(gap[active], errors[active], _LONGEST_STEP * chain.reach)
        q[active] = _stepped(chain, q[active], dX)
        gap[active] = targets[active] - tips(chain, q[active])
        errors[active] = np.linalg.norm(gap[active], axis=1)
        active = active[errors[active] > TOLERANCE_M]
    return q, errors


def tips(chain: SerialChain, q: FloatArray) -> FloatArray:
    """Return where the tips of postures, shape (M, n), are, shape (M, 3), m."""
    return np.asarray(chain.positions(q)[:, -1])


def _shortened(dX: FloatArray, length: FloatArray, longest: float) -> FloatArray:
    return np.asarray(dX * np.minimum(1.0, longest / np.maximum(length, 1e-12))[:, None])


def _stepped(chain: SerialChain, q: FloatArray, dX: FloatArray) -> FloatArray:
    J = jacobians(chain, q)
    free = np.ones_like(q)
    for _ in range(2):
        dq = _damped_step(J * free[:, None, :], dX)
        moved = q + dq
        pressed = ((q <= chain.lower) & (dq < 0)) | ((q >= chain.upper) & (dq > 0))
        if not pressed.any():
            break
        free[pressed] = 0.0
    return np.clip(moved, chain.lower, chain.upper)


def _damped_step(J: FloatArray, dX: FloatArray) -> FloatArray:
    """J^T (J J^T + mu^2 I)^-1 dX (Wampler 1986), mu shrinking with the error."""
    B = J @ J.transpose(0, 2, 1)
    mu2 = _DAMPING * (dX**2).sum(axis=1) + 1e-10
    B[:, [0, 1, 2], [0, 1, 2]] += mu2[:, None]
    y = np.linalg.solve(B, dX[..., None])
    return np.asarray((J.transpose(0, 2, 1) @ y)[..., 0])


def jacobians(chain: SerialChain, q: FloatArray) -> FloatArray:
    """Geometric Jacobians of the tip.

    Parameters
    ----------
    chain : SerialChain
    q : array, shape (M, n)
        Postures, rad or m.

    Returns
    -------
    array, shape (M, 3, n)
        Base frame, m/rad (m/m for prismatic joints).
    """
    arrays, count = chain.arrays, len(q)
    origins, axes = np.empty((2, chain.dof, count, 3))
    turn = np.broadcast_to(np.eye(3), (count, 3, 3))
    place = np.zeros((count, 3))
    for i in range(chain.dof):
        place = place + turn @ arrays.translation[i]
        turn = turn @ arrays.rotation[i]
        axes[i] = turn[:, :, 2]
        if arrays.prismatic[i]:
            place = place + axes[i] * q[:, i, None]
        else:
            turn = _turned(turn, q[:, i])
        origins[i] = place
    tip = place + turn @ arrays.translation[-1]
    J = np.cross(axes, tip - origins)
    J[arrays.prismatic] = axes[arrays.prismatic]
    return np.ascontiguousarray(J.transpose(1, 2, 0))


def _turned(turn: FloatArray, angle: FloatArray) -> FloatArray:
    """Rotations, shape (M, 3, 3), followed by one about their own z, rad."""
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y, z = turn[:, :, 0], turn[:, :, 1], turn[:, :, 2]
    return np.stack([x * cosine + y * sine, y * cosine - x * sine, z], axis=2)
