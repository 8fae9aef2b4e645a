"""Many reaches held against an arm's limits and shapes.

What `armsyn.safety` asks of one trajectory is asked here of many, in compiled loops: the same
differences, the same tolerances, the same search for contacts. Paths of different lengths lie one
after another in one array; ``first[m]`` is where path m begins, the last entry where all end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiling import kernel
from armsyn.kernels.contacts import contact_facts, first_contact
from armsyn.kernels.distance import ShapeArrays, clearances
from armsyn.kernels.rates import (
    RateLimits,
    add_rests,
    fill_greatest,
    fill_rates,
    lay,
    padded_ranges,
    resting_size,
    stays_within,
)
from armsyn.kernels.types import FloatArray, IntArray
from armsyn.kernels.vectors import WIDTH

ALLOWED, RANGE, SPEED, ACCELERATION, JERK, CONTACT = range(6)
"""Verdicts on a path, in the order of their checks."""


class Tolerances(NamedTuple):
    """What checks forgive.

    Attributes
    ----------
    position : float
        rad (or m) past a joint's range.
    rate : float
        Part of a speed, acceleration or jerk limit.
    rounding : float
        rad (or m) that angles may be rounded by.
    jerk_span : int
        Frames over which a jerk is taken.
    leaving : float
        m by which a path may deepen a contact that it starts in.
    resolution : float
        m of motion between two postures that is not looked into any further.
    """

    position: float
    rate: float
    rounding: float
    jerk_span: int
    leaving: float
    resolution: float


@kernel
def out_of_range(
    path: FloatArray, lower: FloatArray, upper: FloatArray, tolerance: float
) -> tuple[int, int]:
    """First frame and joint outside its range; (-1, -1) when there are none."""
    for frame in range(path.shape[0]):
        for j in range(lower.shape[0]):
            value = path[frame, j]
            if not lower[j] - tolerance <= value <= upper[j] + tolerance:
                return frame, j
    return -1, -1


@kernel
def too_fast(
    rates: FloatArray, limits: FloatArray, tolerance: float, rounded: float
) -> tuple[int, int]:
    """Row and joint of the rate that is greatest by its limit; (-1, -1) when that holds."""
    worst, at, joint = -1.0, 0, 0
    for row in range(rates.shape[0]):
        for j in range(rates.shape[1]):
            part = abs(rates[row, j]) / limits[j]
            if part > worst:
                worst, at, joint = part, row, j
    if abs(rates[at, joint]) > limits[joint] * (1.0 + tolerance) + rounded:
        return at, joint
    return -1, -1


@kernel
def exceeds(most: FloatArray, limits: FloatArray, tolerance: float) -> bool:
    """Whether any joint's greatest rate is beyond its limit."""
    part = 0.0
    for j in range(limits.shape[0]):
        part = max(part, most[j] / limits[j])
    return part > 1.0 + tolerance


@kernel
def judge_reaches(
    chain: ChainArrays,
    shapes: ShapeArrays,
    reach: FloatArray,
    required: FloatArray,
    limits: RateLimits,
    rate: float,
    tolerances: Tolerances,
    first: IntArray,
    paths: FloatArray,
    verdicts: IntArray,
    frames: IntArray,
    items: IntArray,
    values: FloatArray,
) -> None:
    """Judge reaches as `armsyn.safety.check_trajectory` does one.

    Parameters
    ----------
    chain : ChainArrays
    shapes : ShapeArrays
    reach : array, shape (k, n)
        How far each joint moves the two of a pair at most, m/rad.
    required : array, shape (k,)
        Clearances to keep, m.
    limits : RateLimits
    rate : float
        Of the frames, Hz.
    tolerances : Tolerances
    first : array of int, shape (M + 1,)
    paths : array, shape (all frames, n)
    verdicts, frames, items : array of int, shape (M,)
        Filled: the verdict, and where it is not `ALLOWED` the frame and the joint, or the pair.
    values : array, shape (M,)
        Filled with the angle, rate or clearance that is refused; NaN where nothing is.
    """
    n, count = paths.shape[1], required.shape[0]
    span = tolerances.jerk_span
    resting, most = np.empty(0), np.empty((3, n + WIDTH))
    ranges = padded_ranges(chain.lower, chain.upper, tolerances.position)
    kept = np.empty(count)
    there = np.empty((1, count))
    bounds = (limits.velocity, limits.acceleration, limits.jerk)
    rounded = (2.0 * rate, 4.0 * rate * rate, 8.0 * rate * rate * rate / span)
    for m in range(verdicts.shape[0]):
        path = paths[first[m] : first[m + 1]]
        verdicts[m], frames[m], items[m], values[m] = ALLOWED, 0, 0, np.nan
        if path.shape[0] < 2:
            continue
        if resting_size(path.shape[0], n, span) > resting.shape[0]:
            resting = np.empty(2 * resting_size(path.shape[0], n, span))
        begin = (span + 1) * n
        lay(path, resting, begin)
        if not stays_within(resting, begin, path.shape[0], n, ranges, most[0]):
            frame, item = out_of_range(path, chain.lower, chain.upper, tolerances.position)
            verdicts[m], frames[m], items[m] = RANGE, frame, item
            values[m] = path[frame, item]
            continue
        add_rests(resting, path.shape[0], n, span)
        fill_greatest(resting, path.shape[0], n, rate, span, most)
        for kind in range(3):
            if not exceeds(most[kind], bounds[kind], tolerances.rate):
                continue
            rates = fill_rates(path, rate, span, kind)
            rounding = tolerances.rounding * rounded[kind]
            row, item = too_fast(rates, bounds[kind], tolerances.rate, rounding)
            if row >= 0:
                frame = row if kind == 2 else row - span
                frames[m] = min(max(frame, 0), path.shape[0] - 1)
                verdicts[m], items[m], values[m] = SPEED + kind, item, rates[row, item]
                break
        if verdicts[m] != ALLOWED or count == 0:
            continue
        clearances(chain, shapes, path[:1], there)
        for k in range(count):
            kept[k] = min(required[k], there[0, k] - tolerances.leaving)
        place = first_contact(
            chain, shapes, reach, kept, tolerances.resolution, path, resting[begin:]
        )
        if place >= 0.0:
            item, nearest = contact_facts(chain, shapes, kept, path, place)
            verdicts[m], frames[m], items[m], values[m] = CONTACT, int(place), item, nearest
