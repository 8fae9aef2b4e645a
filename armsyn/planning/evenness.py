"""Whether a hand goes its way in one bell, as people's do: the peaks of its speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import RefusedMotionError
from armsyn.motion.filtering import CUTOFF
from armsyn.motion.peaks import count_peaks
from armsyn.scoring import movement

FloatArray = NDArray[np.float64]


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


def uneven_speed(hand: FloatArray, rate_hz: float) -> UnevenError | None:
    """Return the refusal of a motion whose hand speeds up more than once; None for a bell.

    Peaks are those of `armsyn.scoring`: of the speed as it is, or else filtered as there.

    Parameters
    ----------
    hand : array, shape (frames, 3)
        m, at `rate_hz`.
    rate_hz : float
    """
    speed = np.linalg.norm(np.diff(hand, axis=0), axis=1) * rate_hz
    peaks = count_peaks(speed, rate_hz) if speed.size else 0
    if peaks > 1 and rate_hz > 2.0 * CUTOFF:  # what is sampled slower cannot be filtered
        peaks = count_peaks(*_movement(hand, rate_hz))
    if peaks <= 1:
        return None
    return UnevenError(
        f"the hand would speed up {peaks} times on its way: go by way of another target", peaks
    )


def _movement(hand: FloatArray, rate_hz: float) -> tuple[FloatArray, float]:
    """The hand's speed from onset to offset, m/s, and its rate, as it is measured of any motion."""
    moved = movement(np.arange(len(hand)) / rate_hz, hand)
    return moved.speed, moved.rate
