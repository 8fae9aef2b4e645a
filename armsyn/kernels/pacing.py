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

LONGEST_S = 3600.0
"""What would take longer is not slowed any further."""
MOST_SCALINGS = 40
LEAST_SCALING = 1.01


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
    frames: IntArray,
    scales: FloatArray,
) -> None:
    """Find how slow each reach has to be for its limits to hold.

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
    frames : array of int, shape (M,)
        Filled; 0 for a reach that `MOST_SCALINGS` do not slow enough, that would take
        `LONGEST_S`, or that is not finite.
    scales : array, shape (M,)
        Filled: how many times as long each takes, at least 1.
    """
    n = angles.shape[2]
    spline, most, resting = spline_of(angles.shape[1], n), np.empty((3, n + WIDTH)), np.empty(0)
    for m in range(angles.shape[0]):
        fit_spline(angles[m], spline)
        start, end = ramps_of(spline.slopes, ease)
        frames[m] = 0
        scales[m] = 1.0
        for _ in range(MOST_SCALINGS):
            time = (1.0 + 0.5 * (start + end)) * durations[m] * scales[m]
            if not time < LONGEST_S:
                break
            count = int(np.ceil(time * rate)) + 1
            if resting_size(count, n, span) > resting.shape[0]:
                resting = np.empty(2 * resting_size(count, n, span))
            sample(spline, start, end, resting, (span + 1) * n, count, n)
            add_rests(resting, count, n, span)
            fill_greatest(resting, count, n, rate, span, most)
            excess = excess_of(most, limits)
            if excess <= 1.0:
                frames[m] = count
                break
            if not excess < np.inf:
                break
            scales[m] *= max(excess, LEAST_SCALING)


@kernel
def sample_reaches(angles: FloatArray, ease: Ease, first: IntArray, paths: FloatArray) -> None:
    """Fill `paths`, shape (all frames, n), with the frames that each reach was paced to.

    Sampled anew: to keep what was sampled when it was paced, it would have to be copied from
    arrays that are larger than what comes of them.
    """
    n = angles.shape[2]
    spline = spline_of(angles.shape[1], n)
    some = np.empty(0)
    for m in range(angles.shape[0]):
        frames = first[m + 1] - first[m]
        if frames:
            if frames * n + WIDTH > some.size:
                some = np.empty(2 * frames * n + WIDTH)
            fit_spline(angles[m], spline)
            start, end = ramps_of(spline.slopes, ease)
            sample(spline, start, end, some, 0, frames, n)
            lift(some, 0, paths[first[m] : first[m + 1]])


@kernel
def hold_within(
    lower: FloatArray,
    upper: FloatArray,
    swing: float,
    first: IntArray,
    paths: FloatArray,
    swung: BoolArray,
) -> None:
    """Clip paths, shape (all frames, n), to ranges; fill which leave them by more than `swing`.

    What is no number stays so, and is refused as out of range (`judge_reaches`).
    """
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
                inside = lower[j] if x < lower[j] else (upper[j] if x > upper[j] else x)
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
        behind = (count - 1 - m) * phases * n  # a short motion is less than room for others
        frames = phases if behind >= WIDTH else seen
        beyond[m] = not stays_within(motions, m * phases * n, frames, n, ranges, room)
        if frames < phases:
            lay(motions[m, seen:], final, 0)
            within = stays_within(final, 0, phases - seen, n, ranges, room)
            beyond[m] = beyond[m] or not within
