"""The captured reaches of an arm, the nearest first, for many plans."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import CaptureError
from armsyn.planning.hull import Hull
from armsyn.synergy import LearnedReach, SynergyLibrary, SynergySet

FloatArray = NDArray[np.float64]


class NearestReaches:
    """What `SynergyLibrary.nearest` finds, without looking at every reach in Python each time.

    Parameters
    ----------
    library : SynergyLibrary
    ik, model : str
        Of the sets that are wanted.

    Raises
    ------
    InputError
        The library has nothing learned with them that fits.
    """

    def __init__(self, library: SynergyLibrary, ik: str, model: str) -> None:
        self._found = library.nearest(np.zeros(3), np.zeros(3), ik, model)
        self._ends = np.array([[*reach.start_m, *reach.target_m] for reach, _ in self._found])
        targets = [reach.target_m for reach in library.reaches if reach.kind == "reach"]
        self._hull: Hull | None
        try:
            self._hull = Hull.of(np.array(targets).reshape(-1, 3))
        except CaptureError:  # too few of them to span anything
            self._hull = None

    def of(self, hand: FloatArray, goal: FloatArray) -> list[tuple[LearnedReach, SynergySet]]:
        """Return them for a reach from hand to goal, both of shape (3,), m."""
        gaps = np.linalg.norm(self._ends - np.concatenate([hand, goal]), axis=1)
        return [self._found[row] for row in np.argsort(gaps, kind="stable")]

    def outside(self, goal: FloatArray) -> float | None:
        """How far a target lies outside the hull of captured ones, m; None where there is none."""
        return None if self._hull is None else float(self._hull.outside(goal[None])[0])
