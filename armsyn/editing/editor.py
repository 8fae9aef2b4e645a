"""Edits of whole clips: by key-frames, by key-trajectories, and in the joint space."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.constraints import Constraint, KeyTrajectory, Pin, Task
from armsyn.editing.figure import Clip, Figure
from armsyn.editing.joint_space import bend_joints
from armsyn.editing.latent import LatentSolver
from armsyn.editing.pattern.branches import rewrapped_poses, unwrapped_poses
from armsyn.editing.pattern.learning import RADIANS_PER_METRE
from armsyn.editing.pattern.model import MotionModel
from armsyn.editing.problem import Problem
from armsyn.editing.result import EditResult, Residual
from armsyn.editing.solving import SolverOptions
from armsyn.editing.tasks import TaskMaker
from armsyn.errors import OutsidePatternError

FloatArray = NDArray[np.float64]
_ROUNDING = 1e-9


def edit_motion(
    clip: Clip,
    model: MotionModel,
    constraints: Sequence[Constraint],
    options: SolverOptions | None = None,
    *,
    force: bool = False,
) -> EditResult:
    """Bend a clip to constraints without leaving its pattern (LPIK).

    Key-frames and orientations are met by one change of the coefficients for the whole motion;
    then key-trajectories, frame by frame from there. Pins hold in both. What the components do
    not hold of the clip stays, so no constraints, or met ones, give the clip back bit for bit.

    Parameters
    ----------
    clip : BodyMotion or Motion
        A whole movement of the pattern's figure, at its own frames and times.
    model : MotionModel
    constraints : sequence of Constraint
    options : SolverOptions, optional
    force : bool
        Give the result however far from the examples it is.

    Returns
    -------
    EditResult

    Raises
    ------
    ConstraintError
        A frame outside the clip, or a body that is not there.
    PatternError
        A clip of another figure.
    OutsidePatternError
        When a coefficient beyond `coefficient_bound`, and beyond the clip's own, is needed.
    """
    options = options or SolverOptions()
    figure = model.figure
    base = unwrapped_poses(figure.poses(clip), figure.turns, model.mean[0])
    own = model.coefficients(clip)
    maker = TaskMaker(figure.tree, base)
    paths = maker.tasks([c for c in constraints if isinstance(c, KeyTrajectory)])
    others = [c for c in constraints if not isinstance(c, KeyTrajectory)]
    held = maker.tasks(others)
    solver = LatentSolver(model, base, clip.time, own, options)
    keyed = any(not isinstance(c, Pin) for c in others)
    bent = solver.key_frame(held if keyed else [])
    if paths:
        frames = {task.frame for task in paths}
        here = [*paths, *(task for task in held if task.frame in frames)]
        bent = solver.key_trajectory(here, bent)
    coefficients = own + bent.added
    if not force:
        _refuse_far(own, coefficients, options)
    nearest = model.nearest_example(coefficients[np.abs(coefficients).max(axis=1).argmax()])
    return _Outcome(clip, figure, base, [*paths, *held], options).result(
        bent.change, bent.iterations, own, coefficients, nearest
    )


def edit_in_joint_space(
    clip: Clip,
    figure: Figure,
    constraints: Sequence[Constraint],
    options: SolverOptions | None = None,
    *,
    radians_per_metre: float = RADIANS_PER_METRE,
) -> EditResult:
    """Bend a clip frame by frame in the joint space (PIK), as the paper compares.

    Only frames that a constraint names change, so paths need easing; a key-frame alone makes a
    jump.

    Parameters
    ----------
    clip : BodyMotion or Motion
    figure : Figure
    constraints : sequence of Constraint
        Pins hold at the frames where something else is asked for.
    options : SolverOptions, optional
    radians_per_metre : float
        What a metre of the root counts against a radian.

    Returns
    -------
    EditResult

    Raises
    ------
    ConstraintError, PatternError
        As `edit_motion`.
    """
    options = options or SolverOptions()
    base = unwrapped_poses(figure.poses(clip), figure.turns)
    tasks = TaskMaker(figure.tree, base).tasks(constraints)
    change, steps = bend_joints(figure, base, tasks, options, radians_per_metre)
    return _Outcome(clip, figure, base, tasks, options).result(change, steps)


def _refuse_far(own: FloatArray, coefficients: FloatArray, options: SolverOptions) -> None:
    """Refuse what is farther from the mean than allowed, and farther than the clip is itself."""
    largest, bound = float(np.abs(coefficients).max()), options.coefficient_bound
    if largest > max(bound, float(np.abs(own).max()) + _ROUNDING):
        raise OutsidePatternError(
            f"the edit needs a coefficient of {largest:.1f} standard deviations of the examples,"
            f" beyond the {bound:g} allowed: ask for less, learn from examples nearer to it, or"
            " force it",
            largest,
            bound,
        )


class _Outcome:
    """Puts a change of poses into the clip and measures it against the tasks."""

    def __init__(
        self,
        clip: Clip,
        figure: Figure,
        base: FloatArray,
        tasks: Sequence[Task],
        options: SolverOptions,
    ) -> None:
        self._clip, self._figure, self._base = clip, figure, base
        self._tasks, self._tolerance = tasks, options.tolerance

    def result(
        self,
        change: FloatArray,
        iterations: int,
        own: FloatArray | None = None,
        coefficients: FloatArray | None = None,
        nearest: tuple[str, float] | None = None,
    ) -> EditResult:
        after = self._base + change
        residuals = self._residuals(after)
        bodies = self._figure.tree.bodies
        return EditResult(
            clip=self._figure.with_poses(self._clip, self._on_own_branches(after, change)),
            original=self._clip,
            figure=self._figure,
            before=self._base,
            after=after,
            residuals=residuals,
            iterations=iterations,
            success=all(r.worst <= self._tolerance for r in residuals),
            constrained=tuple(dict.fromkeys(bodies[task.body] for task in self._tasks)),
            own_coefficients=own,
            coefficients=coefficients,
            nearest=nearest,
        )

    def _on_own_branches(self, after: FloatArray, change: FloatArray) -> FloatArray:
        """Return poses on the captured branches; what did not change keeps its very bits."""
        captured, figure = self._figure.poses(self._clip), self._figure
        moved = change != 0.0
        columns = figure.turns[:, None] + np.arange(3)
        if figure.turns.size:
            moved[:, columns] = moved[:, columns].any(axis=-1, keepdims=True)
        return np.where(moved, rewrapped_poses(after, figure.turns, captured), captured)

    def _residuals(self, after: FloatArray) -> tuple[Residual, ...]:
        if not self._tasks:
            return ()
        frames = {task.frame: after[task.frame] for task in self._tasks}
        still = {frame: np.zeros(self._figure.size) for frame in frames}
        problem = Problem(self._figure.tree, self._tasks, frames, still)
        missed = problem.errors(np.zeros(self._figure.size))
        worst: dict[str, Residual] = {}
        for task, miss in zip(problem.tasks, missed, strict=True):
            size = float(np.linalg.norm(miss))
            if task.label not in worst or size > worst[task.label].worst:
                unit = "rad" if task.turning else "m"
                worst[task.label] = Residual(task.label, task.level, size, task.frame, unit)
        return tuple(sorted(worst.values(), key=lambda residual: residual.level))
