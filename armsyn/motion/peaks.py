"""Peaks of a speed profile: submovements by their rise, and those that stand out of the whole."""

from __future__ import annotations

import numpy as np

from armsyn.motion.motion import FloatArray

PEAK_RISE = 0.020
"""m/s."""
PEAK_SPACING = 0.150
"""s."""
PROMINENCE = 0.1
"""Of the highest speed."""


def count_peaks(
    speed: FloatArray, rate: float, rise: float = PEAK_RISE, spacing: float = PEAK_SPACING
) -> int:
    """Count the submovements: maxima that rise enough above the minimum before them.

    Of two such maxima closer than `spacing`, the higher counts. A movement is taken to come from
    rest, so a profile that starts at its peak has one.

    Parameters
    ----------
    speed : array, shape (samples,)
        m/s, from onset to offset.
    rate : float
        Hz.
    rise : float
        From the lowest speed since the last peak, or the first sample, to the maximum, m/s.
    spacing : float
        Between two peaks, s.

    Returns
    -------
    int
        1 for a simple reach; 0 when the speed never reaches `rise`.

    References
    ----------
    J NeuroEng Rehabil 18 (2021), 00895-3, "number of movement units".
    """
    peaks: list[int] = []
    for frame in _maxima(speed):
        # What is at its highest in the first sample came there from rest, before the onset
        lowest = speed[peaks[-1] if peaks else 0 : frame].min() if frame else 0.0
        if speed[frame] - lowest < rise:
            continue
        if peaks and frame - peaks[-1] < spacing * rate:
            peaks[-1] = max(peaks[-1], frame, key=lambda peak: float(speed[peak]))
        else:
            peaks.append(frame)
    return len(peaks)


def count_prominent_peaks(speed: FloatArray, prominence: float = PROMINENCE) -> int:
    """Count the maxima that stand out by a share of the highest speed.

    A maximum's prominence is its height over the lowest speed that has to be passed on the way to
    a higher one, or to the rest before and after the profile.

    Parameters
    ----------
    speed : array, shape (samples,)
        m/s, from onset to offset.
    prominence : float
        Of the highest speed, above 0.

    Returns
    -------
    int
        1 for a simple reach, whatever ripples on it; 0 when nothing moves.
    """
    least = prominence * float(speed.max())
    if least <= 0:
        return 0
    count, rising, extreme = 0, True, 0.0
    # A turn counts once the speed has left it by that much: what ripples less passes unseen
    for value in [*speed.tolist(), 0.0]:
        if (value > extreme) == rising:
            extreme = value
        elif abs(value - extreme) >= least:
            count += rising
            rising, extreme = not rising, value
    return count


def _maxima(speed: FloatArray) -> list[int]:
    """Return the first sample of every local maximum, plateaus and both ends included."""
    changes = np.concatenate([[0], np.flatnonzero(np.diff(speed)) + 1])
    level = np.concatenate([[-np.inf], speed[changes], [-np.inf]])
    is_maximum = (level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])
    return [int(frame) for frame in changes[is_maximum]]
