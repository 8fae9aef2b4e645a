"""From a change of poses to an edited clip with its residuals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.constraints import Task
from armsyn.editing.figure import Clip, Figure
from armsyn.editing.pattern.branches import rewrapped_poses
from armsyn.editing.problem import Problem
from armsyn.editing.result import EditResult, Residual

FloatArray = NDArray[np.float64]


class Outcome:
    """Puts changes of poses into a clip and measures them against tasks.

    Parameters
    ----------
    clip : BodyMotion or Motion
    figure : Figure
    captured, base : array, shape (frames, n)
        The clip's poses on its own branches and on the pattern's, rad and m.
    tolerance : float
        m and rad.
    """

    def __init__(
        self,
        clip: Clip,
        figure: Figure,
        captured: FloatArray,
        base: FloatArray,
        tolerance: float,
    ) -> None:
        self._clip, self._figure = clip, figure
        self._captured, self._base, self._tolerance = captured, base, tolerance
        self._branched = not np.array_equal(captured, base)

    def result(
        self,
        tasks: Sequence[Task],
        change: FloatArray,
        iterations: int,
        own: FloatArray | None = None,
        coefficients: FloatArray | None = None,
        nearest: tuple[str, float] | None = None,
    ) -> EditResult:
        """Return the clip with `change`, shape (frames, n), added to its poses."""
        after = self._figure.inside(self._base + change, self._base)
        residuals = self._residuals(tasks, after)
        bodies = self._figure.tree.bodies
        return EditResult(
            clip=self._edited(after, change),
            original=self._clip,
            figure=self._figure,
            before=self._base,
            after=after,
            residuals=residuals,
            iterations=iterations,
            success=all(r.worst <= self._tolerance for r in residuals),
            constrained=tuple(dict.fromkeys(bodies[task.body] for task in tasks)),
            own_coefficients=own,
            coefficients=coefficients,
            nearest=nearest,
        )

    def _edited(self, after: FloatArray, change: FloatArray) -> Clip:
        poses = self._on_own_branches(after, change)
        if np.array_equal(poses, self._captured):
            return self._clip
        return self._figure.with_poses(self._clip, poses)

    def _on_own_branches(self, after: FloatArray, change: FloatArray) -> FloatArray:
        """Return poses on the captured branches; what did not change keeps its very bits."""
        moved = change != 0.0
        if self._branched:
            columns = self._figure.turns[:, None] + np.arange(3)
            moved[:, columns] = moved[:, columns].any(axis=-1, keepdims=True)
            after = rewrapped_poses(after, self._figure.turns, self._captured)
        return np.where(moved, after, self._captured)

    def _residuals(self, tasks: Sequence[Task], after: FloatArray) -> tuple[Residual, ...]:
        if not tasks:
            return ()
        nothing = np.zeros(self._figure.size)
        frames = {task.frame: after[task.frame] for task in tasks}
        problem = Problem(self._figure.tree, tasks, frames, dict.fromkeys(frames, nothing))
        worst: dict[tuple[int, str], Residual] = {}
        for task, miss in zip(problem.tasks, problem.errors(nothing), strict=True):
            size, key = float(np.linalg.norm(miss)), (task.constraint, task.label)
            if key not in worst or size > worst[key].worst:
                unit = "rad" if task.turning else "m"
                worst[key] = Residual(
                    task.label, task.level, size, task.frame, unit, task.constraint
                )
        return tuple(sorted(worst.values(), key=lambda r: (r.level, r.constraint)))
