"""What an edit made, and the figures that judge it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.feet import FootMotion, standing_feet
from armsyn.editing.figure import Clip, Figure
from armsyn.motion.body import BodyMotion

FloatArray = NDArray[np.float64]


class Residual(NamedTuple):
    """What a constraint was missed by.

    Attributes
    ----------
    label : str
    level : int
    worst : float
        Over its frames: m, or rad for an orientation.
    frame : int
        Where.
    unit : {"m", "rad"}
    constraint : int
        Its place in the list of constraints.
    """

    label: str
    level: int
    worst: float
    frame: int
    unit: str
    constraint: int

    @property
    def amount(self) -> str:
        """`worst` and where, for people."""
        size = 100.0 * self.worst if self.unit == "m" else np.degrees(self.worst)
        return f"{size:.4f} {'cm' if self.unit == 'm' else 'deg'} at frame {self.frame}"


@dataclass(frozen=True, eq=False)
class EditResult:
    """An edited clip.

    Attributes
    ----------
    clip : BodyMotion or Motion
        The edited one.
    original : BodyMotion or Motion
    figure : Figure
    before, after : array, shape (frames, n)
        Poses, on one branch, rad and m.
    residuals : tuple of Residual
        One a constraint, in the order of levels.
    iterations : int
        Of the solver, in all.
    success : bool
        Whether every constraint is met to the tolerance.
    constrained : tuple of str
        Bodies that a constraint names.
    own_coefficients : array, shape (m,), or None
        The clip's, whitened; None in the joint space.
    coefficients : array, shape (frames, m), or None
        The edited clip's, whitened, at each frame; all equal after a key-frame edit.
    nearest : tuple of (str, float), or None
        The example nearest to any frame's coefficients' largest, and its distance, sigma.
    """

    clip: Clip
    original: Clip
    figure: Figure
    before: FloatArray
    after: FloatArray
    residuals: tuple[Residual, ...]
    iterations: int
    success: bool
    constrained: tuple[str, ...]
    own_coefficients: FloatArray | None = None
    coefficients: FloatArray | None = None
    nearest: tuple[str, float] | None = None

    @property
    def level_errors(self) -> dict[int, float]:
        """Worst residual of each level, m or rad."""
        found: dict[int, float] = {}
        for residual in self.residuals:
            found[residual.level] = max(found.get(residual.level, 0.0), residual.worst)
        return found

    @property
    def largest_coefficient(self) -> float | None:
        """Largest whitened coefficient: standard deviations from the mean motion."""
        return None if self.coefficients is None else float(np.abs(self.coefficients).max())

    @cached_property
    def positions(self) -> tuple[FloatArray, FloatArray]:
        """Bodies' positions before and after, each (frames, bodies, 3), m."""
        tree = self.figure.tree
        return tree.positions(self.before), tree.positions(self.after)

    @property
    def start_drift_m(self) -> float:
        """How far the constrained bodies moved at the first frame, the farthest of them, m."""
        before, after = self.positions
        rows = [self.figure.tree.body(name) for name in self.constrained]
        return float(np.linalg.norm(after[0, rows] - before[0, rows], axis=-1).max(initial=0.0))

    @cached_property
    def feet(self) -> dict[str, FootMotion]:
        """How far each foot slides and lifts while it stands; empty without feet."""
        if not isinstance(self.original, BodyMotion):
            return {}
        return standing_feet(self.figure.tree.bodies, self.original.time, *self.positions)

    @property
    def foot_slide_m(self) -> dict[str, tuple[float, float]] | None:
        """How far each foot slides while it stands, before and after, m; None without feet."""
        return {name: (f.slide_before, f.slide_after) for name, f in self.feet.items()} or None
