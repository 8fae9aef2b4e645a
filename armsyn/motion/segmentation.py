"""Where a movement begins and ends, read from its speed."""

from __future__ import annotations

import numpy as np

from armsyn.errors import CaptureError, InputError
from armsyn.motion.motion import FloatArray

CUT_FRACTION = 0.05
"""Share of the peak speed below which a hand counts as resting (JNER 2021, 00895-3)."""


def onset_and_offset(speed: FloatArray, fraction: float = CUT_FRACTION) -> tuple[int, int]:
    """Walk out from the peak until the speed is below a fraction of it.

    Parameters
    ----------
    speed : array, shape (samples,)
        Speed, m/s, evenly sampled and finite.
    fraction : float
        Of the peak, from 0 (keep everything) to below 1. The literature takes 0.05 for reaches,
        0.02 for a drinking task, 0.1 elsewhere (JNER 2021, 00895-3; Sensors 2022, 22:230).

    Returns
    -------
    onset, offset : int
        First and last sample of the movement, both at or above the fraction; the end of the
        profile where the speed never falls below it.

    Raises
    ------
    InputError
        When the fraction is not in [0, 1).
    CaptureError
        When nothing moves, or the speed is not finite.
    """
    if not 0 <= fraction < 1:
        raise InputError(f"cut fraction {fraction} is not in [0, 1)")
    if speed.size == 0 or not np.isfinite(speed).all():
        raise CaptureError("the hand's speed has gaps: cut the motion to where the hand is seen")
    peak = int(np.argmax(speed))
    if speed[peak] <= 0:
        raise CaptureError("the hand does not move: there is no movement to measure")
    resting = np.flatnonzero(speed < fraction * speed[peak])
    before, after = resting[resting < peak], resting[resting > peak]
    onset = int(before[-1]) + 1 if before.size else 0
    offset = int(after[0]) - 1 if after.size else speed.size - 1
    return onset, offset


def movement_times(
    time: FloatArray, speed: FloatArray, fraction: float = CUT_FRACTION
) -> tuple[float, float]:
    """Return when the speed crosses the fraction of its peak, between samples.

    Parameters
    ----------
    time : array, shape (samples,)
        Seconds.
    speed : array, shape (samples,)
        m/s.
    fraction : float
        As in `onset_and_offset`.

    Returns
    -------
    onset, offset : float
        Seconds, interpolated linearly: a motion does not change its length with its grid.

    Raises
    ------
    InputError, CaptureError
        As `onset_and_offset`.
    """
    onset, offset = onset_and_offset(speed, fraction)
    level = fraction * float(speed.max())

    def crossing(outside: int, inside: int) -> float:
        if not 0 <= outside < speed.size:
            return float(time[inside])
        share = (level - speed[outside]) / (speed[inside] - speed[outside])
        return float(time[outside] + share * (time[inside] - time[outside]))

    return crossing(onset - 1, onset), crossing(offset + 1, offset)
