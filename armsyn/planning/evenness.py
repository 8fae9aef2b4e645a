"""Whether a hand goes its way in one bell, as people's do: the peaks of its speed.

They are those of `armsyn.scoring`, of the whole reach: the hand's speed through the project's
filter (`armsyn.motion.filtering.hand_speed`), from rest to rest. A dip below what counts as the
movement's onset does not end it here, for a second bell behind it is one. An arm that has to be
slow is held to that at a person's pace, too: otherwise it would stop on its way unnoticed.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import RefusedMotionError
from armsyn.kernels.bells import Measure, count_each
from armsyn.motion.filtering import CUTOFF, LOWEST_RATE, REST
from armsyn.motion.peaks import PEAK_RISE, PEAK_SPACING

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class UnevenError(RefusedMotionError):
    """A reach whose hand would speed up more than once.

    Parameters
    ----------
    message : str
        One line.
    peaks : int
        Of the hand's speed.
    """

    def __init__(self, message: str, peaks: int) -> None:
        super().__init__(message)
        self.peaks = peaks


def uneven_speed(hand: FloatArray, rate_hz: float, scale: float = 1.0) -> UnevenError | None:
    """Return the refusal of a motion whose hand speeds up more than once; None for a bell.

    Parameters
    ----------
    hand : array, shape (frames, 3)
        m, at `rate_hz`; at rest before and after.
    rate_hz : float
    scale : float
        kappa, how many times it has been slowed.
    """
    peaks = int(peaks_of(hand, np.array([0, len(hand)]), rate_hz, np.array([scale]))[0])
    if peaks <= 1:
        return None
    return UnevenError(
        f"the hand would speed up {peaks} times on its way: go by way of another target", peaks
    )


def peaks_of(paths: FloatArray, first: IntArray, rate_hz: float, scales: FloatArray) -> IntArray:
    """Count the peaks of many hands' speeds.

    Parameters
    ----------
    paths : array, shape (all frames, 3)
        m, one reach after another, each at rest before and after.
    first : array of int, shape (M + 1,)
        Where each begins; the last is where all end.
    rate_hz : float
    scales : array, shape (M,)
        kappa of each.

    Returns
    -------
    array of int, shape (M,)
        The more of those at the rate and those at a person's pace.
    """
    counts, rate = np.empty(len(first) - 1, dtype=np.int64), float(rate_hz)
    count_each(np.ascontiguousarray(paths), first, rate, scales, measure_of(rate), counts)
    return counts


@cache
def measure_of(rate_hz: float) -> Measure:
    """Return how a hand's speed at a rate is measured, as `armsyn.motion.filtering` does."""
    rate = max(rate_hz, LOWEST_RATE)
    k = math.tan(math.pi * CUTOFF / rate)
    scale = 1.0 / (1.0 + math.sqrt(2.0) * k + k * k)
    return Measure(
        gain=k * k * scale,
        last=2.0 * (k * k - 1.0) * scale,
        before=(1.0 - math.sqrt(2.0) * k + k * k) * scale,
        rate=rate,
        rest=round(REST * rate),
        rise=PEAK_RISE,
        spacing=PEAK_SPACING * rate,
    )
