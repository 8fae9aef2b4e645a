"""Where an arm's shapes and its tip are at many postures at once, and how far apart they are."""

from __future__ import annotations

import math

import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiling import kernel
from armsyn.kernels.distance import BOX, CAPSULE, PLANE, ShapeArrays, box_distance
from armsyn.kernels.trigonometry import sines_and_cosines
from armsyn.kernels.types import FloatArray
from armsyn.kernels.vectors import WIDTH, Eight, eight, load, store

_LANES = 16


@kernel
def turn(path: FloatArray, first: int, joints: FloatArray) -> None:
    """Fill angles, sines and cosines, flat (3 n lanes,), of up to `_LANES` frames from `first` on.

    Lanes beyond the path repeat its last posture.
    """
    frames, n = path.shape
    size = n * _LANES
    for lane in range(_LANES):
        row = min(first + lane, frames - 1)
        for j in range(n):
            joints[j * _LANES + lane] = path[row, j]
    sines_and_cosines(joints[:size], joints[size : 2 * size], joints[2 * size :])


@kernel
def carried(
    chain: ChainArrays, link: int, joints: FloatArray, lane: int, local: FloatArray
) -> tuple[Eight, Eight, Eight]:
    """Return a point of a link in the base frame, in `WIDTH` lanes from `lane` on, m.

    From the link back to the base, for which a point is carried and no frame. `joints` is what
    `turn` fills, `local` the point in the link's frame, shape (3,).
    """
    size = joints.shape[0] // 3
    R, t = chain.rotation, chain.translation
    x, y, z = eight(local[0]), eight(local[1]), eight(local[2])
    for i in range(link, -1, -1):
        here = i * _LANES + lane
        if chain.prismatic[i]:
            z = z + load(joints, here)
        else:
            s, c = load(joints, here + size), load(joints, here + 2 * size)
            x, y = c * x - s * y, s * x + c * y
        x, y, z = (
            t[i, 0] + R[i, 0, 0] * x + R[i, 0, 1] * y + R[i, 0, 2] * z,
            t[i, 1] + R[i, 1, 0] * x + R[i, 1, 1] * y + R[i, 1, 2] * z,
            t[i, 2] + R[i, 2, 0] * x + R[i, 2, 1] * y + R[i, 2, 2] * z,
        )
    return x, y, z


@kernel
def fill_tips(chain: ChainArrays, path: FloatArray, hand: FloatArray) -> None:
    """Fill where the tip is along a path, (frames, n) to (3, frames), m."""
    frames, n = path.shape
    joints, tip = np.empty(3 * n * _LANES), chain.translation[n]
    some = np.empty((3, _LANES))
    for first in range(0, frames, _LANES):
        turn(path, first, joints)
        for lane in range(0, _LANES, WIDTH):
            x, y, z = carried(chain, n - 1, joints, lane, tip)
            store(some, lane, x)
            store(some, lane + _LANES, y)
            store(some, lane + 2 * _LANES, z)
        for k in range(3):
            for lane in range(min(_LANES, frames - first)):
                hand[k, first + lane] = some[k, lane]


@kernel
def place_lanes(
    chain: ChainArrays, shapes: ShapeArrays, path: FloatArray, ends: FloatArray
) -> None:
    """Fill the ends of all capsules at up to `_LANES` postures, shape (capsules, 6, lanes), m.

    As `distance.place`; lanes beyond the path repeat its last posture.
    """
    joints = np.empty(3 * path.shape[1] * _LANES)
    turn(path, 0, joints)
    for row in range(shapes.link.shape[0]):
        for lane in range(0, _LANES, WIDTH):
            at = row * 6 * _LANES + lane
            x, y, z = carried(chain, shapes.link[row], joints, lane, shapes.start[row])
            store(ends, at, x)
            store(ends, at + _LANES, y)
            store(ends, at + 2 * _LANES, z)
            x, y, z = carried(chain, shapes.link[row], joints, lane, shapes.end[row])
            store(ends, at + 3 * _LANES, x)
            store(ends, at + 4 * _LANES, y)
            store(ends, at + 5 * _LANES, z)


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
