"""Many reaches as samples that an arm can follow, one after another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.sampling import Ease
from armsyn.planning import timing

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

EASE = Ease(2.0 * timing.CUT_TIME, timing.CUT_SPEED)
"""From rest, and to it."""

LEAST_HZ = 200.0
"""Rate at which limits are held at least: between coarser frames a motion could break them."""


@dataclass(frozen=True)
class Paced:
    """Reaches sampled for an arm, one after another.

    Parameters
    ----------
    paths : array, shape (all frames, n)
        rad or m; the arm rests before and after each.
    first : array of int, shape (M + 1,)
        Where each reach begins; the last is where all end. One that no slowing brings within the
        limits has no frames.
    scales : array, shape (M,)
        kappa, at least 1.
    rate_hz : float
    """

    paths: FloatArray
    first: IntArray
    scales: FloatArray
    rate_hz: float

    @property
    def lengths(self) -> IntArray:
        """Frames of each reach, shape (M,)."""
        return np.diff(self.first)

    def path(self, reach: int) -> FloatArray:
        """Return one reach, shape (frames, n); a view."""
        return self.paths[self.first[reach] : self.first[reach + 1]]


def thinning(rate_hz: float) -> int:
    """Return how many frames to plan for every one that is wanted, for `LEAST_HZ` or more."""
    return max(1, math.ceil(LEAST_HZ / rate_hz))


def thinned(path: FloatArray, step: int) -> FloatArray:
    """Return every so many frames of a reach, and its end, at which the arm rests till the next.

    Parameters
    ----------
    path : array, shape (frames, n)
    step : int

    Returns
    -------
    array, shape (fewer frames, n)
        Of the same motion, its end held for less than `step` frames; so speeds, accelerations and
        jerks over these frames are means of those over the finer ones, and no greater.
    """
    if step == 1:
        return path
    some = path[::step]
    return some if (len(path) - 1) % step == 0 else np.concatenate([some, path[-1:]])


def joined(
    paths: Sequence[FloatArray | None],
    scales: FloatArray,
    rows: IntArray,
    rate_hz: float,
    joints: int,
) -> Paced:
    """Return some of many reaches, one after another.

    Parameters
    ----------
    paths : sequence of array, shape (frames, n)
    scales : array, shape (M,)
    rows : array of int, shape (m,)
        Which; none of them without a path.
    rate_hz : float
    joints : int
        n.

    Returns
    -------
    Paced
    """
    some = [path for path in (paths[row] for row in rows.tolist()) if path is not None]
    first = np.concatenate([[0], np.cumsum([len(path) for path in some], dtype=np.int64)])
    whole = np.concatenate(some) if some else np.empty((0, joints))
    return Paced(whole, first, scales[rows], rate_hz)
