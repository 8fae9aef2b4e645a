"""A motion over phase as a cubic spline, sampled in time: eased from rest and to it.

Joints stand side by side (`armsyn.kernels.vectors`): a phase's row has room for a multiple of
`WIDTH` joints, a frame's for no more than there are.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.compiling import kernel
from armsyn.kernels.types import FloatArray
from armsyn.kernels.vectors import WIDTH, load, store


class Ease(NamedTuple):
    """How a motion that is cut at some speed comes from rest and to it.

    Attributes
    ----------
    longest : float
        Of the ramps at either end, as a share of the motion's own time.
    share : float
        Of the greatest speed, at which a ramp is that long; shorter below.
    """

    longest: float
    share: float


class Spline(NamedTuple):
    """A motion over phase, and room for the next one.

    Attributes
    ----------
    angles, slopes, bends : array, shape (phases, room)
        See `fit_spline`; rad (or m) a phase.
    factors : array, shape (phases,)
        Of the elimination, which depend on the number of phases only.
    """

    angles: FloatArray
    slopes: FloatArray
    bends: FloatArray
    factors: FloatArray


@kernel
def spline_of(phases: int, n: int) -> Spline:
    """Return room for a spline of n joints."""
    room = (n + WIDTH - 1) // WIDTH * WIDTH
    factors = np.zeros(phases)
    for i in range(2, phases - 2):
        factors[i] = 1.0 / (4.0 - factors[i - 1])
    shape = (phases, room)
    return Spline(np.zeros(shape), np.zeros(shape), np.zeros(shape), factors)


@kernel
def fit_spline(motion: FloatArray, spline: Spline) -> None:
    """Fill the not-a-knot cubic spline through a motion, shape (phases, n), at steps of 1.

    Between phase i and the next it is ``angles + x (slopes + x (3 bends + x (bends' - bends)))``,
    where bends' are the next ones: a sixth of the second derivatives m, for which m[i-1] + 4 m[i]
    + m[i+1] is six times the second difference; next to the ends, where the third derivative does
    not step, m is the second difference itself (de Boor, *A Practical Guide to Splines*, 1978,
    chapter IV).
    """
    angles, slopes, bends, factors = spline
    last, room = angles.shape[0] - 1, angles.shape[1]
    for i in range(last + 1):
        for j in range(motion.shape[1]):
            angles[i, j] = motion[i, j]
    for j in range(0, room, WIDTH):
        here, after = load(angles, j), load(angles, room + j)
        bend = here - here
        for i in range(1, last):
            before, here = here, after
            after = load(angles, (i + 1) * room + j)
            turn = before - 2.0 * here + after
            bend = turn * (1.0 / 6.0) if i in (1, last - 1) else (turn - bend) * factors[i]
            store(bends, i * room + j, bend)
        for i in range(last - 2, 1, -1):
            bend = load(bends, i * room + j) - factors[i] * bend
            store(bends, i * room + j, bend)
        second, third = load(bends, room + j), load(bends, 2 * room + j)
        store(bends, j, 2.0 * second - third)
        second, third = load(bends, (last - 1) * room + j), load(bends, (last - 2) * room + j)
        store(bends, last * room + j, 2.0 * second - third)
        for i in range(last):
            here, bend = i * room + j, load(bends, i * room + j)
            step = load(angles, here + room) - load(angles, here)
            store(slopes, here, step - 2.0 * bend - load(bends, here + room))
        step = load(angles, last * room + j) - load(angles, (last - 1) * room + j)
        bend = load(bends, (last - 1) * room + j) + 2.0 * load(bends, last * room + j)
        store(slopes, last * room + j, step + bend)


@kernel
def ramps_of(slopes: FloatArray, ease: Ease) -> tuple[float, float]:
    """Return the ramps at start and end, as shares of the motion's own time.

    They are `ease.longest` where the joints move by `ease.share` of their greatest speed or more,
    shorter where the motion is nearer to rest; NaN of a motion that is not finite.
    """
    peak = start = end = total = 0.0
    for i in range(slopes.shape[0]):
        square = 0.0
        for j in range(slopes.shape[1]):
            square += slopes[i, j] * slopes[i, j]
        peak = max(peak, square)
        total += square
        if i == 0:
            start = square
        end = square
    if not total < math.inf:  # maxima may pass over what is no number
        return math.nan, math.nan
    if peak == 0.0:
        return 0.0, 0.0
    least = ease.share * math.sqrt(peak)
    return (
        ease.longest * min(math.sqrt(start) / least, 1.0),
        ease.longest * min(math.sqrt(end) / least, 1.0),
    )


@kernel
def gone(x: float) -> float:
    """Phase gone by a share of a ramp whose speed rises from 0 to 1 by minimum jerk, of it."""
    square = x * x
    return square * square * (2.5 + x * (x - 3.0))


@kernel
def sample(
    spline: Spline,
    start: float,
    end: float,
    path: FloatArray,
    begin: int,
    frames: int,
    n: int,
) -> None:
    """Fill frames of a flat path, of n joints each, at equal steps of time, both ends exact.

    The phase is eased in and out by ramps of `start` and `end` durations; the first frame stands
    at element `begin`. What lies within `WIDTH` elements behind the last may be written to.
    """
    angles, slopes, bends, _ = spline
    last, room = angles.shape[0] - 1, angles.shape[1]
    final = frames - 1
    whole = 1.0 + 0.5 * (start + end)
    step, delay = whole / final, 0.5 * start
    in_start, in_end = 1.0 / max(start, 1e-300), 1.0 / max(end, 1e-300)
    for frame in range(frames):
        time = frame * step
        left = whole - time
        if time < start:
            phase = start * gone(time * in_start)
        elif left < end:
            phase = 1.0 - end * gone(left * in_end)
        else:
            phase = time - delay
        place = min(max(phase, 0.0), 1.0) * last
        i = min(int(place), last - 1)
        x = place - i
        # so much of what stands at phase i and at the next
        cube = x * x * x
        square = 3.0 * x * x - cube
        for j in range(0, room, WIDTH):
            here = i * room + j
            bend = square * load(bends, here) + cube * load(bends, here + room)
            value = load(angles, here) + x * load(slopes, here) + bend
            store(path, begin + frame * n + j, value)
    for j in range(n):
        path[begin + j] = angles[0, j]
        path[begin + final * n + j] = angles[last, j]
