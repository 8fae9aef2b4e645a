"""How often hands speed up: filtered speeds of many reaches, and their peaks."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiling import kernel
from armsyn.kernels.placing import fill_tips
from armsyn.kernels.types import FloatArray, IntArray


class Measure(NamedTuple):
    """How a hand's speed is measured and its peaks are counted.

    Attributes
    ----------
    gain, last, before : float
        b0, a1 and a2 of the low-pass, which is passed forwards and backwards.
    rate : float
        Hz that hands are measured at.
    rest : int
        Samples that they rest before and after.
    rise : float
        m/s; see `count_peaks`.
    spacing : float
        Samples.
    """

    gain: float
    last: float
    before: float
    rate: float
    rest: int
    rise: float
    spacing: float


@kernel
def count_peaks(speed: FloatArray, rise: float, spacing: float) -> int:
    """Count submovements as `armsyn.motion.peaks.count_peaks` does, with spacing in samples."""
    count, last, start, rising = 0, 0, 0, True
    lowest = 0.0  # what is at its highest in the first sample came there from rest
    for frame in range(speed.shape[0]):
        v = speed[frame]
        if frame > 0 and v != speed[frame - 1]:
            before = speed[frame - 1]
            lowest = before if start == 0 and count == 0 else min(lowest, before)
            rising, start = v > before, frame
        ends = frame == speed.shape[0] - 1 or speed[frame + 1] < v
        if rising and ends and v - lowest >= rise:
            if count == 0 or start - last >= spacing:
                count += 1
                last, lowest = start, v
            elif v > speed[last]:
                last, lowest = start, v
    return count


@kernel
def fill_velocity(hand: FloatArray, measure: Measure, velocity: FloatArray) -> None:
    """Fill central differences, shape (3, samples), of a hand's path between rests."""
    last, rest, half = hand.shape[1] - 1, measure.rest, 0.5 * measure.rate
    for k in range(3):
        here, found = hand[k], velocity[k]
        found[:] = 0.0
        for i in range(1, last):
            found[rest + i] = half * (here[i + 1] - here[i - 1])
        found[rest] = half * (here[1] - here[0])
        found[rest + last] = half * (here[last] - here[last - 1])


@kernel
def resampled(hand: FloatArray, stretch: float) -> FloatArray:
    """A path, shape (3, frames), at every `stretch` of its frames, and its end once more."""
    last = hand.shape[1] - 1
    steps = int(last / stretch + 1e-3)
    found = np.empty((3, steps + 2))
    for i in range(steps + 2):
        place = min(i * stretch, float(last))
        row = min(int(place), last - 1)
        share = place - row
        for k in range(3):
            found[k, i] = hand[k, row] + share * (hand[k, row + 1] - hand[k, row])
    return found


@kernel
def low_pass(values: FloatArray, begin: int, measure: Measure) -> None:
    """Pass values, shape (3, samples), forwards and backwards through the filter.

    They are nought before `begin` and beyond their end.
    """
    size = values.shape[1]
    b0, a1, a2 = measure.gain, measure.last, measure.before
    for way in range(2):
        one0 = one1 = one2 = two0 = two1 = two2 = 0.0  # names, which stay in registers
        for step in range(begin if way == 0 else 0, size):
            i = step if way == 0 else size - 1 - step
            u0, u1, u2 = b0 * values[0, i], b0 * values[1, i], b0 * values[2, i]
            y0, y1, y2 = u0 + one0, u1 + one1, u2 + one2
            one0, one1, one2 = (
                2.0 * u0 - a1 * y0 + two0,
                2.0 * u1 - a1 * y1 + two1,
                2.0 * u2 - a1 * y2 + two2,
            )
            two0, two1, two2 = u0 - a2 * y0, u1 - a2 * y1, u2 - a2 * y2
            values[0, i], values[1, i], values[2, i] = y0, y1, y2


@kernel
def peaks_along(hand: FloatArray, rate: float, measure: Measure) -> int:
    """Count the peaks of the filtered speed of a hand, shape (3, frames), m."""
    path = hand if rate == measure.rate else resampled(hand, rate / measure.rate)
    velocity = np.empty((3, path.shape[1] + 2 * measure.rest))
    fill_velocity(path, measure, velocity)
    low_pass(velocity, measure.rest, measure)
    speed, y, z = velocity
    for i in range(speed.shape[0]):
        speed[i] = math.sqrt(speed[i] * speed[i] + y[i] * y[i] + z[i] * z[i])
    return count_peaks(speed, measure.rise, measure.spacing)


@kernel
def peaks_at_both(hand: FloatArray, rate: float, scale: float, measure: Measure) -> int:
    """Count peaks of a reach slowed `scale` times, as it is played and as a person would: the more.

    What makes a peak is a rise in m/s: slowed enough, a hand could stop half way and have one.
    """
    count = peaks_along(hand, rate, measure)
    if count <= 1 and scale > 1.0:
        count = max(count, peaks_along(hand, rate * scale, measure))
    return count


@kernel
def count_each(
    hands: FloatArray,
    first: IntArray,
    rate: float,
    scales: FloatArray,
    measure: Measure,
    counts: IntArray,
) -> None:
    """Fill how many peaks the filtered speeds of hands, shape (all frames, 3), have, shape (M,).

    Each is slowed so many times as `scales`, shape (M,), has it; see `peaks_at_both`.
    """
    for m in range(counts.shape[0]):
        counts[m] = 0
        if first[m + 1] - first[m] > 1:
            hand = np.ascontiguousarray(hands[first[m] : first[m + 1]].T)
            counts[m] = peaks_at_both(hand, rate, scales[m], measure)


@kernel
def count_along(
    chain: ChainArrays,
    paths: FloatArray,
    first: IntArray,
    rate: float,
    scales: FloatArray,
    measure: Measure,
    counts: IntArray,
) -> None:
    """Fill how many peaks hands along paths, shape (all frames, n), have; see `count_each`."""
    for m in range(counts.shape[0]):
        counts[m] = 0
        if first[m + 1] - first[m] > 1:
            hand = np.empty((3, first[m + 1] - first[m]))
            fill_tips(chain, paths[first[m] : first[m + 1]], hand)
            counts[m] = peaks_at_both(hand, rate, scales[m], measure)
