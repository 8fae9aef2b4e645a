"""The paper's function O: from a task error dX to a change of posture.

Aubry, Julliard, Gibet 2009, 3.1. Each writes O(J, dX), to be multiplied by lambda dt.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from armsyn.kernels.compiling import kernel
from armsyn.kernels.linear import eigen_symmetric, gram
from armsyn.kernels.types import FloatArray

SVD, TRANSPOSE, NORMALISED_TRANSPOSE, DAMPED = 0, 1, 2, 3

ROUNDING = 1e-14
"""Share of the largest eigenvalue of J J^T below which another is rounding, not meaning."""


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
    if settings.kind in (SVD, DAMPED):
        damped = settings.kind == DAMPED
        cut_off = 0.0 if damped else settings.cut_off
        square = settings.damping * settings.damping if damped else 0.0
        if J.shape[0] == 3 and _exact3(J, dX, square, cut_off, dq):
            return
        gram(J, B)
        for i in range(dX.shape[0]):
            B[i, i] += square
        _truncated_inverse(cut_off, dX, B, V, y)
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
    if m == 3:
        for i in range(n):
            dq[i] = J[0, i] * y[0] + J[1, i] * y[1] + J[2, i] * y[2]
        return
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
def _exact3(J: FloatArray, dX: FloatArray, square: float, cut_off: float, dq: FloatArray) -> bool:
    """Fill dq with J^T (J J^T + square)^-1 dX for J of shape (3, n), all in registers.

    False, and dq untouched, unless no singular value can be below the cut-off.
    """
    n = J.shape[1]
    b01 = b02 = b12 = 0.0
    b00 = b11 = b22 = square
    for i in range(n):
        x = J[0, i]
        y = J[1, i]
        z = J[2, i]
        b00 += x * x
        b01 += x * y
        b02 += x * z
        b11 += y * y
        b12 += y * z
        b22 += z * z
    c00 = b11 * b22 - b12 * b12
    c01 = b02 * b12 - b01 * b22
    c02 = b01 * b12 - b02 * b11
    determinant = b00 * c00 + b01 * c01 + b02 * c02
    trace = b00 + b11 + b22
    # det = l1 l2 l3 and l1 l2 <= (trace / 2)^2, so l3 >= 4 det / trace^2: where even this lower
    # bound passes the cut-off (against l1 <= trace) nothing can be below it.
    if not 4.0 * determinant > max(cut_off * cut_off, ROUNDING) * trace * trace * trace:
        return False
    c11 = b00 * b22 - b02 * b02
    c12 = b01 * b02 - b00 * b12
    c22 = b00 * b11 - b01 * b01
    scale = 1.0 / determinant
    y0 = (c00 * dX[0] + c01 * dX[1] + c02 * dX[2]) * scale
    y1 = (c01 * dX[0] + c11 * dX[1] + c12 * dX[2]) * scale
    y2 = (c02 * dX[0] + c12 * dX[1] + c22 * dX[2]) * scale
    for i in range(n):
        dq[i] = J[0, i] * y0 + J[1, i] * y1 + J[2, i] * y2
    return True


@kernel
def _truncated_inverse(
    cut_off: float, dX: FloatArray, B: FloatArray, V: FloatArray, y: FloatArray
) -> None:
    """Fill y = B^+ dX, without the singular values of J below the cut-off."""
    m = dX.shape[0]
    eigen_symmetric(B, V)
    largest = 0.0
    for i in range(m):
        largest = max(largest, B[i, i])
    floor = max(cut_off * cut_off, ROUNDING) * largest
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
