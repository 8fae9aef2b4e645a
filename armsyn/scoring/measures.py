"""All measures of one hand's movement, taken one way for captures, plans and recordings."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from armsyn.errors import CaptureError
from armsyn.motion import FloatArray, Motion
from armsyn.motion.filtering import CUTOFF, SpeedProfile, hand_speed
from armsyn.motion.peaks import count_peaks
from armsyn.motion.resample import interpolate
from armsyn.motion.segmentation import CUT_FRACTION, onset_and_offset, shortest_rest
from armsyn.scoring.profile import (
    minimum_jerk_fit,
    peak_over_mean,
    time_to_peak,
)
from armsyn.scoring.smoothness import log_dimensionless_jerk, spectral_arc_length

FEWEST_FRAMES = 5
"""Between onset and offset: below it no measure of a movement's shape means anything."""


@dataclass(frozen=True)
class ProfileMeasures:
    """What one hand's movement measures, and how it was measured.

    Parameters
    ----------
    rate, cutoff, cut_fraction : float
        Hz of the even grid, Hz of the filter (None: none), share of the peak at onset and offset.
    onset, offset, movement_time : float
        Seconds; the first two on the motion's own clock.
    path, distance, peak_speed : float
        m, m and m/s, from onset to offset.
    time_to_peak : float
        Share of the movement time.
    peak_over_mean : float
        Dimensionless; minimum jerk 1.875, and 1.658 after the cut at 5 %.
    speed_peaks : int
        Submovements.
    min_jerk_r, min_jerk_r2 : float
        Against minimum jerk of the same duration and path; r is NaN for a constant speed.
    sparc, ldlj : float
        Smoothness; LDLJ with T = N / fs.
    path_over_distance, deviation_over_distance : float
        Straightness: 1 and 0 for a straight line, NaN for a path that ends where it began.
    """

    rate: float
    cutoff: float | None
    cut_fraction: float
    onset: float
    offset: float
    movement_time: float
    path: float
    distance: float
    peak_speed: float
    time_to_peak: float
    peak_over_mean: float
    speed_peaks: int
    min_jerk_r: float
    min_jerk_r2: float
    sparc: float
    ldlj: float
    path_over_distance: float
    deviation_over_distance: float


def movement(
    time: FloatArray,
    positions: FloatArray,
    *,
    cutoff: float | None = CUTOFF,
    fraction: float = CUT_FRACTION,
    rate: float | None = None,
) -> SpeedProfile:
    """Measure the hand's speed and keep it from onset to offset.

    Parameters
    ----------
    time : array, shape (frames,)
        Seconds.
    positions : array, shape (frames, 3)
        Of the hand, m.
    cutoff, rate : float or None
        Hz; see `armsyn.motion.filtering.hand_speed`.
    fraction : float
        Of the peak speed; see `armsyn.motion.segmentation.onset_and_offset`.

    Returns
    -------
    SpeedProfile
        From the first to the last sample at or above the fraction; up to `REST` beyond a record
        that was cut while moving.

    Raises
    ------
    InputError
        When the input does not fit, or its rate cannot carry the filter.
    CaptureError
        When there are gaps, nothing moves, or the movement has fewer than 5 frames.
    """
    whole = hand_speed(time, positions, cutoff=cutoff, rate=rate)
    onset, offset = onset_and_offset(whole.speed, fraction, shortest_rest(whole.time))
    frames = int(((time >= whole.time[onset]) & (time <= whole.time[offset])).sum())
    if frames < FEWEST_FRAMES:
        raise CaptureError(f"the hand moves for {frames} frames only: {FEWEST_FRAMES} are needed")
    kept = slice(onset, offset + 1)
    return dataclasses.replace(
        whole, time=whole.time[kept], positions=whole.positions[kept], speed=whole.speed[kept]
    )


