"""Sine and cosine that vectorise: libm's, which numba calls one by one, are a quarter of a step."""

from __future__ import annotations

import numpy as np

from armsyn.kernels.compiling import kernel
from armsyn.kernels.types import FloatArray

_TWO_OVER_PI = 0.6366197723675814
_HALF_PI_HIGH = 1.5707963267948966
_HALF_PI_LOW = 6.123233995736766e-17


@kernel
def sines_and_cosines(angles: FloatArray, sines: FloatArray, cosines: FloatArray) -> None:
    """Fill the sines and cosines of `angles`, all of shape (n,), |angle| below 1e5 rad.

    Minimax polynomials on [-pi/4, pi/4] after reduction by quarter turns (coefficients of the
    Cephes library, S. Moshier 1984-92: sin.c); error below 4e-16 for the angles of joints.
    """
    for i in range(angles.shape[0]):
        quarter = np.rint(angles[i] * _TWO_OVER_PI)
        x = angles[i] - quarter * _HALF_PI_HIGH
        x = x - quarter * _HALF_PI_LOW
        z = x * x
        p = -2.50507477628578072866e-8 + z * 1.58962301576546568060e-10
        p = 2.75573136213857245213e-6 + z * p
        p = -1.98412698295895385996e-4 + z * p
        p = 8.33333333332211858878e-3 + z * p
        p = -1.66666666666666307295e-1 + z * p
        sine = x + x * z * p
        p = 2.08757008419747316778e-9 - z * 1.13585365213876817300e-11
        p = -2.75573141792967388112e-7 + z * p
        p = 2.48015872888517045348e-5 + z * p
        p = -1.38888888888730564116e-3 + z * p
        p = 4.16666666666665929218e-2 + z * p
        cosine = 1.0 - 0.5 * z + z * z * p
        turn = np.int32(quarter)  # as wide as vectors can be converted to
        odd = (turn & 1) == 1
        s = cosine if odd else sine
        c = sine if odd else cosine
        sines[i] = -s if (turn & 2) != 0 else s
        cosines[i] = -c if ((turn + 1) & 2) != 0 else c
