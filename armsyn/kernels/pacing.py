"""Many reaches paced: slowed until an arm's limits hold, and sampled."""

from __future__ import annotations

import math

import numpy as np

from armsyn.kernels.compiling import kernel
from armsyn.kernels.rates import (
    RateLimits,
    add_rests,
    fill_greatest,
    lay,
    lift,
    padded_ranges,
    resting_size,
    stays_within,
)
from armsyn.kernels.sampling import Ease, fit_spline, ramps_of, sample, spline_of
from armsyn.kernels.types import BoolArray, FloatArray, IntArray
from armsyn.kernels.vectors import WIDTH

_MOST_SCALINGS = 40
_LEAST_SCALING = 1.01
_HOPELESS = 1e3
_MOST_AT_ONCE = 1_000_000
"""Frames that are made room for when one more than all so far is needed."""


@kernel
def excess_of(most: FloatArray, limits: RateLimits) -> float:
    """By how much a path would have to be slowed; at most 1 within the limits."""
    speed = strain = jolt = 0.0
    for j in range(limits.velocity.shape[0]):
        speed = max(speed, most[0, j] / limits.velocity[j])
        strain = max(strain, most[1, j] / limits.acceleration[j])
        jolt = max(jolt, most[2, j] / limits.jerk[j])
    excess: float = max(speed, math.sqrt(strain), np.cbrt(jolt))
    return excess


@kernel
def pace_reaches(
    angles: FloatArray,
    durations: FloatArray,
    limits: RateLimits,
    rate: float,
    span: int,
    ease: Ease,
    first: IntArray,
    scales: FloatArray,
) -> FloatArray:
    """Sample reaches as slowly as their limits need.

    Parameters
    ----------
    angles : array, shape (M, phases, n)
        rad (or m) over normalised time.
    durations : array, shape (M,)
        s.
    limits : RateLimits
    rate : float
        Of the frames, Hz.
    span : int
        Frames over which a jerk is taken.
    ease : Ease
    first : array of int, shape (M + 1,)
        Filled: where each begins, and all end. A reach that `_MOST_SCALINGS` do not slow enough
        has no frames.
    scales : array, shape (M,)
        Filled: how many times as long each takes, at least 1.

    Returns
    -------
    array, shape (all frames, n)
    """
    n = angles.shape[2]
    spline, most = spline_of(angles.shape[1], n), np.empty((3, n + WIDTH))
    resting, paths = np.empty(0), np.empty((0, n))
    first[0] = 0
    for m in range(angles.shape[0]):
        fit_spline(angles[m], spline)
        start, end = ramps_of(spline.slopes, ease)
        begin = first[m + 1] = first[m]
        scales[m] = 1.0
        for _ in range(_MOST_SCALINGS):
            time = (1.0 + 0.5 * (start + end)) * durations[m] * scales[m]
            frames = int(np.ceil(time * rate)) + 1
            if resting_size(frames, n, span) > resting.shape[0]:
                resting = np.empty(2 * resting_size(frames, n, span))
            sample(spline, start, end, resting, (span + 1) * n, frames, n)
            add_rests(resting, frames, n, span)
            fill_greatest(resting, frames, n, rate, span, most)
            excess = excess_of(most, limits)
            if excess <= 1.0:
                if begin + frames > paths.shape[0]:
                    more = min(frames * (angles.shape[0] - m), max(frames, _MOST_AT_ONCE))
                    paths = grown(paths, begin, more)
                lift(resting, (span + 1) * n, paths[begin : begin + frames])
                first[m + 1] = begin + frames
                break
            if not excess < _HOPELESS:
                break
            scales[m] *= max(excess, _LEAST_SCALING)
    return paths[: first[-1]]


@kernel
def grown(paths: FloatArray, used: int, more: int) -> FloatArray:
    """Return paths with room for so many frames more, and a quarter as many again."""
    larger = np.empty((used + more + (used + more) // 4, paths.shape[1]))
    larger[:used] = paths[:used]
    return larger


@kernel
def hold_within(
    lower: FloatArray,
    upper: FloatArray,
    swing: float,
    first: IntArray,
    paths: FloatArray,
    swung: BoolArray,
) -> None:
    """Clip paths, shape (all frames, n), to ranges; fill which leave them by more than `swing`."""
    n, size = paths.shape[1], paths.shape[0]
    ranges, beyond = padded_ranges(lower, upper, 0.0), np.empty(n + WIDTH)
    for m in range(swung.shape[0]):
        begin, end = first[m], first[m + 1]
        seen = max(begin, min(end, size - WIDTH))  # behind whose frames there is room
        if not stays_within(paths, begin * n, seen - begin, n, ranges, beyond):
            seen = begin
        most = 0.0
        for frame in range(seen, end):
            for j in range(n):
                x = paths[frame, j]
                inside = min(max(x, lower[j]), upper[j])
                paths[frame, j] = inside
                most = max(most, abs(x - inside))
        swung[m] = most > swing


@kernel
def fill_beyond(
    lower: FloatArray, upper: FloatArray, inside: float, motions: FloatArray, beyond: BoolArray
) -> None:
    """Fill which motions, shape (M, phases, n), leave ranges by more than `inside`."""
    count, phases, n = motions.shape
    ranges, room = padded_ranges(lower, upper, inside), np.empty(n + WIDTH)
    final = np.empty(n * WIDTH + WIDTH)  # of the last motion, behind which there is no room
    seen = max(phases - WIDTH, 0)
    for m in range(count):
        frames = phases if m < count - 1 else seen
        beyond[m] = not stays_within(motions, m * phases * n, frames, n, ranges, room)
        if m == count - 1:
            lay(motions[m, seen:], final, 0)
            within = stays_within(final, 0, phases - seen, n, ranges, room)
            beyond[m] = beyond[m] or not within