def profile_measures(
    time: FloatArray,
    positions: FloatArray,
    *,
    cutoff: float | None = CUTOFF,
    fraction: float = CUT_FRACTION,
    rate: float | None = None,
) -> ProfileMeasures:
    """Take all measures of a hand's movement.

    Parameters
    ----------
    time : array, shape (frames,)
        Seconds.
    positions : array, shape (frames, 3)
        Of the hand, m.
    cutoff, fraction, rate : float
        As in `movement`.

    Returns
    -------
    ProfileMeasures
        With rate, filter and cut stated.

    Raises
    ------
    InputError, CaptureError
        As in `movement`.
    """
    part = movement(time, positions, cutoff=cutoff, fraction=fraction, rate=rate)
    speed = part.speed
    r, r2 = minimum_jerk_fit(speed, part.rate)
    distance = float(np.linalg.norm(part.positions[-1] - part.positions[0]))
    path = float(np.linalg.norm(np.diff(part.positions, axis=0), axis=1).sum())
    # A closed path is known by its size: rounding leaves a distance that is not quite zero.
    is_closed = distance <= 1e-9 * path
    return ProfileMeasures(
        rate=part.rate,
        cutoff=cutoff,
        cut_fraction=fraction,
        onset=float(part.time[0]),
        offset=float(part.time[-1]),
        movement_time=float(part.time[-1] - part.time[0]),
        path=path,
        distance=distance,
        peak_speed=float(speed.max()),
        time_to_peak=time_to_peak(speed),
        peak_over_mean=peak_over_mean(speed, part.rate),
        speed_peaks=count_peaks(speed, part.rate),
        min_jerk_r=r,
        min_jerk_r2=r2,
        sparc=spectral_arc_length(speed, part.rate),
        ldlj=log_dimensionless_jerk(speed, part.rate),
        path_over_distance=float("nan") if is_closed else path / distance,
        deviation_over_distance=float("nan")
        if is_closed
        else largest_deviation(part.positions) / distance,
    )


def measure(
    motion: Motion,
    *,
    cutoff: float | None = CUTOFF,
    fraction: float = CUT_FRACTION,
    rate: float | None = None,
) -> ProfileMeasures:
    """Take all measures of a motion's hand, its last landmark.

    Parameters
    ----------
    motion : Motion
        With landmarks.
    cutoff, fraction, rate : float
        As in `movement`.

    Returns
    -------
    ProfileMeasures
        With rate, filter and cut stated.

    Raises
    ------
    FormatError
        When the motion has angles only.
    InputError, CaptureError
        As in `movement`.
    """
    return profile_measures(motion.time, motion.hand, cutoff=cutoff, fraction=fraction, rate=rate)


def normalised_speed(
    time: FloatArray,
    positions: FloatArray,
    *,
    cutoff: float | None = CUTOFF,
    fraction: float = CUT_FRACTION,
    rate: float | None = None,
    samples: int = 101,
) -> FloatArray:
    """Return the hand's speed at evenly spaced moments from onset to offset.

    Parameters
    ----------
    time : array, shape (frames,)
        Seconds.
    positions : array, shape (frames, 3)
        Of the hand, m.
    cutoff, fraction, rate : float
        As in `movement`.
    samples : int
        How many.

    Returns
    -------
    array, shape (samples,)
        m/s; time is normalised, the speed is not.

    Raises
    ------
    InputError, CaptureError
        As in `movement`.
    """
    part = movement(time, positions, cutoff=cutoff, fraction=fraction, rate=rate)
    return interpolate(part.time, part.speed, np.linspace(part.time[0], part.time[-1], samples))


def largest_deviation(positions: FloatArray) -> float:
    """Return the largest distance of a path from the line between its ends.

    Parameters
    ----------
    positions : array, shape (samples, 3)
        m, the ends apart.

    Returns
    -------
    float
        m.
    """
    line = positions[-1] - positions[0]
    direction = line / np.linalg.norm(line)
    offset = positions - positions[0]
    across = offset - np.outer(offset @ direction, direction)
    return float(np.linalg.norm(across, axis=1).max())
