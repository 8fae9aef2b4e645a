"""Where a movement begins and ends, read from its speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import CaptureError, InputError
from armsyn.motion.motion import FloatArray

CUT_FRACTION = 0.05
"""Share of the peak speed below which a hand counts as resting (JNER 2021, 00895-3)."""


SHORTEST_REST = 0.15
"""s below the cut that end a movement. A slow joint under weight sticks and slips: between two
slips the hand may stand for a tenth of a second, which is no end of the reach. As long as the
least time between two submovements (JNER 2021, 00895-3)."""
SLIP = 0.25
"""Of the peak speed, that the hand must reach again after such a dip for it to be none of the
movement's ends. Hands that settle after a reach come to 0.1-0.2 of it; slips are like each
other."""


def onset_and_offset(
    speed: FloatArray, fraction: float = CUT_FRACTION, rest: int = 1
) -> tuple[int, int]:
    """Walk out from the peak until the speed is below a fraction of it, and stays there.

    Parameters
    ----------
    speed : array, shape (samples,)
        Speed, m/s, evenly sampled and finite.
    fraction : float
        Of the peak, from 0 (keep everything) to below 1. The literature takes 0.05 for reaches,
        0.02 for a drinking task, 0.1 elsewhere (JNER 2021, 00895-3; Sensors 2022, 22:230).
    rest : int
        Samples that it must stay below, or to the end of the profile; a shorter dip is one of a
        submovement, if the speed rises to `SLIP` of the peak again.

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
    runs = moving_runs(speed >= fraction * speed[peak])
    place = next(index for index, (first, last) in enumerate(runs) if first <= peak <= last)
    least = SLIP * float(speed[peak])
    onset = edge = runs[place][0]
    for first, last in reversed(runs[:place]):
        if edge - last - 1 >= rest:
            break
        edge = first
        onset = first if speed[first : last + 1].max() >= least else onset
    offset = edge = runs[place][1]
    for first, last in runs[place + 1 :]:
        if first - edge - 1 >= rest:
            break
        edge = last
        offset = last if speed[first : last + 1].max() >= least else offset
    return onset, offset


def moving_runs(moving: NDArray[np.bool_], rest: int = 1) -> list[tuple[int, int]]:
    """Return the runs of samples in which the hand moves.

    Parameters
    ----------
    moving : array of bool, shape (samples,)
    rest : int
        Samples of rest between two runs; what is closer is one.

    Returns
    -------
    list of (int, int)
        First and last sample of each, in their order.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], moving, [False]]).astype(np.int8)))
    runs: list[tuple[int, int]] = []
    for first, after in edges.reshape(-1, 2).tolist():
        if runs and first - runs[-1][1] - 1 < rest:
            runs[-1] = runs[-1][0], after - 1
        else:
            runs.append((first, after - 1))
    return runs


def shortest_rest(time: FloatArray) -> int:
    """Return the samples that `SHORTEST_REST` takes on an even grid, one at least."""
    return max(1, round(SHORTEST_REST * (time.size - 1) / float(time[-1] - time[0])))


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
        As in `onset_and_offset`; a dip shorter than `SHORTEST_REST` does not end the movement.

    Returns
    -------
    onset, offset : float
        Seconds, interpolated linearly: a motion does not change its length with its grid.

    Raises
    ------
    InputError, CaptureError
        As `onset_and_offset`.
    """
    onset, offset = onset_and_offset(speed, fraction, shortest_rest(time))
    level = fraction * float(speed.max())

    def crossing(outside: int, inside: int) -> float:
        if not 0 <= outside < speed.size:
            return float(time[inside])
        share = (level - speed[outside]) / (speed[inside] - speed[outside])
        return float(time[outside] + share * (time[inside] - time[outside]))

    return crossing(onset - 1, onset), crossing(offset + 1, offset)
