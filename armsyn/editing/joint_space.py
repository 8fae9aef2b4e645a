"""Prioritised inverse kinematics in the joint space, frame by frame: what the paper compares with.

Le Callennec and Boulic ("Interactive motion deformation with prioritized constraints", 2006):
each constrained frame is solved for all joints; from frame to frame it goes on from the change of
the frame before, and what freedom is left goes back to the captured posture.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.bounded import Bounds
from armsyn.editing.constraints import Task
from armsyn.editing.figure import Figure
from armsyn.editing.problem import Problem
from armsyn.editing.solving import SolverOptions, solve

FloatArray = NDArray[np.float64]


def bend_joints(
    figure: Figure,
    base: FloatArray,
    tasks: Sequence[Task],
    options: SolverOptions,
    radians_per_metre: float,
) -> tuple[FloatArray, int]:
    """Solve tasks by changing each frame's joints.

    Parameters
    ----------
    figure : Figure
    base : array, shape (frames, n)
        The clip's poses, rad and m.
    tasks : sequence of Task
    options : SolverOptions
        Its whitening and coefficients mean nothing here.
    radians_per_metre : float
        What a metre of the root counts against a radian, as in the pattern.

    Returns
    -------
    change : array, shape (frames, n)
        To add to the clip's poses; zero at frames without tasks.
    iterations : int
        In all.
    """
    scale = 1.0 / np.where(figure.metres, radians_per_metre, 1.0)
    change, steps = np.zeros_like(base), 0
    x, home, before = np.zeros(figure.size), np.zeros(figure.size), -2
    for frame in sorted({task.frame for task in tasks}):
        if frame != before + 1:
            x = home
        bounds = _limits(figure, base[frame], scale)
        if bounds is not None and (bounds.G @ x > bounds.h).any():
            x = home  # the change of the frame before would leave this one's limits
        here = [task for task in tasks if task.frame == frame]
        pose, weight = {frame: base[frame]}, options.metres_per_radian
        problem = Problem(figure.tree, here, pose, {frame: scale}, weight)
        found = solve(problem, x, options, home, bounds, settle=False)
        x, before, steps = found.x, frame, steps + found.iterations
        change[frame] = x * scale
    return change, steps


def _limits(figure: Figure, pose: FloatArray, scale: FloatArray) -> Bounds | None:
    limited = np.flatnonzero(np.isfinite(figure.lower) | np.isfinite(figure.upper))
    if not limited.size:
        return None
    G = np.diag(scale)[limited]
    above = np.maximum(figure.upper - pose, 0.0)[limited]
    below = np.maximum(pose - figure.lower, 0.0)[limited]
    return Bounds(np.concatenate([G, -G]), np.concatenate([above, below]))
