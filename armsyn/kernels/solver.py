"""Inverse kinematics as a descent: an optimiser's direction, the best step along it.

The transposes are steepest descent, whose best steps zigzag across the valleys of a pose task;
steps a tenth shorter than the best break the zigzag (Raydan and Svaiter 2002, relaxed steepest
descent). A descent also ends where the posture stands still: in a local minimum, mostly at limits.
"""

from __future__ import annotations

import math

import numpy as np

from armsyn.kernels.chain import ChainArrays, forward, jacobian
from armsyn.kernels.compiling import kernel
from armsyn.kernels.optimisers import (
    NORMALISED_TRANSPOSE,
    TRANSPOSE,
    OptimiserSettings,
    change_of_posture,
    weigh_orientation,
)
from armsyn.kernels.plain import task_error
from armsyn.kernels.types import FloatArray

_LARGEST_TURN = 0.3
_RELAXATION = 0.9
_STANDSTILL = 1e-4
"""Share of the tolerance below which the greatest joint movement of a step ends a descent."""


@kernel
def descend(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    position: FloatArray,
    orientation: FloatArray,
    largest_move: float,
    tolerance: float,
    max_steps: int,
    q: FloatArray,
) -> tuple[int, float, float]:
    """Move posture q, shape (n,), to the best one met on the way to the target.

    Returns
    -------
    tuple of (int, float, float)
        Steps made, and at that posture the distance, m, and angle, rad, to the target.
    """
    n = q.shape[0]
    zigzags = optimiser.kind in (TRANSPOSE, NORMALISED_TRANSPOSE)
    m = 6 if orientation.shape[0] == 3 else 3
    rotation, translation, prismatic, lower, upper = chain
    sines, cosines = np.empty(n), np.empty(n)
    axes, tip = np.empty((n, 3)), np.empty((m - 3, m - 3))
    origins = np.empty((n + 1, 3))
    J, dX, dq = np.empty((m, n)), np.empty(m), np.empty(n)
    B, V, y = np.empty((m, m)), np.empty((m, m)), np.empty(m)
    best = q.copy()
    best_distance = best_angle = math.inf
    steps = 0
    for iteration in range(max_steps + 1):
        forward(rotation, translation, prismatic, q, sines, cosines, origins, axes, tip)
        distance = task_error(position, orientation, origins[n], tip, dX)
        angle = 0.0
        for k in range(3, m):
            angle += dX[k] * dX[k]
        angle = math.sqrt(angle)
        if distance + angle < best_distance + best_angle:
            best[:] = q
            best_distance = distance
            best_angle = angle
        if (distance <= tolerance and angle <= tolerance) or iteration == max_steps:
            break
        _shorten(dX[:3], distance, largest_move)
        _shorten(dX[3:], angle, _LARGEST_TURN)
        jacobian(prismatic, origins, axes, J)
        weigh_orientation(optimiser.radius, J, dX)
        change_of_posture(optimiser, J, dX, B, V, y, dq)
        for _joint in range(n):
            if not _leave_out_pressing_joints(lower, upper, q, dq, J):
                break
            change_of_posture(optimiser, J, dX, B, V, y, dq)
        length = _best_length(J, dX, dq)
        if zigzags:
            length *= _RELAXATION
        moved = 0.0
        for i in range(n):
            before = q[i]
            q[i] = min(max(before + length * dq[i], lower[i]), upper[i])
            moved = max(moved, abs(q[i] - before))
        steps += 1
        if moved < _STANDSTILL * tolerance:
            break
    q[:] = best
    return steps, best_distance, best_angle


@kernel
def _shorten(vector: FloatArray, norm: float, largest: float) -> None:
    if norm > largest:
        for k in range(vector.shape[0]):
            vector[k] *= largest / norm


@kernel
def _leave_out_pressing_joints(
    lower: FloatArray, upper: FloatArray, q: FloatArray, dq: FloatArray, J: FloatArray
) -> bool:
    """Zero the columns of joints that stand at a limit and would go on; tells whether any did."""
    any_pressing = False
    for i in range(q.shape[0]):
        if (q[i] <= lower[i] and dq[i] < 0.0) or (q[i] >= upper[i] and dq[i] > 0.0):
            J[:, i] = 0.0
            dq[i] = 0.0
            any_pressing = True
    return any_pressing


@kernel
def _best_length(J: FloatArray, dX: FloatArray, dq: FloatArray) -> float:
    """Step length that minimises |dX - s J dq|."""
    along = 0.0
    square = 0.0
    for k in range(J.shape[0]):
        moved = 0.0
        for i in range(J.shape[1]):
            moved += J[k, i] * dq[i]
        along += moved * dX[k]
        square += moved * moved
    return along / square if square > 0.0 else 0.0
