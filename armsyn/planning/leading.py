"""Compiled loops over many reaches: inverse kinematics, Jacobians, motions led to their ends."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.chain import ChainArrays, forward, jacobian, positions_along
from armsyn.kernels.compiling import generated_kernel, kernel
from armsyn.kernels.linear import solve_positive
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


@kernel
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
    rotation, translation, prismatic, _lower, _upper = chain
    sines, cosines, origins, axes = np.empty(n), np.empty(n), np.empty((n + 1, 3)), np.empty((n, 3))
    J, C, nowhere = np.empty((3, n)), np.empty((3, k)), np.empty((0, 0))
    root, whitened = _whitened(firsts, damping)
    along = np.ascontiguousarray(lasts.T)
    start, end, miss = np.empty(n), np.empty(n), np.empty(3)
    for row in range(x.shape[0]):
        x[row] = 0.0
        for i in range(n):
            start[i] = starts[row, i] - begins[row, i]
            for h in range(i):
                start[i] -= root[i, h] * start[h]
            start[i] /= root[i, i]
        for _step in range(steps):
            for i in range(n):
                angle = ends[row, i]
                for j in range(k):
                    angle += along[i, j] * x[row, j]
                end[i] = angle
            forward(rotation, translation, prismatic, end, sines, cosines, origins, axes, nowhere)
            jacobian(prismatic, origins, axes, J)
            C[:] = 0.0
            for a in range(3):
                for i in range(n):
                    for j in range(k):
                        C[a, j] += J[a, i] * along[i, j]
                gap = targets[row, a] - origins[n, a]
                for j in range(k):
                    gap += C[a, j] * x[row, j]
                miss[a] = gap
            _likeliest(whitened, start, C, damping[n:], miss, longest, x[row])


@kernel
def _whitened(firsts: FloatArray, damping: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return R, (n, n), with R R^T = F F^T + d^2 for F = `firsts`^T, and R^-1 F, (n, k)."""
    k, n = firsts.shape
    root, whitened = np.zeros((n, n)), np.empty((n, k))
    for i in range(n):
        whitened[i] = firsts[:, i]
        for j in range(i + 1):
            total = damping[i] * damping[i] if i == j else 0.0
            for h in range(k):
                total += firsts[h, i] * firsts[h, j]
            for h in range(j):
                total -= root[i, h] * root[j, h]
            root[i, j] = math.sqrt(total) if i == j else total / root[j, j]
        for h in range(i):
            whitened[i] -= root[i, h] * whitened[h]
        whitened[i] /= root[i, i]
    return root, whitened


@kernel
def _likeliest(
    whitened: FloatArray,
    start: FloatArray,
    C: FloatArray,
    softness: FloatArray,
    miss: FloatArray,
    longest: float,
    x: FloatArray,
) -> None:
    """Fill x = G^T (G G^T + d^2)^-1 y, no longer than `longest`, for G = [F; C].

    The block of F, and R^-1 times y there (`start`), are the same in all steps: `whitened`. What
    is left is the 3 by 3 of C, `softness` its d; `miss`, shape (3,), is y there, and is lost.
    """
    n, k = whitened.shape
    A, S = np.empty((3, n)), np.empty((3, 3))
    for a in range(3):
        for i in range(n):
            total = 0.0
            for j in range(k):
                total += C[a, j] * whitened[i, j]
            A[a, i] = total
            miss[a] -= total * start[i]
        for b in range(a + 1):
            total = softness[a] * softness[a] if a == b else 0.0
            for j in range(k):
                total += C[a, j] * C[b, j]
            for i in range(n):
                total -= A[a, i] * A[b, i]
            S[a, b] = S[b, a] = total
    solve_positive(S, miss)
    x[:] = 0.0
    for i in range(n):
        share = start[i]
        for a in range(3):
            share -= A[a, i] * miss[a]
        for j in range(k):
            x[j] += share * whitened[i, j]
    for a in range(3):
        for j in range(k):
            x[j] += miss[a] * C[a, j]
    norm = math.sqrt((x * x).sum())
    x *= longest / max(norm, longest)
