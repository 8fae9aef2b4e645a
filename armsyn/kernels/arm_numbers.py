"""Everything of an arm that following a target needs, in one array.

A tick of a stream runs cold, and each argument that it is called with is looked at anew.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiling import kernel
from armsyn.kernels.optimisers import OptimiserSettings
from armsyn.kernels.types import FloatArray

_SETTINGS = len(OptimiserSettings._fields)


class Arm(NamedTuple):
    """What following needs of an arm.

    Attributes
    ----------
    chain : ChainArrays
    optimiser : OptimiserSettings
    speed, acceleration, jerk : array, shape (n,)
        Greatest, rad/s, rad/s2, rad/s3.
    """

    chain: ChainArrays
    optimiser: OptimiserSettings
    speed: FloatArray
    acceleration: FloatArray
    jerk: FloatArray


def packed(chain: ChainArrays, optimiser: OptimiserSettings, bounds: FloatArray) -> FloatArray:
    """Everything of an arm that following needs, in one array.

    Parameters
    ----------
    chain : ChainArrays
    optimiser : OptimiserSettings
    bounds : array, shape (3, n)
        Greatest speeds, rad/s, accelerations, rad/s2, and jerks, rad/s3.

    Returns
    -------
    array, shape (5 + 12 (n + 1) + 6 n,)
    """
    parts = (*chain, bounds)
    return np.concatenate([np.array(optimiser, dtype=np.float64), *map(np.ravel, parts)])


@kernel
def unpacked(packed: FloatArray, n: int) -> Arm:
    """Views of what `packed` put together for n joints."""
    settings, ends = packed[:_SETTINGS], packed.size - np.arange(6) * n
    optimiser = OptimiserSettings(
        int(settings[0]), settings[1], settings[2], settings[3], settings[4]
    )
    turns, shifts = _SETTINGS + 9 * (n + 1), _SETTINGS + 12 * (n + 1)
    chain = ChainArrays(
        packed[_SETTINGS:turns].reshape(n + 1, 3, 3),
        packed[turns:shifts].reshape(n + 1, 3),
        packed[shifts : shifts + n] != 0.0,
        packed[ends[5] : ends[4]],
        packed[ends[4] : ends[3]],
    )
    return Arm(
        chain,
        optimiser,
        packed[ends[3] : ends[2]],
        packed[ends[2] : ends[1]],
        packed[ends[1] : ends[0]],
    )
