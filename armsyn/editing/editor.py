"""Edits of whole clips: by key-frames, by key-trajectories, and in the joint space.

An `Editor` has done for one clip what does not depend on constraints, so that dragging a goal
about costs only the solving; `edit_motion` is one of its edits.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.constraints import Constraint, KeyTrajectory, Pin
from armsyn.editing.figure import Clip, Figure
from armsyn.editing.joint_space import bend_joints
from armsyn.editing.latent import LatentSolver
from armsyn.editing.outcome import Outcome
from armsyn.editing.pattern.branches import unwrapped_poses
from armsyn.editing.pattern.learning import RADIANS_PER_METRE
from armsyn.editing.pattern.model import MotionModel
from armsyn.editing.refusing import refuse_far, refuse_missed
from armsyn.editing.result import EditResult
from armsyn.editing.solving import SolverOptions
from armsyn.editing.tasks import TaskMaker

FloatArray = NDArray[np.float64]


class Editor:
    """One clip, ready to be bent to constraints without leaving its pattern (LPIK).

    Parameters
    ----------
    clip : BodyMotion or Motion
        A whole movement of the pattern's figure, at its own frames and times.
    model : MotionModel
    options : SolverOptions, optional

    Raises
    ------
    PatternError
        A clip of another figure.
    """

    def __init__(
        self, clip: Clip, model: MotionModel, options: SolverOptions | None = None
    ) -> None:
        self._options = options or SolverOptions()
        self._model = model
        figure = model.figure
        captured = figure.poses(clip)
        self._base = unwrapped_poses(captured, figure.turns, model.mean[0])
        self.coefficients = model.coefficients_of(clip.time, captured)
        """The clip's own, whitened, shape (m,)."""
        self._maker = TaskMaker(figure.tree, self._base)
        self._solver = LatentSolver(model, self._base, clip.time, self.coefficients, self._options)
        self._outcome = Outcome(clip, figure, captured, self._base, self._options.tolerance)

    def edit(self, constraints: Sequence[Constraint], *, force: bool = False) -> EditResult:
        """Bend the clip.

        Key-frames and orientations are met by one change of the coefficients for the whole
        motion; then key-trajectories, frame by frame from there. Pins hold in both. What the
        components do not hold of the clip stays, so no constraints, or ones that are met, give
        the clip back bit for bit. A trajectory's displacements and easing are relative to the
        clip as the key-frames have bent it.

        Parameters
        ----------
        constraints : sequence of Constraint
        force : bool
            Give the result however far from the examples it is.

        Returns
        -------
        EditResult

        Raises
        ------
        ConstraintError
            A frame outside the clip, or a body that is not there.
        OutsidePatternError
            When a coefficient beyond `coefficient_bound`, and beyond the clip's own, is needed.
        UnreachableError
            When a constraint of the first level is missed by more than `allowed_miss`, or any is
            and nothing changed: the levels above it use all the components.
        """
        tasks = self._maker.tasks(
            (n, c) for n, c in enumerate(constraints) if not isinstance(c, KeyTrajectory)
        )
        keyed = any(not isinstance(constraints[task.constraint], Pin) for task in tasks)
        bent = self._solver.key_frame(tasks if keyed else [])
        paths = [(n, c) for n, c in enumerate(constraints) if isinstance(c, KeyTrajectory)]
        if paths:
            # They start from, and ease back to, what the key-frames have made of the clip
            tasks += TaskMaker(self._model.figure.tree, self._base + bent.change).tasks(paths)
            frames = {task.frame for task in tasks if task.constraint in dict(paths)}
            here = [task for task in tasks if task.frame in frames]
            bent = self._solver.key_trajectory(here, bent)
        reached = self.coefficients + bent.added
        if not force:
            refuse_far(self._model, reached, self.coefficients, self._options.coefficient_bound)
        farthest = np.abs(reached).max(axis=1).argmax()
        result = self._outcome.result(
            tasks,
            bent.change,
            bent.iterations,
            self.coefficients,
            reached,
            self._model.nearest_example(reached[farthest]),
        )
        if not force:
            refuse_missed(result, tasks, constraints, self._options.allowed_miss)
        return result


def edit_motion(
    clip: Clip,
    model: MotionModel,
    constraints: Sequence[Constraint],
    options: SolverOptions | None = None,
    *,
    force: bool = False,
) -> EditResult:
    """Bend a clip once; see `Editor` and its `edit`."""
    return Editor(clip, model, options).edit(constraints, force=force)


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
    captured = figure.poses(clip)
    base = unwrapped_poses(captured, figure.turns)
    tasks = TaskMaker(figure.tree, base).tasks(enumerate(constraints))
    change, steps = bend_joints(figure, base, tasks, options, radians_per_metre)
    outcome = Outcome(clip, figure, captured, base, options.tolerance)
    return outcome.result(tasks, change, steps)
