"""Many motions paced, held within their ranges, counted for bells and judged, in one call."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from armsyn.kernels.bells import Measure, count_along
from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiling import kernel
from armsyn.kernels.distance import ShapeArrays
from armsyn.kernels.judging import ALLOWED, Tolerances, judge_reaches
from armsyn.kernels.pacing import fill_beyond, hold_within, pace_reaches, sample_reaches
from armsyn.kernels.rates import RateLimits
from armsyn.kernels.sampling import Ease
from armsyn.kernels.types import BoolArray, FloatArray, IntArray


class Bounds(NamedTuple):
    """What motions are held to.

    Attributes
    ----------
    inside, swing : float
        rad (or m) by which a motion, and the spline through it, may leave the joints' ranges.
    reach : array, shape (k, n)
        How far each joint moves the two of a pair at most, m/rad.
    required : array, shape (k,)
        Clearances to keep, m.
    planned, limits : RateLimits
        To be slowed to, and to be judged by.
    """

    inside: float
    swing: float
    reach: FloatArray
    required: FloatArray
    planned: RateLimits
    limits: RateLimits


class Outcomes(NamedTuple):
    """What comes of M motions, each an array of shape (M,) that is filled.

    Attributes
    ----------
    beyond, swung : array of bool
        By `fill_beyond` and `hold_within`.
    scales : array
        By `pace_reaches`.
    peaks : array of int
        By `count_along`.
    kinds, frames, items, values : array
        By `judge_reaches`; `ALLOWED`, and no more, where that is not asked.
    """

    beyond: BoolArray
    swung: BoolArray
    scales: FloatArray
    peaks: IntArray
    kinds: IntArray
    frames: IntArray
    items: IntArray
    values: FloatArray


@kernel
def try_reaches(
    chain: ChainArrays,
    shapes: ShapeArrays,
    bounds: Bounds,
    tolerances: Tolerances,
    ease: Ease,
    measure: Measure,
    rate: float,
    in_bells: bool,
    motions: FloatArray,
    durations: FloatArray,
    found: Outcomes,
) -> tuple[IntArray, FloatArray]:
    """Pace motions, shape (M, phases, n), and judge them; return where each begins, and all frames.

    With `in_bells` only those are judged that stay within their ranges in one bell. `durations`
    are in s, `rate` is that of the frames, Hz.
    """
    count, n = motions.shape[0], motions.shape[2]
    lower, upper, frames = chain.lower, chain.upper, np.empty(count, dtype=np.int64)
    fill_beyond(lower, upper, bounds.inside, motions, found.beyond)
    span = tolerances.jerk_span
    pace_reaches(motions, durations, bounds.planned, rate, span, ease, frames, found.scales)
    first = np.zeros(count + 1, dtype=np.int64)
    for m in range(count):
        first[m + 1] = first[m] + frames[m]
    paths = np.empty((first[count], n))
    sample_reaches(motions, ease, first, paths)
    hold_within(lower, upper, bounds.swing, first, paths, found.swung)
    count_along(chain, paths, first, rate, found.scales, measure, found.peaks)
    for m in range(count):
        found.kinds[m] = ALLOWED
        if in_bells and (found.beyond[m] or found.swung[m] or found.peaks[m] > 1):
            continue
        here = slice(m, m + 1)
        judge_reaches(
            chain,
            shapes,
            bounds.reach,
            bounds.required,
            bounds.limits,
            rate,
            tolerances,
            first[m : m + 2],
            paths,
            found.kinds[here],
            found.frames[here],
            found.items[here],
            found.values[here],
        )
    return first, paths
