"""Every measure of human-likeness of one movement, by name: what bands are made of."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.motion import FloatArray, Motion
from armsyn.motion.filtering import CUTOFF, LOWEST_RATE, low_pass
from armsyn.motion.resample import interpolate, uniform_times
from armsyn.motion.segmentation import CUT_FRACTION
from armsyn.scoring.coordination import explained_variance
from armsyn.scoring.measures import measure, normalised_speed
from armsyn.scoring.posture import swivel_angles

MEASURES = {
    "movement_time_s": "movement time, s",
    "peak_speed_m_s": "peak speed, m/s",
    "time_to_peak": "time to peak, of movement time",
    "peak_over_mean": "peak / mean speed",
    "speed_peaks": "speed peaks",
    "min_jerk_r": "minimum jerk, r",
    "min_jerk_r2": "minimum jerk, R2",
    "sparc": "SPARC",
    "ldlj": "LDLJ (T = N / fs)",
    "path_over_distance": "path / distance",
    "deviation_over_distance": "largest deviation / distance",
    "swivel_change_deg": "swivel, end - start, deg",
    "swivel_end_deg": "swivel at the end, deg",
    "variance_1_component": "variance in 1 component",
    "variance_2_components": "variance in 2 components",
    "variance_3_components": "variance in 3 components",
}
"""By their names in JSON, with their labels for people."""


class How(NamedTuple):
    """One way of measuring, the same for everything that is set side by side."""

    cutoff: float | None = CUTOFF
    """Hz, of the low-pass on positions."""
    fraction: float = CUT_FRACTION
    """Of the peak speed, at onset and offset."""
    rate: float = LOWEST_RATE
    """Hz of the even grid: LDLJ moves with it."""


def human_likeness(motion: Motion, how: How) -> dict[str, float]:
    """Take every measure of a movement.

    Parameters
    ----------
    motion : Motion
        With landmarks; with joint angles for the coordination, and landmarks named shoulder and
        elbow for the swivel.
    how : How
        Filter, cut and rate.

    Returns
    -------
    dict
        By the keys of `MEASURES`; NaN where the motion does not have what a measure needs.

    Raises
    ------
    FormatError, InputError, CaptureError
        As `armsyn.scoring.measures.measure`.
    """
    profile = measure(motion, **how._asdict())
    moments = uniform_times(profile.onset, profile.offset, how.rate)
    swivel_start, swivel_end = _swivels(motion, moments)
    return {
        "movement_time_s": profile.movement_time,
        "peak_speed_m_s": profile.peak_speed,
        "time_to_peak": profile.time_to_peak,
        "peak_over_mean": profile.peak_over_mean,
        "speed_peaks": profile.speed_peaks,
        "min_jerk_r": profile.min_jerk_r,
        "min_jerk_r2": profile.min_jerk_r2,
        "sparc": profile.sparc,
        "ldlj": profile.ldlj,
        "path_over_distance": profile.path_over_distance,
        "deviation_over_distance": profile.deviation_over_distance,
        "swivel_change_deg": math.remainder(swivel_end - swivel_start, 360.0)
        if math.isfinite(swivel_start + swivel_end)
        else math.nan,
        "swivel_end_deg": swivel_end,
        **_coordination(motion, moments, how),
    }


def relative_speed(motion: Motion, how: How) -> FloatArray:
    """Return the hand's speed over its mean at 101 moments from onset to offset.

    Parameters
    ----------
    motion : Motion
        With landmarks.
    how : How
        Filter, cut and rate.

    Returns
    -------
    array, shape (101,)
        Dimensionless, mean 1: minimum jerk peaks at 1.875, or 1.658 after the cut at 5 %.

    Raises
    ------
    FormatError, InputError, CaptureError
        As `armsyn.scoring.measures.measure`.
    """
    speed = normalised_speed(motion.time, motion.hand, **how._asdict())
    return np.asarray(speed / np.trapezoid(speed, dx=1 / (speed.size - 1)))


def _swivels(motion: Motion, moments: FloatArray) -> tuple[float, float]:
    """Return the first and the last swivel angle that the arm has, degrees; NaN for none."""
    names = motion.landmark_names
    if motion.landmarks is None or not {"shoulder", "elbow"} <= set(names[:-1]):
        return math.nan, math.nan
    places = [names.index(name) for name in ("shoulder", "elbow")]
    places.append(names.index("wrist") if "wrist" in names else len(names) - 1)
    arm = interpolate(motion.time, motion.landmarks[:, places], moments)
    swivel = np.rad2deg(swivel_angles(arm[:, 0], arm[:, 1], arm[:, 2]))
    known = swivel[np.isfinite(swivel)]
    return (float(known[0]), float(known[-1])) if known.size else (math.nan, math.nan)


def _coordination(motion: Motion, moments: FloatArray, how: How) -> dict[str, float]:
    keys = ("variance_1_component", "variance_2_components", "variance_3_components")
    if motion.angles is None:
        return dict.fromkeys(keys, math.nan)
    angles = interpolate(motion.time, motion.angles, moments)
    if how.cutoff is not None:
        angles = low_pass(angles, how.rate, how.cutoff)
    return dict(zip(keys, explained_variance(angles).tolist(), strict=True))
