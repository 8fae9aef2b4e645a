"""Many reaches at once: whether each one's hand speeds up once (`armsyn.planning.evenness`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.distance import ShapeArrays
from armsyn.kinematics import SerialChain
from armsyn.planning.evenness import peaks_of
from armsyn.planning.generation.hands import place_hands
from armsyn.planning.generation.pacing import Paced

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def hands_along(chain: SerialChain, paths: FloatArray) -> FloatArray:
    """Return where the hand is at many postures, shape (frames, n) to (frames, 3), m."""
    hands = np.empty((len(paths), 3))
    place_hands(chain.arrays, _tip_of(chain), paths, hands)
    return hands


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
    hands = hands_along(chain, paced.paths)
    return np.asarray(peaks_of(hands, paced.first, paced.rate_hz) > 1)


def _tip_of(chain: SerialChain) -> ShapeArrays:
    """The tip as a shape without extent, which is what is placed at many postures at once."""
    tip = chain.arrays.translation[-1:]
    return ShapeArrays(
        np.array([chain.dof - 1]),
        tip,
        tip,
        np.zeros(1),
        np.empty((0, 4)),
        np.empty((0, 3, 3)),
        np.empty((0, 3)),
        np.empty((0, 3)),
        np.empty((0, 3), dtype=np.int64),
    )
