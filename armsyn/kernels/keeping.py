"""Motions whose hands are brought back to their paths."""

from __future__ import annotations

import numpy as np

from armsyn.kernels.chain import ChainArrays, forward, jacobian
from armsyn.kernels.compiling import kernel
from armsyn.kernels.linear import gram, solve_positive
from armsyn.kernels.types import FloatArray


@kernel
def keep_hand(
    chain: ChainArrays,
    hand: FloatArray,
    moving: FloatArray,
    close: float,
    damping: float,
    passes: int,
    angles: FloatArray,
) -> bool:
    """Bring the hand of a motion, shape (phases, n), in place to a path but for its first row.

    All rows take damped least squares steps together: some more than others would be a corner.

    Parameters
    ----------
    hand : array, shape (phases, 3)
        m.
    moving : array, shape (n,)
        1 of joints that may move, 0 of those that stay.
    close : float
        m that are there.
    damping : float
        m.
    passes : int
        Steps, at most.

    Returns
    -------
    bool
        Whether the hand is there in all rows.
    """
    frames, n = angles.shape
    origins, axes, tip = np.empty((n + 1, 3)), np.empty((n, 3)), np.empty((0, 0))
    sines, cosines, B = np.empty(n), np.empty(n), np.empty((3, 3))
    J, gaps = np.empty((frames, 3, n)), np.empty((frames, 3))
    for _ in range(passes):
        there = True
        for row in range(1, frames):
            forward(
                chain.rotation,
                chain.translation,
                chain.prismatic,
                angles[row],
                sines,
                cosines,
                origins,
                axes,
                tip,
            )
            jacobian(chain.prismatic, origins, axes, J[row])
            square = 0.0
            for k in range(3):
                gaps[row, k] = hand[row, k] - origins[n, k]
                square += gaps[row, k] * gaps[row, k]
            there = there and square < close * close
        if there:
            return True
        for row in range(1, frames):
            for j in range(n):
                for k in range(3):
                    J[row, k, j] *= moving[j]
            gram(J[row], B)
            for k in range(3):
                B[k, k] += damping * damping
            solve_positive(B, gaps[row])
            for j in range(n):
                for k in range(3):
                    angles[row, j] += J[row, k, j] * gaps[row, k]
    return False
