"""Compiled loops over many reaches: where their hands are, and how often these speed up."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiling import kernel
from armsyn.kernels.distance import ShapeArrays
from armsyn.kernels.reaches import place_lanes
from armsyn.kernels.types import BoolArray, FloatArray, IntArray

_LANES = 16


@kernel
def place_hands(chain: ChainArrays, tip: ShapeArrays, paths: FloatArray, hands: FloatArray) -> None:
    """Fill the tip's positions, shape (frames, 3), at all postures, shape (frames, n)."""
    ends = np.empty((1, 6, _LANES))
    for begin in range(0, paths.shape[0], _LANES):
        some = paths[begin : begin + _LANES]
        place_lanes(chain, tip, some, ends)
        for k in range(3):
            for lane in range(some.shape[0]):
                hands[begin + lane, k] = ends[0, k, lane]


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
def fill_velocity(path: FloatArray, rate: float, measure: Measure, velocity: FloatArray) -> None:
    """Fill central differences, shape (samples, 3), of a hand's path at `rate`, between rests."""
    last = path.shape[0] - 1
    stretch = rate / measure.rate
    if stretch == 1.0:
        velocity[:] = 0.0
        for i in range(-1, last + 2):
            before, after = max(i - 1, 0), min(i + 1, last)
            for k in range(3):
                moved = path[after, k] - path[before, k]
                velocity[i + measure.rest, k] = 0.5 * measure.rate * moved
        return
    for i in range(velocity.shape[0]):
        for k in range(3):
            velocity[i, k] = 0.0
        for side in range(-1, 2, 2):
            place = min(max((i + side - measure.rest) * stretch, 0.0), float(last))
            row = min(int(place), max(last - 1, 0))
            share = place - row
            for k in range(3):
                here = path[row, k]
                if share > 0.0:
                    here += share * (path[row + 1, k] - here)
                velocity[i, k] += 0.5 * side * measure.rate * here


@kernel
def low_pass(values: FloatArray, measure: Measure) -> None:
    """Pass values, shape (samples, 3), which are nought before and after, through the filter."""
    size = values.shape[0]
    b0, a1, a2 = measure.gain, measure.last, measure.before
    for way in range(2):
        one0 = one1 = one2 = two0 = two1 = two2 = 0.0  # names, which stay in registers
        for step in range(size):
            i = step if way == 0 else size - 1 - step
            u0, u1, u2 = b0 * values[i, 0], b0 * values[i, 1], b0 * values[i, 2]
            y0, y1, y2 = u0 + one0, u1 + one1, u2 + one2
            one0, one1, one2 = (
                2.0 * u0 - a1 * y0 + two0,
                2.0 * u1 - a1 * y1 + two1,
                2.0 * u2 - a1 * y2 + two2,
            )
            two0, two1, two2 = u0 - a2 * y0, u1 - a2 * y1, u2 - a2 * y2
            values[i, 0], values[i, 1], values[i, 2] = y0, y1, y2


@kernel
def count_each(
    hands: FloatArray, first: IntArray, rate: float, measure: Measure, counts: IntArray
) -> None:
    """Fill how many peaks the filtered speeds of hands, shape (all frames, 3), have, shape (M,)."""
    for m in range(counts.shape[0]):
        path = hands[first[m] : first[m + 1]]
        counts[m] = 0
        if path.shape[0] < 2:
            continue
        steps = int((path.shape[0] - 1) * measure.rate / rate + 1e-3)
        velocity = np.empty((steps + 1 + 2 * measure.rest, 3))
        fill_velocity(path, rate, measure, velocity)
        low_pass(velocity, measure)
        speed = np.empty(velocity.shape[0])
        for i in range(speed.shape[0]):
            square = 0.0
            for k in range(3):
                square += velocity[i, k] * velocity[i, k]
            speed[i] = math.sqrt(square)
        counts[m] = count_peaks(speed, measure.rise, measure.spacing)


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
    for m in range(swung.shape[0]):
        swung[m] = False
        for frame in range(first[m], first[m + 1]):
            for j in range(paths.shape[1]):
                x = paths[frame, j]
                inside = min(max(x, lower[j]), upper[j])
                paths[frame, j] = inside
                swung[m] = swung[m] or abs(x - inside) > swing
