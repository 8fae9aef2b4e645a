"""Clearances between the capsules of a serial chain, and between them and planes and boxes.

A capsule is a segment with a radius. Clearances are signed: below zero they say how deep two
shapes are in each other.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiling import kernel
from armsyn.kernels.trigonometry import sines_and_cosines
from armsyn.kernels.types import FloatArray, IntArray

CAPSULE, PLANE, BOX = 0, 1, 2
"""What the second of a pair is."""


class ShapeArrays(NamedTuple):
    """Shapes as kernels see them.

    Attributes
    ----------
    link : array of int, shape (m,)
        Row of the joint that moves each capsule; -1 for the base.
    start, end : array, shape (m, 3)
        Ends of its segment in that joint's canonical frame, m.
    radius : array, shape (m,)
        m.
    planes : array, shape (p, 4)
        Unit normal out of the solid half, and its product with a point of the plane, m.
    box_rotation : array, shape (b, 3, 3)
        From a box's frame to the base's.
    box_centre, box_half : array, shape (b, 3)
        In the base's frame, and half the box's edges, m.
    pairs : array of int, shape (k, 3)
        What is to be judged: `CAPSULE`, `PLANE` or `BOX`, a capsule's row, and the other's row.
    """

    link: IntArray
    start: FloatArray
    end: FloatArray
    radius: FloatArray
    planes: FloatArray
    box_rotation: FloatArray
    box_centre: FloatArray
    box_half: FloatArray
    pairs: IntArray


@kernel
def place(
    chain: ChainArrays,
    shapes: ShapeArrays,
    q: FloatArray,
    sines: FloatArray,
    cosines: FloatArray,
    start: FloatArray,
    end: FloatArray,
) -> None:
    """Fill the ends of all capsules, shape (m, 3), in the base frame at posture q, shape (n,), m.

    Capsules stand in the order of their links. `sines` and `cosines`, shape (n,), are workspace.
    """
    sines_and_cosines(q, sines, cosines)
    R = np.eye(3)
    S = np.empty((3, 3))
    p = np.zeros(3)
    row = 0
    for i in range(-1, q.shape[0]):
        if i >= 0:
            for k in range(3):
                for x in range(3):
                    p[k] += R[k, x] * chain.translation[i, x]
            for k in range(3):
                for x in range(3):
                    S[k, x] = 0.0
                    for y in range(3):
                        S[k, x] += R[k, y] * chain.rotation[i, y, x]
            s, c = sines[i], cosines[i]
            if chain.prismatic[i]:
                s, c = 0.0, 1.0
                for k in range(3):
                    p[k] += S[k, 2] * q[i]
            for k in range(3):
                R[k, 0] = S[k, 0] * c + S[k, 1] * s
                R[k, 1] = S[k, 1] * c - S[k, 0] * s
                R[k, 2] = S[k, 2]
        while row < shapes.link.shape[0] and shapes.link[row] == i:
            for k in range(3):
                start[row, k] = p[k]
                end[row, k] = p[k]
                for x in range(3):
                    start[row, k] += R[k, x] * shapes.start[row, x]
                    end[row, k] += R[k, x] * shapes.end[row, x]
            row += 1


@kernel
def segment_distance(p: FloatArray, q: FloatArray, u: FloatArray, v: FloatArray) -> float:
    """Distance of the segments p-q and u-v, m; all of shape (3,).

    Ericson, *Real-Time Collision Detection*, 2005, 5.1.9: the nearest point of one line, clamped,
    then that of the other, clamped, and the first again where that changed it.
    """
    a = b = e = c = f = 0.0
    for k in range(3):
        d1 = q[k] - p[k]
        d2 = v[k] - u[k]
        r = p[k] - u[k]
        a += d1 * d1
        b += d1 * d2
        e += d2 * d2
        c += d1 * r
        f += d2 * r
    s = 0.0
    t = 0.0
    if a > 0.0:
        denominator = a * e - b * b
        if e > 0.0 and denominator > 1e-14 * a * e:
            s = min(max((b * f - c * e) / denominator, 0.0), 1.0)
        t = (b * s + f) / e if e > 0.0 else 0.0
        if e == 0.0 or t < 0.0:
            t = 0.0
            s = min(max(-c / a, 0.0), 1.0)
        elif t > 1.0:
            t = 1.0
            s = min(max((b - c) / a, 0.0), 1.0)
    elif e > 0.0:
        t = min(max(f / e, 0.0), 1.0)
    square = 0.0
    for k in range(3):
        gap = p[k] + s * (q[k] - p[k]) - u[k] - t * (v[k] - u[k])
        square += gap * gap
    return math.sqrt(square)


@kernel
def box_slope(local: FloatArray, along: FloatArray, half: FloatArray, t: float) -> float:
    """Half the derivative of a point's squared distance to a box, as it runs along a segment."""
    slope = 0.0
    for k in range(3):
        x = local[k] + t * along[k]
        slope += (x - min(max(x, -half[k]), half[k])) * along[k]
    return slope


