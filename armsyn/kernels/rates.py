"""How fast paths move: their greatest rates, and their ranges, several joints at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from armsyn.kernels.compiling import kernel
from armsyn.kernels.types import FloatArray
from armsyn.kernels.vectors import WIDTH, eight, greater, less, load, magnitude, store


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


@kernel
def resting_size(frames: int, n: int, span: int) -> int:
    """Elements of a flat path with rests before and after, and room behind."""
    return (frames + 2 * span + 2) * n + WIDTH


@kernel
def lay(path: FloatArray, flat: FloatArray, begin: int) -> None:
    """Lay a path, shape (frames, n), flat from element `begin` on."""
    values = path.reshape(path.size)
    for place in range(values.size):
        flat[begin + place] = values[place]


@kernel
def lift(flat: FloatArray, begin: int, path: FloatArray) -> None:
    """Fill a path, shape (frames, n), with what `lay` laid."""
    values = path.reshape(path.size)
    for place in range(values.size):
        values[place] = flat[begin + place]


@kernel
def add_rests(resting: FloatArray, frames: int, n: int, span: int) -> None:
    """Rest span + 1 frames before and after a flat path, which begins behind the first rest."""
    first, behind = (span + 1) * n, (span + 1 + frames) * n
    for place in range(first):
        resting[place] = resting[first + place % n]
    for place in range((span + 1) * n):
        resting[behind + place] = resting[behind - n + place % n]


@kernel
def fill_greatest(
    resting: FloatArray, frames: int, n: int, rate: float, span: int, most: FloatArray
) -> None:
    """Fill the greatest speed, acceleration and jerk of every joint, shape (3, n and room).

    `resting` is a path between its rests (`add_rests`), `rate` that of its frames, Hz; a jerk is
    taken over `span` frames.
    """
    for j in range(0, n, WIDTH):
        speed = strain = jolt = eight(0.0)
        for frame in range(frames + span):
            here, there = frame * n + j, (frame + span) * n + j
            before, after = load(resting, here + n), load(resting, here + 2 * n)
            velocity = before - load(resting, here)
            change = (after - before) - velocity
            before, after = load(resting, there + n), load(resting, there + 2 * n)
            later = (after - before) - (before - load(resting, there))
            speed = greater(magnitude(velocity), speed)
            strain = greater(magnitude(change), strain)
            jolt = greater(magnitude(later - change), jolt)
        store(most[0], j, rate * speed)
        store(most[1], j, rate * rate * strain)
        store(most[2], j, (rate * rate * rate / span) * jolt)


@kernel
def padded_ranges(lower: FloatArray, upper: FloatArray, tolerance: float) -> FloatArray:
    """Return ranges, shape (2, n and room), a tolerance wider; endless behind the last joint."""
    n = lower.shape[0]
    ranges = np.empty((2, n + WIDTH))
    ranges[0], ranges[1] = -np.inf, np.inf
    for j in range(n):
        ranges[0, j], ranges[1, j] = lower[j] - tolerance, upper[j] + tolerance
    return ranges


@kernel
def stays_within(
    path: FloatArray, begin: int, frames: int, n: int, ranges: FloatArray, beyond: FloatArray
) -> bool:
    """Whether frames of a flat path, from element `begin` on, are numbers within `ranges`.

    `beyond`, shape (n and room,), is workspace; so much is read behind the last frame.
    """
    for j in range(0, n, WIDTH):
        low, high, total = load(ranges[0], j), load(ranges[1], j), eight(0.0)
        for frame in range(frames):
            value = load(path, begin + frame * n + j)
            clipped = less(greater(value, low), high)  # no NaN: value - value might be folded to 0
            total = total + magnitude(value - clipped)
        store(beyond, j, total)
    inside = True
    for j in range(n):
        inside = inside and beyond[j] == 0.0  # which no sum with a NaN is
    return inside


@kernel
def fill_rates(path: FloatArray, rate: float, span: int, kind: int) -> FloatArray:
    """Return every speed (0), acceleration (1) or jerk (2) of a path at rest before and after.

    Row r of the speeds, shape (rows, n), is from frame r - span - 1 to the next, of the
    accelerations about frame r - span; a jerk is of frames r - span to r.
    """
    frames, n = path.shape
    rows = frames + 2 * span + 2
    resting = np.empty((rows, n))
    for row in range(rows):
        resting[row] = path[min(max(row - span - 1, 0), frames - 1)]
    rates = (resting[1:] - resting[:-1]) * rate
    if kind > 0:
        rates = (rates[1:] - rates[:-1]) * rate
    if kind > 1:
        rates = (rates[span:] - rates[:-span]) * (rate / span)
    return rates
