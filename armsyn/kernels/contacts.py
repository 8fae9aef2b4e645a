"""Where a path first comes too near to something: between its frames, too."""

from __future__ import annotations

import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiling import kernel
from armsyn.kernels.distance import ShapeArrays, clearances
from armsyn.kernels.placing import clearance_lanes
from armsyn.kernels.types import FloatArray
from armsyn.kernels.vectors import WIDTH, eight, load, magnitude, store

_LANES = 16
_STRIDE = 16
_DEEPEST = 64


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
def fill_ways(flat: FloatArray, frames: int, n: int, ways: FloatArray) -> None:
    """Fill how far each joint goes within every `_STRIDE` frames, shape (strides, n and room).

    `flat` is a path of `frames` frames, with room behind.
    """
    for c in range(ways.shape[0]):
        for j in range(0, n, WIDTH):
            way, here = eight(0.0), load(flat, c * _STRIDE * n + j)
            for frame in range(c * _STRIDE + 1, min((c + 1) * _STRIDE, frames - 1) + 1):
                before, here = here, load(flat, frame * n + j)
                way = way + magnitude(here - before)
            store(ways[c], j, way)


@kernel
def surely_free(
    way: FloatArray, slack_start: FloatArray, slack_end: FloatArray, reach: FloatArray
) -> bool:
    """Whether the clearances at a path's ends are more than all that it moves on the way.

    `way`, shape (n and room,), is how far each joint goes there and back.
    """
    for k in range(reach.shape[0]):
        moved = 0.0
        for j in range(reach.shape[1]):
            moved += way[j] * reach[k, j]
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
    flat: FloatArray,
) -> float:
    """Frame, with a fraction, of a path's first posture found too near; -1 when it is free.

    Every `_STRIDE` th posture is looked at, and all of them only where those leave a doubt.
    `flat` is the same path, with room behind.
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
    ways = np.empty((few - 1, n + WIDTH))
    fill_ways(flat, frames, n, ways)
    for c in range(few - 1):
        if not surely_free(ways[c], slack[c], slack[c + 1], reach):
            here = slice(c * _STRIDE, min((c + 1) * _STRIDE, last) + 1)
            place = contact_along(
                chain, shapes, reach, required, resolution, path[here], slack[c + 1]
            )
            if place >= 0.0:
                return c * _STRIDE + place
    return -1.0


@kernel
def contact_along(
    chain: ChainArrays,
    shapes: ShapeArrays,
    reach: FloatArray,
    required: FloatArray,
    resolution: float,
    path: FloatArray,
    slack_end: FloatArray,
) -> float:
    """As `first_contact`, of a path of up to `_STRIDE` + 1 frames, all of which are looked at.

    `slack_end` is known of the last.
    """
    last, count = path.shape[0] - 1, reach.shape[0]
    found, every = np.empty((count, _LANES)), np.empty((_STRIDE + 1, count))
    clearance_lanes(chain, shapes, path[:last], found)
    for k in range(count):
        for frame in range(last):
            every[frame, k] = found[k, frame] - required[k]
        every[last, k] = slack_end[k]
    for frame in range(last):
        ends, slacks = path[frame : frame + 2], every[frame : frame + 2]
        place = contact_within(chain, shapes, reach, required, resolution, ends, slacks)
        if place <= 1.0:
            return frame + place
        for k in range(count):
            if not every[frame + 1, k] >= 0.0:
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
