"""Compiled loops over many reaches: inverse kinematics, Jacobians, motions led to their ends."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.chain import ChainArrays, forward, jacobian, positions_along
from armsyn.kernels.compiling import generated_kernel
from armsyn.kernels.linear import gram, solve_positive
from armsyn.kernels.optimisers import OptimiserSettings
from armsyn.kernels.solver import descend
from armsyn.kernels.types import FloatArray


class Descent(NamedTuple):
    """How inverse kinematics descends; see `armsyn.kernels.solver.descend`."""

    optimiser: OptimiserSettings
    largest_move: float
    tolerance: float
    max_steps: int


@generated_kernel
def descend_each(
    chain: ChainArrays,
    targets: FloatArray,
    descent: Descent,
    q: FloatArray,
    errors: FloatArray,
) -> None:
    """Move postures q, shape (M, n), to targets, shape (M, 3); fill what they miss, (M,), m."""
    optimiser, move, tolerance, steps = descent
    orientation = np.empty((0, 0))
    for row in range(q.shape[0]):
        _, errors[row], _ = descend(
            chain, optimiser, targets[row], orientation, move, tolerance, steps, q[row]
        )


@generated_kernel
def jacobian_each(chain: ChainArrays, q: FloatArray, J: FloatArray) -> None:
    """Fill the geometric Jacobians of the tip, shape (M, 3, n), at postures q, shape (M, n)."""
    n = q.shape[1]
    sines, cosines = np.empty(n), np.empty(n)
    origins, axes, tip = np.empty((n + 1, 3)), np.empty((n, 3)), np.empty((0, 0))
    rotation, translation, prismatic, _lower, _upper = chain
    for row in range(q.shape[0]):
        forward(rotation, translation, prismatic, q[row], sines, cosines, origins, axes, tip)
        jacobian(prismatic, origins, axes, J[row])


@generated_kernel
def lead_each(
    chain: ChainArrays,
    starts: FloatArray,
    targets: FloatArray,
    fade: FloatArray,
    ease: FloatArray,
    scaled: bool,
    descent: Descent,
    angles: FloatArray,
    errors: FloatArray,
) -> None:
    """Lead motions, shape (M, P, n), in place from their starts to where inverse kinematics ends.

    The offset to the start is faded by `fade`, shape (P,), that to the end eased in by `ease`;
    joints stay within their limits after the start. `scaled`: only `carried_share` of each motion
    is led so.
    """
    frames, n = angles.shape[1:]
    lower, upper = chain[3], chain[4]
    begin, end, ways = np.empty(n), np.empty((1, n)), np.empty((4, n))
    for row in range(angles.shape[0]):
        motion, share = angles[row], 1.0
        for i in range(n):
            end[0, i] = min(max(motion[frames - 1, i], lower[i]), upper[i])
        descend_each(chain, targets[row : row + 1], descent, end, errors[row : row + 1])
        if scaled:
            ways[0], ways[1], ways[2], ways[3] = starts[row], end[0], motion[0], motion[frames - 1]
            share = carried_share(chain, ways)
        for i in range(n):
            begin[i] = starts[row, i] - share * motion[0, i]
            end[0, i] -= share * motion[frames - 1, i]
        for frame in range(1, frames):
            for i in range(n):
                moved = share * motion[frame, i] + begin[i] * fade[frame] + end[0, i] * ease[frame]
                motion[frame, i] = min(max(moved, lower[i]), upper[i])
        motion[0] = starts[row]


@generated_kernel
def carried_share(chain: ChainArrays, ways: FloatArray) -> float:
    """Return how much of one way the hand goes again on another, 0 to 1.

    `ways`, shape (4, n), are the first and the last posture of the other, then those of the one.
    It is the other's part along the one, at most all of it, by the squared cosine between both.
    """
    hands = positions_along(chain, ways)[:, -1]
    along = whole = other = 0.0
    for a in range(3):
        way, gone = hands[3, a] - hands[2, a], hands[1, a] - hands[0, a]
        along += way * gone
        whole += way * way
        other += gone * gone
    if not along > 0.0:
        return 0.0
    return min(along / whole, 1.0) * along * along / (whole * other)


@generated_kernel
def deviate_each(
    chain: ChainArrays,
    firsts: FloatArray,
    lasts: FloatArray,
    starts: FloatArray,
    targets: FloatArray,
    damping: FloatArray,
    begins: FloatArray,
    ends: FloatArray,
    steps: int,
    longest: float,
    x: FloatArray,
) -> None:
    """Fill the likeliest standard deviations x, shape (M, k), given starts and targets.

    Gauss-Newton steps on |x|^2 + |(start - begin - F x) / d|^2 + |(target - tip(end + L x)) / d|^2
    with F = `firsts`^T and L = `lasts`^T, each (k, n) transposed, and d = `damping`, (n + 3,).

    Parameters
    ----------
    begins, ends : array, shape (M, n)
        First and last postures at x = 0.
    longest : float
        Greatest norm of x.
    """
    k, n = firsts.shape
    m = n + 3
    C, B, J = np.empty((m, k)), np.empty((m, m)), np.empty((1, 3, n))
    wanted, here, tip = np.empty(m), np.empty((1, n)), np.empty((1, n + 1, 3))
    for i in range(n):
        for j in range(k):
            C[i, j] = firsts[j, i]
    for row in range(x.shape[0]):
        x[row] = 0.0
        for _step in range(steps):
            for i in range(n):
                here[0, i] = ends[row, i]
                for j in range(k):
                    here[0, i] += lasts[j, i] * x[row, j]
                wanted[i] = starts[row, i] - begins[row, i]
            jacobian_each(chain, here, J)
            tip[:] = positions_along(chain, here)
            for a in range(3):
                wanted[n + a] = targets[row, a] - tip[0, n, a]
                for j in range(k):
                    along = 0.0
                    for i in range(n):
                        along += J[0, a, i] * lasts[j, i]
                    C[n + a, j] = along
                    wanted[n + a] += along * x[row, j]
            _likeliest(C, damping, longest, B, wanted, x[row])


@generated_kernel
def _likeliest(
    C: FloatArray, damping: FloatArray, longest: float, B: FloatArray, y: FloatArray, x: FloatArray
) -> None:
    """Fill x = C^T (C C^T + d^2)^-1 y, no longer than `longest`; B and y are workspace."""
    m, k = C.shape
    gram(C, B)
    for i in range(m):
        B[i, i] += damping[i] * damping[i]
    solve_positive(B, y)
    norm = 0.0
    for j in range(k):
        x[j] = 0.0
        for i in range(m):
            x[j] += C[i, j] * y[i]
        norm += x[j] * x[j]
    if norm > longest * longest:
        x *= longest / math.sqrt(norm)
