"""How far points lie outside a convex hull, by its triangles (armsyn.planning.hull)."""

from __future__ import annotations

import math

import numpy as np

from armsyn.kernels.compiling import kernel
from armsyn.kernels.types import FloatArray


@kernel
def outside_each(
    triangles: FloatArray,
    planes: FloatArray,
    rounding: float,
    points: FloatArray,
    found: FloatArray,
) -> None:
    """Fill how far points, shape (M, 3), lie outside, shape (M,), m; 0 inside.

    The nearest of the `triangles`, shape (F, 3, 3), is one whose plane, of `planes`, shape (F, 4),
    the point lies beyond by more than `rounding`, m.
    """
    for m in range(points.shape[0]):
        point = points[m]
        nearest = math.inf
        for face in range(planes.shape[0]):
            height = planes[face, 3]
            for k in range(3):
                height += planes[face, k] * point[k]
            if height > rounding:
                nearest = min(nearest, square_to_triangle(point, triangles[face]))
        found[m] = math.sqrt(nearest) if nearest < math.inf else 0.0


@kernel
def square_to_triangle(point: FloatArray, corners: FloatArray) -> float:
    """Squared distance of a point to a triangle, m2: to its plane's foot within, or its edges."""
    foot, least = np.empty(3), math.inf
    aa = ab = bb = pa = pb = 0.0
    for k in range(3):
        a, b = corners[1, k] - corners[0, k], corners[2, k] - corners[0, k]
        away = point[k] - corners[0, k]
        aa += a * a
        ab += a * b
        bb += b * b
        pa += away * a
        pb += away * b
    det = aa * bb - ab * ab
    u, v = (bb * pa - ab * pb) / det, (aa * pb - ab * pa) / det
    if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
        for k in range(3):
            foot[k] = (1.0 - u - v) * corners[0, k] + u * corners[1, k] + v * corners[2, k]
        return square_between(point, foot)
    for i in range(3):
        first, last = corners[i], corners[(i + 1) % 3]
        along = 0.0
        for k in range(3):
            along += (last[k] - first[k]) * (point[k] - first[k])
        share = min(max(along / square_between(last, first), 0.0), 1.0)
        for k in range(3):
            foot[k] = first[k] + share * (last[k] - first[k])
        least = min(least, square_between(point, foot))
    return least


@kernel
def square_between(one: FloatArray, other: FloatArray) -> float:
    """Squared distance of two points, m2."""
    total = 0.0
    for k in range(3):
        total += (one[k] - other[k]) * (one[k] - other[k])
    return total
