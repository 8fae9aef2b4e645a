"""The captured workspace: the convex hull of captured targets, and how far outside it one lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import CaptureError
from armsyn.kernels.hull import outside_each

FloatArray = NDArray[np.float64]

FEWEST_TARGETS = 4
_ROUNDING_M = 1e-9


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
        found = np.empty(len(points))
        outside_each(self.triangles, self.planes, _ROUNDING_M, np.ascontiguousarray(points), found)
        return found
