"""Many reaches paced and judged: resampled over time, slowed, held against an arm's limits.

What `armsyn.safety` asks of one trajectory is asked here of many, in compiled loops: the same
differences, the same tolerances, the same search for contacts. Paths of different lengths lie one
after another in one array; ``first[m]`` is where path m begins, the last entry where all end.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiling import kernel
from armsyn.kernels.distance import BOX, CAPSULE, PLANE, ShapeArrays, box_distance, clearances
from armsyn.kernels.trigonometry import sines_and_cosines
from armsyn.kernels.types import FloatArray, IntArray

ALLOWED, RANGE, SPEED, ACCELERATION, JERK, CONTACT = range(6)
"""Verdicts on a path, in the order of their checks."""

_LANES = 16
_STRIDE = 16
_DEEPEST = 64

_MOST_SCALINGS = 40
_LEAST_SCALING = 1.01
_HOPELESS = 1e3


class RateLimits(NamedTuple):
    """How fast joints may move.

    Attributes
    ----------
    velocity, acceleration, jerk : array, shape (n,)
        rad/s, rad/s2, rad/s3 (or m).
    """

    velocity: FloatArray
    acceleration: FloatArray
    jerk: FloatArray


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
def fit_spline(angles: FloatArray, slopes: FloatArray, bends: FloatArray) -> None:
    """Fill the coefficients of the not-a-knot cubic spline through angles at steps of 1.

    All have shape (phases, n). Between phase i and the next it is
    ``angles + x (slopes + x (3 bends + x (bends' - bends)))``, where bends' are the next ones: a
    sixth of the second derivatives m, for which m[i-1] + 4 m[i] + m[i+1] is six times the second
    difference; next to the ends, where the third derivative does not step, m is the second
    difference itself (de Boor, *A Practical Guide to Splines*, 1978, chapter IV).
    """
    last, n = angles.shape[0] - 1, angles.shape[1]
    factors = np.zeros(last + 1)
    for i in range(1, last):
        straight = i in (1, last - 1)
        factors[i] = 0.0 if straight else 1.0 / (4.0 - factors[i - 1])
        for j in range(n):
            bend = angles[i - 1, j] - 2.0 * angles[i, j] + angles[i + 1, j]
            if straight:
                bends[i, j] = bend / 6.0
            else:
                bends[i, j] = (bend - bends[i - 1, j]) * factors[i]
    for i in range(last - 2, 1, -1):
        for j in range(n):
            bends[i, j] -= factors[i] * bends[i + 1, j]
    for j in range(n):
        bends[0, j] = 2.0 * bends[1, j] - bends[2, j]
        bends[last, j] = 2.0 * bends[last - 1, j] - bends[last - 2, j]
    for i in range(last):
        for j in range(n):
            step = angles[i + 1, j] - angles[i, j]
            slopes[i, j] = step - 2.0 * bends[i, j] - bends[i + 1, j]
    for j in range(n):
        step = angles[last, j] - angles[last - 1, j]
        slopes[last, j] = step + bends[last - 1, j] + 2.0 * bends[last, j]


@kernel
def ramps_of(slopes: FloatArray, ease: Ease) -> tuple[float, float]:
    """Return the ramps at start and end, as shares of the motion's own time.

    They are `ease.longest` where the joints move by `ease.share` of their greatest speed or more,
    shorter where the motion is nearer to rest.
    """
    peak = start = end = 0.0
    for i in range(slopes.shape[0]):
        square = 0.0
        for j in range(slopes.shape[1]):
            square += slopes[i, j] * slopes[i, j]
        peak = max(peak, square)
        if i == 0:
            start = square
        end = square
    if peak == 0.0:
        return 0.0, 0.0
    least = ease.share * math.sqrt(peak)
    return (
        ease.longest * min(math.sqrt(start) / least, 1.0),
        ease.longest * min(math.sqrt(end) / least, 1.0),
    )


@kernel
def gone(since: float, ramp: float) -> float:
    """Phase gone by so long into a ramp whose speed rises from 0 to 1 by minimum jerk."""
    x = since / ramp
    return ramp * x * x * x * x * (2.5 + x * (x - 3.0))


@kernel
def sample(
    angles: FloatArray,
    slopes: FloatArray,
    bends: FloatArray,
    start: float,
    end: float,
    path: FloatArray,
) -> None:
    """Fill `path`, shape (frames, n), with the spline at equal steps of time, both ends exact.

    The phase is eased in and out by ramps of `start` and `end` durations.
    """
    last, n = angles.shape[0] - 1, angles.shape[1]
    final = path.shape[0] - 1
    whole = 1.0 + 0.5 * (start + end)
    for frame in range(final):
        time = whole * frame / final
        if time < start:
            phase = gone(time, start)
        elif whole - time < end:
            phase = 1.0 - gone(whole - time, end)
        else:
            phase = time - 0.5 * start
        place = min(max(phase, 0.0), 1.0) * last
        i = min(int(place), last - 1)
        x = place - i
        # so much of what stands at phase i and at the next
        square = 3.0 * x * x - x * x * x
        cube = x * x * x
        for j in range(n):
            path[frame, j] = (
                angles[i, j] + x * slopes[i, j] + square * bends[i, j] + cube * bends[i + 1, j]
            )
    for j in range(n):
        path[0, j] = angles[0, j]
        path[final, j] = angles[last, j]


@kernel
def difference(
    values: FloatArray, count: int, apart: int, factor: float, result: FloatArray
) -> None:
    """Fill `count` differences of values so far apart, times a factor."""
    for i in range(count):
        result[i] = (values[i + apart] - values[i]) * factor


@kernel
def fill_rates(path: FloatArray, rate: float, span: int, rates: FloatArray) -> int:
    """Fill speeds, accelerations and jerks of a path at rest before and after; return their rows.

    `rates` has shape (4, rows n), with at least frames + 2 span + 2 rows, of which the last
    quantity is workspace. Row r of the speeds is from frame r - span - 1 to the next, of the
    accelerations about frame r - span; rows past the last of each quantity are zero.
    """
    frames, n = path.shape
    rows: int = frames + 2 * span + 1
    resting = rates[3]
    for row in range(span + 1):
        for j in range(n):
            resting[row * n + j] = path[0, j]
            resting[(row + span + 1 + frames) * n + j] = path[frames - 1, j]
    for row in range(frames):
        for j in range(n):
            resting[(row + span + 1) * n + j] = path[row, j]
    difference(resting, rows * n, n, rate, rates[0])
    difference(rates[0], (rows - 1) * n, n, rate, rates[1])
    difference(rates[1], (rows - 1 - span) * n, span * n, rate / span, rates[2])
    rates[1, (rows - 1) * n : rows * n] = 0.0
    rates[2, (rows - 1 - span) * n : rows * n] = 0.0
    return rows


@kernel
def greatest(rates: FloatArray, count: int, weights: FloatArray) -> float:
    """Greatest magnitude of weighted rates, both of shape (count,) at least."""
    best = np.zeros(_LANES)
    whole = count - count % _LANES
    for i in range(0, whole, _LANES):
        for lane in range(_LANES):
            best[lane] = max(best[lane], abs(rates[i + lane] * weights[i + lane]))
    for i in range(whole, count):
        best[0] = max(best[0], abs(rates[i] * weights[i]))
    most: float = best.max()
    return most


@kernel
def weights_of(limits: RateLimits, rows: int) -> FloatArray:
    """One over the limits again and again, shape (3, rows n)."""
    n = limits.velocity.shape[0]
    weights = np.empty((3, rows * n))
    for row in range(rows):
        for j in range(n):
            weights[0, row * n + j] = 1.0 / limits.velocity[j]
            weights[1, row * n + j] = 1.0 / limits.acceleration[j]
            weights[2, row * n + j] = 1.0 / limits.jerk[j]
    return weights


@kernel
def pace_reaches(
    angles: FloatArray,
    durations: FloatArray,
    limits: RateLimits,
    rate: float,
    span: int,
    ease: Ease,
    slopes: FloatArray,
    bends: FloatArray,
    ramps: FloatArray,
    frames: IntArray,
    scales: FloatArray,
) -> None:
    """Find how much each reach must be slowed until its limits hold.

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
    slopes, bends : array, shape (M, phases, n)
        Filled for `sample`.
    ramps : array, shape (M, 2)
        Filled, likewise.
    frames : array of int, shape (M,)
        Filled; 0 for a reach that `_MOST_SCALINGS` do not slow enough.
    scales : array, shape (M,)
        Filled: how many times as long each takes, at least 1.
    """
    n = angles.shape[2]
    path = np.empty((0, n))
    rates = np.empty((4, 0))
    weights = weights_of(limits, 0)
    for m in range(angles.shape[0]):
        fit_spline(angles[m], slopes[m], bends[m])
        start, end = ramps_of(slopes[m], ease)
        ramps[m, 0] = start
        ramps[m, 1] = end
        frames[m] = 0
        scales[m] = 1.0
        for _ in range(_MOST_SCALINGS):
            time = (1.0 + 0.5 * (start + end)) * durations[m] * scales[m]
            count = int(np.ceil(time * rate)) + 1
            if count > path.shape[0]:
                path = np.empty((2 * count, n))
                weights = weights_of(limits, 2 * count + 2 * span + 2)
                rates = np.empty((4, weights.shape[1]))
            sample(angles[m], slopes[m], bends[m], start, end, path[:count])
            size = fill_rates(path[:count], rate, span, rates) * n
            speed = greatest(rates[0], size, weights[0])
            strain = greatest(rates[1], size, weights[1])
            jolt = greatest(rates[2], size, weights[2])
            excess = max(speed, math.sqrt(strain), np.cbrt(jolt))
            if excess <= 1.0:
                frames[m] = count
                break
            if not excess < _HOPELESS:
                break
            scales[m] *= max(excess, _LEAST_SCALING)


@kernel
def sample_reaches(
    angles: FloatArray,
    slopes: FloatArray,
    bends: FloatArray,
    ramps: FloatArray,
    first: IntArray,
    paths: FloatArray,
) -> None:
    """Fill `paths`, shape (all frames, n), with every reach's own frames."""
    for m in range(angles.shape[0]):
        if first[m + 1] > first[m]:
            start, end = ramps[m]
            path = paths[first[m] : first[m + 1]]
            sample(angles[m], slopes[m], bends[m], start, end, path)


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
    rates: FloatArray, rows: int, limits: FloatArray, tolerance: float, rounded: float
) -> tuple[int, int]:
    """Row and joint of the rate that is greatest by its limit; (-1, -1) when that holds."""
    n = limits.shape[0]
    worst, at, joint = -1.0, 0, 0
    for row in range(rows):
        for j in range(n):
            part = abs(rates[row * n + j]) / limits[j]
            if part > worst:
                worst, at, joint = part, row, j
    if abs(rates[at * n + joint]) > limits[joint] * (1.0 + tolerance) + rounded:
        return at, joint
    return -1, -1


@kernel
def free_between(
    start: FloatArray,
    end: FloatArray,
    slack_start: FloatArray,
    slack_end: FloatArray,
    reach: FloatArray,
    resolution: float,
) -> bool:
    """Whether a straight step is surely free, or too small to be looked into."""
    for k in range(reach.shape[0]):
        moved = 0.0
        for j in range(reach.shape[1]):
            moved += abs(end[j] - start[j]) * reach[k, j]
        if slack_start[k] + slack_end[k] <= moved and moved > resolution:
            return False
    return True


@kernel
def contact_within(
    chain: ChainArrays,
    shapes: ShapeArrays,
    reach: FloatArray,
    required: FloatArray,
    resolution: float,
    ends: FloatArray,
    slacks: FloatArray,
) -> float:
    """First place, 0 to 1, of a straight step where something is too near; 2 when it is free.

    `ends`, shape (2, n), and `slacks`, shape (2, k), are what is known at both ends.
    """
    n, count = ends.shape[1], reach.shape[0]
    postures = np.empty((_DEEPEST, 2, n))
    known = np.empty((_DEEPEST, 2, count))
    begin = np.empty(_DEEPEST)
    width = np.empty(_DEEPEST)
    middle = np.empty((1, n))
    found = np.empty((1, count))
    postures[0] = ends
    known[0] = slacks
    begin[0] = 0.0
    width[0] = 1.0
    top, first = 1, 2.0
    while top:
        top -= 1
        if free_between(
            postures[top, 0], postures[top, 1], known[top, 0], known[top, 1], reach, resolution
        ):
            continue
        for j in range(n):
            middle[0, j] = 0.5 * (postures[top, 0, j] + postures[top, 1, j])
        clearances(chain, shapes, middle, found)
        broken = False
        for k in range(count):
            found[0, k] -= required[k]
            broken = broken or not found[0, k] >= 0.0
        half = 0.5 * width[top]
        if broken:  # what lies beyond does not matter any more
            first = begin[top] + half
            postures[0, 0], known[0, 0] = postures[top, 0], known[top, 0]
            begin[0] = begin[top]
            top = 0
        else:
            postures[top + 1, 0], known[top + 1, 0] = postures[top, 0], known[top, 0]
            begin[top + 1] = begin[top]
            postures[top, 0], known[top, 0] = middle[0], found[0]
            begin[top] += half
            width[top] = half
            top += 1
        postures[top, 1], known[top, 1] = middle[0], found[0]
        width[top] = half
        top += 1
    return first


@kernel
def turn_lanes(
    chain: ChainArrays, i: int, state: FloatArray, sines: FloatArray, cosines: FloatArray
) -> None:
    """Carry the frames of all lanes from joint i - 1 to joint i.

    `state`, shape (12 lanes,), holds rotations row by row, then positions; `sines` and `cosines`
    of joint i, shape (lanes,).
    """
    t0 = chain.translation[i, 0]
    t1 = chain.translation[i, 1]
    t2 = chain.translation[i, 2]
    f00 = chain.rotation[i, 0, 0]
    f01 = chain.rotation[i, 0, 1]
    f02 = chain.rotation[i, 0, 2]
    f10 = chain.rotation[i, 1, 0]
    f11 = chain.rotation[i, 1, 1]
    f12 = chain.rotation[i, 1, 2]
    f20 = chain.rotation[i, 2, 0]
    f21 = chain.rotation[i, 2, 1]
    f22 = chain.rotation[i, 2, 2]
    for row in range(3):
        R = state[3 * row * _LANES : 3 * (row + 1) * _LANES]
        p = state[(9 + row) * _LANES : (10 + row) * _LANES]
        for lane in range(_LANES):
            x = R[lane]
            y = R[lane + _LANES]
            z = R[lane + 2 * _LANES]
            p[lane] += x * t0 + y * t1 + z * t2
            s = sines[lane]
            c = cosines[lane]
            a = x * f00 + y * f10 + z * f20
            b = x * f01 + y * f11 + z * f21
            R[lane] = a * c + b * s
            R[lane + _LANES] = b * c - a * s
            R[lane + 2 * _LANES] = x * f02 + y * f12 + z * f22


@kernel
def reached(R: FloatArray, p: FloatArray, local: FloatArray, result: FloatArray) -> None:
    """Fill one coordinate of a point in the frames of all lanes, shape (lanes,), m."""
    x = local[0]
    y = local[1]
    z = local[2]
    for lane in range(_LANES):
        result[lane] = p[lane] + R[lane] * x + R[lane + _LANES] * y + R[lane + 2 * _LANES] * z


@kernel
def place_lanes(
    chain: ChainArrays, shapes: ShapeArrays, path: FloatArray, ends: FloatArray
) -> None:
    """Fill the ends of all capsules at up to `_LANES` postures, shape (capsules, 6, lanes), m.

    As `distance.place`; lanes beyond the path repeat its last posture.
    """
    frames, n = path.shape
    angles = np.empty(n * _LANES)
    sines = np.empty(n * _LANES)
    cosines = np.empty(n * _LANES)
    shifts = np.zeros(n * _LANES)
    for lane in range(_LANES):
        for j in range(n):
            angles[j * _LANES + lane] = path[min(lane, frames - 1), j]
    sines_and_cosines(angles, sines, cosines)
    for j in range(n):
        if chain.prismatic[j]:
            for i in range(j * _LANES, (j + 1) * _LANES):
                sines[i], cosines[i], shifts[i] = 0.0, 1.0, angles[i]
    state = np.zeros(12 * _LANES)
    for k in range(3):
        state[4 * k * _LANES : (4 * k + 1) * _LANES] = 1.0
    row = 0
    for i in range(-1, n):
        if i >= 0:
            here = slice(i * _LANES, (i + 1) * _LANES)
            turn_lanes(chain, i, state, sines[here], cosines[here])
            if chain.prismatic[i]:
                for k in range(3):
                    for lane in range(_LANES):
                        axis = state[(3 * k + 2) * _LANES + lane]
                        state[(9 + k) * _LANES + lane] += axis * shifts[i * _LANES + lane]
        while row < shapes.link.shape[0] and shapes.link[row] == i:
            for k in range(3):
                R = state[3 * k * _LANES : 3 * (k + 1) * _LANES]
                p = state[(9 + k) * _LANES : (10 + k) * _LANES]
                reached(R, p, shapes.start[row], ends[row, k])
                reached(R, p, shapes.end[row], ends[row, 3 + k])
            row += 1


@kernel
def segments_apart(one: FloatArray, other: FloatArray, result: FloatArray) -> None:
    """Fill the distances of two segments in all lanes, m: `distance.segment_distance`.

    `one` and `other` have shape (6, lanes), or flat (6 lanes,).
    """
    for lane in range(_LANES):
        px = one[lane]
        py = one[lane + _LANES]
        pz = one[lane + 2 * _LANES]
        ux = other[lane]
        uy = other[lane + _LANES]
        uz = other[lane + 2 * _LANES]
        dx = one[lane + 3 * _LANES] - px
        dy = one[lane + 4 * _LANES] - py
        dz = one[lane + 5 * _LANES] - pz
        ex = other[lane + 3 * _LANES] - ux
        ey = other[lane + 4 * _LANES] - uy
        ez = other[lane + 5 * _LANES] - uz
        rx = px - ux
        ry = py - uy
        rz = pz - uz
        a = dx * dx + dy * dy + dz * dz
        b = dx * ex + dy * ey + dz * ez
        e = ex * ex + ey * ey + ez * ez
        c = dx * rx + dy * ry + dz * rz
        f = ex * rx + ey * ry + ez * rz
        denominator = a * e - b * b
        crossing = denominator > 1e-14 * a * e
        over = 1.0 / (denominator if crossing else 1.0)
        over_a = 1.0 / (a if a > 0.0 else 1.0)
        over_e = 1.0 / (e if e > 0.0 else 1.0)
        s = min(max((b * f - c * e) * over, 0.0), 1.0) if crossing else 0.0
        t = (b * s + f) * over_e
        before = (t < 0.0) | (e == 0.0)
        s_before = min(max(-c * over_a, 0.0), 1.0)
        s_after = min(max((b - c) * over_a, 0.0), 1.0)
        s = s_before if before else (s_after if t > 1.0 else s)
        t = 0.0 if before else min(t, 1.0)
        gx = rx + s * dx - t * ex
        gy = ry + s * dy - t * ey
        gz = rz + s * dz - t * ez
        result[lane] = math.sqrt(gx * gx + gy * gy + gz * gz)


@kernel
def clearance_lanes(
    chain: ChainArrays, shapes: ShapeArrays, path: FloatArray, found: FloatArray
) -> None:
    """Fill the clearances of all pairs at up to `_LANES` postures, shape (k, lanes), m.

    As `distance.clearances`; lanes beyond the path repeat its last posture.
    """
    ends = np.empty((shapes.link.shape[0], 6, _LANES))
    place_lanes(chain, shapes, path, ends)
    flat = ends.reshape((shapes.link.shape[0], 6 * _LANES))
    local = np.empty(3)
    along = np.empty(3)
    for pair in range(shapes.pairs.shape[0]):
        kind = shapes.pairs[pair, 0]
        one = shapes.pairs[pair, 1]
        other = shapes.pairs[pair, 2]
        radius = shapes.radius[one]
        if kind == CAPSULE:
            radius += shapes.radius[other]
            segments_apart(flat[one], flat[other], found[pair])
        for lane in range(_LANES):
            if kind == PLANE:
                low = high = -shapes.planes[other, 3]
                for k in range(3):
                    low += shapes.planes[other, k] * ends[one, k, lane]
                    high += shapes.planes[other, k] * ends[one, 3 + k, lane]
                found[pair, lane] = min(low, high)
            elif kind == BOX:
                for k in range(3):
                    local[k] = along[k] = 0.0
                    for x in range(3):
                        turn = shapes.box_rotation[other, x, k]
                        local[k] += turn * (ends[one, x, lane] - shapes.box_centre[other, x])
                        along[k] += turn * (ends[one, 3 + x, lane] - ends[one, x, lane])
                found[pair, lane] = box_distance(local, along, shapes.box_half[other])
            found[pair, lane] -= radius


@kernel
def surely_free(
    path: FloatArray, slack_start: FloatArray, slack_end: FloatArray, reach: FloatArray
) -> bool:
    """Whether the clearances at a path's ends are more than all that it moves on the way."""
    for k in range(reach.shape[0]):
        moved = 0.0
        for frame in range(path.shape[0] - 1):
            for j in range(reach.shape[1]):
                moved += abs(path[frame + 1, j] - path[frame, j]) * reach[k, j]
        if not slack_start[k] + slack_end[k] > moved:
            return False
    return True


@kernel
def first_contact(
    chain: ChainArrays,
    shapes: ShapeArrays,
    reach: FloatArray,
    required: FloatArray,
    resolution: float,
    path: FloatArray,
) -> float:
    """Frame, with a fraction, of a path's first posture found too near; -1 when it is free.

    Every `_STRIDE` th posture is looked at, and all of them only where those leave a doubt.
    """
    frames, n = path.shape
    count = reach.shape[0]
    last = frames - 1
    few = (last + _STRIDE - 1) // _STRIDE + 1
    slack = np.empty((few, count))
    some = np.empty((_LANES, n))
    found = np.empty((count, _LANES))
    for begin in range(0, few, _LANES):
        for c in range(_LANES):
            some[c] = path[min((begin + c) * _STRIDE, last)]
        clearance_lanes(chain, shapes, some, found)
        for c in range(begin, min(begin + _LANES, few)):
            for k in range(count):
                slack[c, k] = found[k, c - begin] - required[k]
    every = np.empty((_STRIDE + 1, count))
    for c in range(few - 1):
        start, end = c * _STRIDE, min((c + 1) * _STRIDE, last)
        if surely_free(path[start : end + 1], slack[c], slack[c + 1], reach):
            continue
        clearance_lanes(chain, shapes, path[start:end], found)
        for k in range(count):
            for frame in range(end - start):
                every[frame, k] = found[k, frame] - required[k]
            every[end - start, k] = slack[c + 1, k]
        for frame in range(start, end):
            row = frame - start
            place = contact_within(
                chain,
                shapes,
                reach,
                required,
                resolution,
                path[frame : frame + 2],
                every[row : row + 2],
            )
            if place <= 1.0:
                return frame + place
            for k in range(count):
                if not every[row + 1, k] >= 0.0:
                    return frame + 1.0
    return -1.0


@kernel
def contact_facts(
    chain: ChainArrays, shapes: ShapeArrays, required: FloatArray, path: FloatArray, place: float
) -> tuple[int, float]:
    """Pair that touches at a place of a path, and its least clearance from there on, m."""
    frame, count = int(place), required.shape[0]
    row = int(np.ceil(place))
    here = np.empty((1, path.shape[1]))
    for j in range(path.shape[1]):
        here[0, j] = path[frame, j] + (place - frame) * (path[row, j] - path[frame, j])
    exact = np.empty((1, count))
    clearances(chain, shapes, here, exact)
    pair = 0
    for k in range(count):
        if exact[0, k] - required[k] < exact[0, pair] - required[pair]:
            pair = k
    found = np.empty((path.shape[0] - frame, count))
    clearances(chain, shapes, path[frame:], found)
    nearest = exact[0, pair]
    for later in range(found.shape[0]):
        nearest = min(nearest, found[later, pair])
    return pair, nearest


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
    longest = 1
    for m in range(verdicts.shape[0]):
        longest = max(longest, first[m + 1] - first[m])
    weights = weights_of(limits, longest + 2 * span + 2)
    rates = np.empty((4, weights.shape[1]))
    kept = np.empty(count)
    there = np.empty((1, count))
    for m in range(verdicts.shape[0]):
        path = paths[first[m] : first[m + 1]]
        verdicts[m], frames[m], items[m], values[m] = ALLOWED, 0, 0, np.nan
        if path.shape[0] < 2:
            continue
        frame, item = out_of_range(path, chain.lower, chain.upper, tolerances.position)
        if frame >= 0:
            verdicts[m], frames[m], items[m] = RANGE, frame, item
            values[m] = path[frame, item]
            continue
        rows = fill_rates(path, rate, span, rates)
        for kind in range(3):
            if greatest(rates[kind], rows * n, weights[kind]) <= 1.0 + tolerances.rate:
                continue
            if kind == 0:
                bound, rounded = limits.velocity, 2.0 * rate
            elif kind == 1:
                bound, rounded = limits.acceleration, 4.0 * rate * rate
            else:
                bound, rounded = limits.jerk, 8.0 * rate * rate * rate / span
            row, item = too_fast(
                rates[kind], rows, bound, tolerances.rate, tolerances.rounding * rounded
            )
            if row >= 0:
                frame = row if kind == 2 else row - span
                frames[m] = min(max(frame, 0), path.shape[0] - 1)
                verdicts[m], items[m], values[m] = SPEED + kind, item, rates[kind, row * n + item]
                break
        if verdicts[m] != ALLOWED or count == 0:
            continue
        clearances(chain, shapes, path[:1], there)
        for k in range(count):
            kept[k] = min(required[k], there[0, k] - tolerances.leaving)
        place = first_contact(chain, shapes, reach, kept, tolerances.resolution, path)
        if place >= 0.0:
            item, nearest = contact_facts(chain, shapes, kept, path, place)
            verdicts[m], frames[m], items[m], values[m] = CONTACT, int(place), item, nearest
