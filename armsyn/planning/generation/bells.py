"""Many reaches at once: whether each one's hand speeds up once (`armsyn.planning.evenness`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.bells import count_along
from armsyn.kinematics import SerialChain
from armsyn.planning.evenness import measure_of
from armsyn.planning.generation.pacing import Paced

BoolArray = NDArray[np.bool_]


def uneven_reaches(chain: SerialChain, paced: Paced) -> BoolArray:
    """Return which hands speed up more than once, as `armsyn.planning.evenness.uneven_speed` does.

    Parameters
    ----------
    chain : SerialChain
    paced : Paced
        M reaches.

    Returns
    -------
    array of bool, shape (M,)
    """
    counts, rate = np.empty(len(paced.scales), dtype=np.int64), float(paced.rate_hz)
    count_along(chain.arrays, paced.paths, paced.first, rate, measure_of(rate), counts)
    return np.asarray(counts > 1)
