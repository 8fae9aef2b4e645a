"""The paper's function O: from a task error dX to a change of posture.

Aubry, Julliard, Gibet 2009, 3.1. Each writes O(J, dX), to be multiplied by lambda dt.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from armsyn.kernels.compiling import kernel
from armsyn.kernels.linear import eigen_symmetric, gram, solve_symmetric3
from armsyn.kernels.types import FloatArray

SVD, TRANSPOSE, NORMALISED_TRANSPOSE, DAMPED = 0, 1, 2, 3


class OptimiserSettings(NamedTuple):
    """Which optimiser, and its constants.

    Attributes
    ----------
    kind : int
        SVD, TRANSPOSE, NORMALISED_TRANSPOSE or DAMPED.
    cut_off : float
        SVD: singular values below this share of the largest count as zero.
    damping : float
        DAMPED: mu of J^T (J J^T + mu^2 I)^-1, in the Jacobian's unit (m).
    slowing : float
        NORMALISED_TRANSPOSE: task error (m) at which one unit of lambda dt turns one radian.
    radius : float
        Metres that one radian of orientation error weighs in a pose.
    """

    kind: int
    cut_off: float
    damping: float
    slowing: float
    radius: float


@kernel
def change_of_posture(
    settings: OptimiserSettings,
    J: FloatArray,
    dX: FloatArray,
    B: FloatArray,
    V: FloatArray,
    y: FloatArray,
    dq: FloatArray,
) -> None:
    """Fill dq, shape (n,), with O(J, dX) for J of shape (m, n) and dX of shape (m,).

    B and V, shape (m, m), and y, shape (m,), are workspace.
    """
    if settings.kind == SVD:
        gram(J, B)
        _pseudo_inverse(settings.cut_off, dX, B, V, y)
        _transpose_times(J, y, dq)
    elif settings.kind == DAMPED:
        gram(J, B)
        for i in range(dX.shape[0]):
            B[i, i] += settings.damping * settings.damping
        _pseudo_inverse(0.0, dX, B, V, y)
        _transpose_times(J, y, dq)
    else:
        _transpose_times(J, dX, dq)
        if settings.kind == NORMALISED_TRANSPOSE:
            _normalise(settings.slowing, dX, dq)


@kernel
def weigh_orientation(radius: float, J: FloatArray, dX: FloatArray) -> None:
    """Turn the rotational rows of a pose task from radians into metres; others are untouched."""
    for k in range(3, J.shape[0]):
        dX[k] *= radius
        for i in range(J.shape[1]):
            J[k, i] *= radius


@kernel
def _transpose_times(J: FloatArray, y: FloatArray, dq: FloatArray) -> None:
    m, n = J.shape
    for i in range(n):
        total = 0.0
        for k in range(m):
            total += J[k, i] * y[k]
        dq[i] = total


@kernel
def _normalise(slowing: float, dX: FloatArray, dq: FloatArray) -> None:
    """Keep the direction of dq; its norm becomes the task error over `slowing`.

    So the step is of unit norm at an error of `slowing` and shrinks in proportion to the error,
    without which a step of constant length would circle the target for ever.
    """
    error = 0.0
    for k in range(dX.shape[0]):
        error += dX[k] * dX[k]
    norm = 0.0
    for i in range(dq.shape[0]):
        norm += dq[i] * dq[i]
    scale = math.sqrt(error / norm) / slowing if norm > 0.0 else 0.0
    for i in range(dq.shape[0]):
        dq[i] *= scale


@kernel
def _pseudo_inverse(
    cut_off: float, dX: FloatArray, B: FloatArray, V: FloatArray, y: FloatArray
) -> None:
    """Fill y = B^+ dX: exact while no singular value of J is below the cut-off, else truncated."""
    m = dX.shape[0]
    if m == 3:
        trace = B[0, 0] + B[1, 1] + B[2, 2]
        determinant = solve_symmetric3(B, dX, y)
        # det = l1 l2 l3 and l1 l2 <= (trace / 2)^2, so l3 >= 4 det / trace^2: where even this
        # lower bound passes the cut-off (against l1 <= trace) nothing can be below it.
        if determinant > 0.0 and 4.0 * determinant > cut_off * cut_off * trace * trace * trace:
            return
    eigen_symmetric(B, V)
    largest = 0.0
    for i in range(m):
        largest = max(largest, B[i, i])
    # At cut-off zero rounding still bounds what an eigenvalue means
    floor = max(cut_off * cut_off, 1e-14) * largest
    for i in range(m):
        y[i] = 0.0
    for j in range(m):
        if B[j, j] > floor:
            along = 0.0
            for i in range(m):
                along += V[i, j] * dX[i]
            along /= B[j, j]
            for i in range(m):
                y[i] += V[i, j] * along