@kernel
def box_depth(local: FloatArray, along: FloatArray, half: FloatArray, t: float) -> float:
    """Signed distance of a point inside a box to its nearest face, not positive, m."""
    depth = -np.inf
    for k in range(3):
        depth = max(depth, abs(local[k] + t * along[k]) - half[k])
    return depth


@kernel
def box_distance(local: FloatArray, along: FloatArray, half: FloatArray) -> float:
    """Signed distance of a segment to a box about the origin, along its axes, m.

    Parameters
    ----------
    local, along : array, shape (3,)
        The segment's start, and the way to its end, in the box's frame, m.
    half : array, shape (3,)
        Half the edges, m.

    Returns
    -------
    float
        Below zero that of the segment's deepest point from the nearest face.
    """
    # The squared distance is convex along the segment and its slope linear between the places
    # where a coordinate passes a face: bracket the zero of the slope between two of those
    low, high = 0.0, 1.0
    slope_low = box_slope(local, along, half, low)
    slope_high = box_slope(local, along, half, high)
    if slope_low >= 0.0:
        high, slope_high = low, slope_low
    elif slope_high <= 0.0:
        low, slope_low = high, slope_high
    for k in range(3):
        if along[k] == 0.0:
            continue
        for side in (-1.0, 1.0):
            t = (side * half[k] - local[k]) / along[k]
            if low < t < high:
                slope = box_slope(local, along, half, t)
                if slope <= 0.0:
                    low, slope_low = t, slope
                else:
                    high, slope_high = t, slope
    t = low
    if slope_high > slope_low:
        t = low - slope_low * (high - low) / (slope_high - slope_low)
    square = 0.0
    for k in range(3):
        x = local[k] + t * along[k]
        gap = x - min(max(x, -half[k]), half[k])
        square += gap * gap
    if square > 0.0:
        return math.sqrt(square)
    # inside, depth is convex as well: 48 golden sections leave 1e-10 of the segment
    low, high = 0.0, 1.0
    for _ in range(48):
        step = 0.3819660112501051 * (high - low)
        if box_depth(local, along, half, low + step) < box_depth(local, along, half, high - step):
            high -= step
        else:
            low += step
    return box_depth(local, along, half, 0.5 * (low + high))


@kernel
def clearances(
    chain: ChainArrays, shapes: ShapeArrays, path: FloatArray, found: FloatArray
) -> None:
    """Fill the clearances of all pairs along a path, (frames, n) to (frames, k), m."""
    n = path.shape[1]
    count = shapes.link.shape[0]
    start = np.empty((count, 3))
    end = np.empty((count, 3))
    sines = np.empty(n)
    cosines = np.empty(n)
    local = np.empty(3)
    along = np.empty(3)
    for frame in range(path.shape[0]):
        place(chain, shapes, path[frame], sines, cosines, start, end)
        for pair in range(shapes.pairs.shape[0]):
            kind = shapes.pairs[pair, 0]
            one = shapes.pairs[pair, 1]
            other = shapes.pairs[pair, 2]
            if kind == CAPSULE:
                found[frame, pair] = (
                    segment_distance(start[one], end[one], start[other], end[other])
                    - shapes.radius[one]
                    - shapes.radius[other]
                )
            elif kind == PLANE:
                low = high = -shapes.planes[other, 3]
                for k in range(3):
                    low += shapes.planes[other, k] * start[one, k]
                    high += shapes.planes[other, k] * end[one, k]
                found[frame, pair] = min(low, high) - shapes.radius[one]
            else:
                for k in range(3):
                    local[k] = along[k] = 0.0
                    for x in range(3):
                        turn = shapes.box_rotation[other, x, k]
                        local[k] += turn * (start[one, x] - shapes.box_centre[other, x])
                        along[k] += turn * (end[one, x] - start[one, x])
                found[frame, pair] = (
                    box_distance(local, along, shapes.box_half[other]) - shapes.radius[one]
                )
