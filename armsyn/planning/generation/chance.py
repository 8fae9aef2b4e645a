"""Chance by seed and index: the same numbers for a reach, whatever is made before or beside it."""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_A_BLOCK = 4
"""Numbers of 64 bits that Philox makes at a time."""


def uniform(seed: int, purpose: str, first: int, last: int, count: int) -> FloatArray:
    """Draw numbers for the indices `first` to `last`, which is not included.

    Philox counts (Salmon et al., *Parallel random numbers: as easy as 1, 2, 3*, 2011): each index
    has its own stretch of the count.

    Parameters
    ----------
    seed : int
    purpose : str
        Draws for another purpose are independent.
    first, last : int
    count : int
        Numbers for each index.

    Returns
    -------
    array, shape (last - first, count)
        Evenly in (0, 1).
    """
    blocks = -(-count // _A_BLOCK)
    key = hashlib.blake2b(f"{seed}:{purpose}".encode(), digest_size=16).digest()
    bits = np.random.Philox(key=int.from_bytes(key, "little")).advance(first * blocks)
    raw = bits.random_raw((last - first) * blocks * _A_BLOCK).reshape(last - first, -1)
    return ((raw[:, :count] >> np.uint64(12)).astype(np.float64) + 0.5) * 2.0**-52


def normal(seed: int, purpose: str, first: int, last: int, count: int) -> FloatArray:
    """Draw standard normal numbers; see `uniform`."""
    from scipy.special import ndtri  # noqa: PLC0415  needed for variability only

    return np.asarray(ndtri(uniform(seed, purpose, first, last, count)))
