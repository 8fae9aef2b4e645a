"""The captured workspace: the convex hull of captured targets, and how far outside it one lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import CaptureError

FloatArray = NDArray[np.float64]

FEWEST_TARGETS = 4
_ROUNDING_M = 1e-9
_MOST_PAIRS = 200_000
"""Points and triangles looked at together; bounds the memory, not the result."""


@dataclass(frozen=True)
class Hull:
    """A convex hull in space.

    Parameters
    ----------
    triangles : array, shape (F, 3, 3)
        Corners of its faces, m.
    planes : array, shape (F, 4)
        Their outward unit normals and offsets: ``normal @ x + offset > 0`` outside.
    """

    triangles: FloatArray
    planes: FloatArray

    @staticmethod
    def of(points: FloatArray) -> Hull:
        """Return the hull of points, shape (N, 3), m.

        Raises
        ------
        CaptureError
            Fewer than four points, or all in one plane.
        """
        from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  only learning needs it

        if len(points) < FEWEST_TARGETS:
            raise CaptureError(f"{len(points)} captured targets: a workspace needs four at least")
        try:
            hull = ConvexHull(points)
        except QhullError as error:
            raise CaptureError("the captured targets lie in one plane: no workspace") from error
        return Hull(np.asarray(points[hull.simplices]), np.asarray(hull.equations))

    def outside(self, points: FloatArray) -> FloatArray:
        """Return how far points, shape (M, 3), lie outside, shape (M,), m; 0 inside."""
        found = np.zeros(len(points))
        step = max(1, _MOST_PAIRS // len(self.planes))
        for first in range(0, len(points), step):
            part = points[first : first + step]
            # The nearest face is one that the point sees
            rows, faces = np.nonzero(part @ self.planes[:, :3].T + self.planes[:, 3] > _ROUNDING_M)
            gaps = _to_triangles(part[rows], self.triangles[faces])
            nearest = np.full(len(part), np.inf)
            np.minimum.at(nearest, rows, gaps)
            found[first : first + step] = np.where(np.isfinite(nearest), nearest, 0.0)
        return found


def _to_triangles(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Distances of points, shape (K, 3), to triangles, shape (K, 3, 3), each to its own."""
    corner, edges = triangles[:, 0], triangles[:, 1:] - triangles[:, :1]
    away = points - corner
    gram = np.einsum("kia,kja->kij", edges, edges)
    along = np.einsum("kia,ka->ki", edges, away)
    det = gram[:, 0, 0] * gram[:, 1, 1] - gram[:, 0, 1] ** 2
    u = (gram[:, 1, 1] * along[:, 0] - gram[:, 0, 1] * along[:, 1]) / det
    v = (gram[:, 0, 0] * along[:, 1] - gram[:, 0, 1] * along[:, 0]) / det
    over = (u >= 0) & (v >= 0) & (u + v <= 1)
    foot = u[:, None] * edges[:, 0] + v[:, None] * edges[:, 1]
    on_face = np.where(over, np.linalg.norm(away - foot, axis=1), np.inf)
    sides = [_to_edges(points, triangles[:, i], triangles[:, (i + 1) % 3]) for i in range(3)]
    return np.asarray(np.minimum.reduce([on_face, *sides]))


def _to_edges(points: FloatArray, first: FloatArray, last: FloatArray) -> FloatArray:
    edge, away = last - first, points - first
    share = np.einsum("ka,ka->k", edge, away) / np.einsum("ka,ka->k", edge, edge)
    return np.asarray(np.linalg.norm(away - np.clip(share, 0.0, 1.0)[:, None] * edge, axis=1))
