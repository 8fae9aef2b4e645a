"""Compiled loops over many reaches: where their hands are, and how often these speed up."""

from __future__ import annotations

import math

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


@kernel
def count_each(
    hands: FloatArray, first: IntArray, rate: float, rise: float, spacing: float, counts: IntArray
) -> None:
    """Fill how many peaks the speeds of hands, shape (all frames, 3), have, shape (M,)."""
    longest = 1
    for m in range(counts.shape[0]):
        longest = max(longest, first[m + 1] - first[m])
    speed = np.empty(longest)
    for m in range(counts.shape[0]):
        path = hands[first[m] : first[m + 1]]
        steps = max(path.shape[0] - 1, 0)
        for frame in range(steps):
            square = 0.0
            for k in range(3):
                moved = path[frame + 1, k] - path[frame, k]
                square += moved * moved
            speed[frame] = math.sqrt(square) * rate
        counts[m] = count_peaks(speed[:steps], rise, spacing) if steps else 0


@kernel
def edge_of(speed: FloatArray, peak: int, step: int, cut: float, slip: float, rest: int) -> int:
    """Walk from the peak until the speed stays below a cut: half of `onset_and_offset`.

    `step` is 1 or -1. A dip shorter than `rest` samples does not end the movement, if the speed
    rises to `slip` again beyond it.
    """
    size = speed.shape[0]
    at = peak
    while 0 <= at + step < size and speed[at + step] >= cut:
        at += step
    found = at
    while True:
        begin = at + step
        while 0 <= begin < size and speed[begin] < cut:
            begin += step
        if not 0 <= begin < size or abs(begin - at) - 1 >= rest:
            return found
        at, highest = begin, speed[begin]
        while 0 <= at + step < size and speed[at + step] >= cut:
            at += step
            highest = max(highest, speed[at])
        if highest >= slip:
            found = at


@kernel
def count_movements(
    speeds: FloatArray,
    lengths: IntArray,
    fraction: float,
    slip: float,
    rest: int,
    rise: float,
    spacing: float,
    counts: IntArray,
) -> None:
    """Fill how many peaks speeds, shape (M, samples), have from onset to offset, shape (M,).

    Parameters
    ----------
    lengths : array of int, shape (M,)
        Samples of each profile.
    fraction, slip : float
        Of the highest speed, as `armsyn.motion.segmentation.onset_and_offset` has them.
    rest : int
        Samples that the speed stays below the fraction where a movement ends.
    rise, spacing : float
        m/s and samples; see `count_peaks`.
    """
    for m in range(counts.shape[0]):
        speed = speeds[m, : lengths[m]]
        peak = 0
        for frame in range(speed.shape[0]):
            peak = frame if speed[frame] > speed[peak] else peak
        cut, least = fraction * speed[peak], slip * speed[peak]
        onset = edge_of(speed, peak, -1, cut, least, rest)
        offset = edge_of(speed, peak, 1, cut, least, rest)
        counts[m] = count_peaks(speed[onset : offset + 1], rise, spacing)


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
