"""Motions brought to a common rate, or to a number of samples, by their time stamps.

Interpolation is linear, for landmark positions and joint angles alike: it never leaves the range
of its two neighbours, needs no history, and treats jittered stamps for what they are. At a
capture's 30 Hz it flattens the peak speed of a reach of 0.6 s or longer by under 1 %. A gap (NaN)
spreads to the intervals on either side of it, never further.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from armsyn.errors import CaptureError, InputError
from armsyn.motion.motion import BoolArray, FloatArray, Motion

MAXIMUM_SAMPLES = 2_000_000
"""Frames that one resampled motion may have: 2.8 hours at 200 Hz."""


def interpolate(time: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Interpolate samples linearly; outside their time the first or last sample holds.

    Parameters
    ----------
    time : array, shape (frames,)
        Seconds, strictly increasing.
    values : array, shape (frames, ...)
        Any unit.
    at : array, shape (samples,)
        Seconds.

    Returns
    -------
    array, shape (samples, ...)
        In the unit of `values`.
    """
    left = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
    weight = np.clip((at - time[left]) / (time[left + 1] - time[left]), 0.0, 1.0)
    weight = weight.reshape(-1, *[1] * (values.ndim - 1))
    between = values[left] * (1.0 - weight) + values[left + 1] * weight
    # A sample met exactly must not turn into a gap because its neighbour is one (0 * NaN).
    between = np.where(weight == 0.0, values[left], between)
    return np.where(weight == 1.0, values[left + 1], between)


def uniform_times(start: float, stop: float, rate: float) -> FloatArray:
    """Return the times from `start` to at most `stop` that are 1 / `rate` apart.

    Parameters
    ----------
    start, stop : float
        Seconds.
    rate : float
        Hz, positive.

    Returns
    -------
    array, shape (samples,)
        Seconds; the first is `start`.

    Raises
    ------
    InputError
        When the rate is not a positive number.
    CaptureError
        When there would be fewer than two samples, or more than `MAXIMUM_SAMPLES`.
    """
    if not (np.isfinite(rate) and rate > 0):
        raise InputError(f"cannot resample at {rate} Hz: give a positive rate")
    steps = (stop - start) * rate
    if not 1 - 1e-3 <= steps < MAXIMUM_SAMPLES:
        raise CaptureError(
            f"{stop - start:g} s at {rate:g} Hz are not between 2 and {MAXIMUM_SAMPLES} samples:"
            " choose another rate, or check the time stamps"
        )
    # A thousandth of a frame keeps a last frame that rounding puts a hair beyond its own stamp.
    return np.minimum(start + np.arange(int(steps + 1e-3) + 1) / rate, stop)


def at_times(motion: Motion, times: FloatArray) -> Motion:
    """Return the motion at other times, interpolated linearly.

    Parameters
    ----------
    motion : Motion
        Any.
    times : array, shape (samples,)
        Seconds on the motion's own clock; the first and last posture hold outside it.

    Returns
    -------
    Motion
        Same joints and landmarks, one frame a time.

    Raises
    ------
    FormatError
        When the times do not increase.
    """
    angles, landmarks = motion.angles, motion.landmarks
    return dataclasses.replace(
        motion,
        time=times,
        angles=None if angles is None else interpolate(motion.time, angles, times),
        landmarks=None if landmarks is None else interpolate(motion.time, landmarks, times),
        filled=None if motion.filled is None else _touched(motion.time, motion.filled, times),
    )


def _touched(time: FloatArray, filled: BoolArray, at: FloatArray) -> BoolArray:
    """Return which samples lean on a frame that was filled in."""
    return interpolate(time, filled.astype(np.float64), at) > 0.0


def resample(motion: Motion, rate: float) -> Motion:
    """Return the motion at a constant rate, from its first stamp to at most its last.

    Parameters
    ----------
    motion : Motion
        Any rate, evenly stamped or not.
    rate : float
        Hz.

    Returns
    -------
    Motion
        Frames 1 / `rate` apart, interpolated linearly.

    Raises
    ------
    InputError
        When the rate is not a positive number, or gives too few or too many frames.
    """
    return at_times(motion, uniform_times(float(motion.time[0]), float(motion.time[-1]), rate))
