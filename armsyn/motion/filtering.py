"""The one filter of the project, and the hand's speed measured through it.

A second-order Butterworth low-pass run forwards and backwards: no lag, fourth order in amplitude,
half the amplitude left at the cut-off (no correction for the double pass). It is written out here
because importing scipy.signal costs about a second and 70 MB, and two biquad passes over a reach a
few milliseconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from armsyn.errors import CaptureError, InputError
from armsyn.motion.motion import FloatArray
from armsyn.motion.resample import interpolate, uniform_times

CUTOFF = 6.0
"""Hz; turns the 3-8 speed peaks that encoder ticks make of one reach into one."""
LOWEST_RATE = 100.0
"""Hz; slower captures are interpolated to it before filtering, so that onset, offset and peak
are not bound to a grid of 33 ms."""
REST = 0.5
"""Seconds that a hand is taken to rest, in its first and last posture, before and after its record.
So a record that was cut while moving measures the same as one that goes on at rest, and appending
rest changes nothing."""


@dataclass(frozen=True)
class SpeedProfile:
    """A hand's filtered path and its speed, evenly sampled.

    Parameters
    ----------
    time : array, shape (samples,)
        Seconds, on the clock of the motion it comes from, `REST` more on either side.
    positions : array, shape (samples, 3)
        Filtered positions, m.
    speed : array, shape (samples,)
        Length of the positions' derivative by central differences, m/s.
    rate : float
        Hz.
    cutoff : float or None
        Hz, of the filter; None when there was none.
    """

    time: FloatArray
    positions: FloatArray
    speed: FloatArray
    rate: float
    cutoff: float | None


def low_pass(values: FloatArray, rate: float, cutoff: float = CUTOFF) -> FloatArray:
    """Filter with a zero-lag second-order Butterworth low-pass.

    Both ends are continued by point reflection for one period of the cut-off (or as far as the
    signal is long), and each pass starts in the steady state of its first sample.

    Parameters
    ----------
    values : array, shape (samples, ...)
        Evenly sampled and finite, any unit; two samples are enough.
    rate : float
        Hz.
    cutoff : float
        Hz, below half the rate.

    Returns
    -------
    array, shape (samples, ...)
        In the unit of `values`.

    Raises
    ------
    InputError
        When the cut-off is not between zero and half the rate.
    CaptureError
        When there are fewer than two samples, or any is not finite.
    """
    if not 0 < cutoff < rate / 2:
        raise InputError(
            f"a signal at {rate:g} Hz has no {cutoff:g} Hz low-pass: lower the cut-off"
        )
    if len(values) < 2 or not np.isfinite(values).all():
        raise CaptureError("cannot filter fewer than two samples, or gaps: cut or fill them first")
    flat = values.reshape(len(values), -1)
    edge = min(len(flat) - 1, math.ceil(rate / cutoff))
    head = 2 * flat[0] - flat[edge:0:-1]
    tail = 2 * flat[-1] - flat[-2 : -edge - 2 : -1]
    extended = np.concatenate([head, flat, tail])
    forward = _one_pass(extended, rate, cutoff)
    both = _one_pass(forward[::-1], rate, cutoff)[::-1]
    return both[edge : edge + len(flat)].reshape(values.shape)


def _one_pass(values: FloatArray, rate: float, cutoff: float) -> FloatArray:
    """Run one biquad (bilinear transform with prewarping, transposed direct form II)."""
    k = math.tan(math.pi * cutoff / rate)
    scale = 1 / (1 + math.sqrt(2) * k + k * k)
    b0 = k * k * scale
    a1, a2 = 2 * (k * k - 1) * scale, (1 - math.sqrt(2) * k + k * k) * scale
    filtered = np.empty_like(values)
    for column in range(values.shape[1]):
        samples = values[:, column].tolist()
        first, second = (1 - b0) * samples[0], (b0 - a2) * samples[0]
        for frame, x in enumerate(samples):
            y = b0 * x + first
            first, second = 2 * b0 * x - a1 * y + second, b0 * x - a2 * y
            filtered[frame, column] = y
    return filtered


def hand_speed(
    time: FloatArray,
    positions: FloatArray,
    *,
    cutoff: float | None = CUTOFF,
    rate: float | None = None,
    rest: float = REST,
) -> SpeedProfile:
    """Measure a hand's speed: to an even grid between two rests, filter, differentiate.

    Parameters
    ----------
    time : array, shape (frames,)
        Seconds, strictly increasing, evenly spaced or not.
    positions : array, shape (frames, 3)
        m, finite.
    cutoff : float or None
        Hz; None leaves the positions as they are.
    rate : float or None
        Hz of the even grid; None takes the motion's mean rate, `LOWEST_RATE` at least.
    rest : float
        s that the hand is taken to rest before and after; 0 keeps the speed that a record which
        was cut while moving begins or ends with.

    Returns
    -------
    SpeedProfile
        Whole, from `rest` before the first stamp to `rest` after the last.

    Raises
    ------
    InputError
        When positions and time do not fit, or the motion's own rate cannot carry the cut-off.
    CaptureError
        When the positions have gaps, or are too many to resample.
    """
    if time.ndim != 1 or time.size < 2 or positions.shape != (time.size, 3):
        raise InputError(f"positions of shape {positions.shape} do not fit {time.size} times")
    own_rate = (time.size - 1) / float(time[-1] - time[0])
    if cutoff is not None and cutoff >= own_rate / 2:
        raise InputError(
            f"a motion sampled at {own_rate:.3g} Hz cannot carry a {cutoff:g} Hz low-pass:"
            " lower the cut-off, or sample faster"
        )
    rate = max(own_rate, LOWEST_RATE) if rate is None else rate
    before = round(rest * rate) / rate  # whole samples, so that the first stamp is one
    grid = uniform_times(float(time[0]) - before, float(time[-1]) + before, rate)
    even = interpolate(time, positions, grid)
    if not np.isfinite(even).all():
        raise CaptureError("the hand's positions have gaps: cut or fill them first")
    path = even if cutoff is None else low_pass(even, rate, cutoff)
    velocity = np.gradient(path, 1 / rate, axis=0)
    return SpeedProfile(grid, path, np.linalg.norm(velocity, axis=1), rate, cutoff)
