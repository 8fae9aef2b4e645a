"""Prioritised inverse kinematics in the latent space (LIK, LPIK; second paper, 4.2, 4.3 and 5).

The unknowns x are what is added to the clip's own coefficients, so that the clip keeps what the
components do not hold: theta_k = clip_k + x D_k with D_k = E_k (times sigma, when whitened).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.bounded import Bounds
from armsyn.editing.constraints import Task
from armsyn.editing.pattern.model import MotionModel
from armsyn.editing.pattern.timing import phases
from armsyn.editing.problem import Problem
from armsyn.editing.solving import SolverOptions, solve
from armsyn.errors import InputError

FloatArray = NDArray[np.float64]


class Bent(NamedTuple):
    """A clip bent in the latent space.

    Attributes
    ----------
    change : array, shape (frames, n)
        To add to the clip's poses, rad and m; exactly zero where nothing moved.
    added : array, shape (frames, m)
        Whitened coefficients added at each frame.
    iterations : int
        In all.
    """

    change: FloatArray
    added: FloatArray
    iterations: int


class LatentSolver:
    """Solves tasks on one clip by changing its coefficients.

    Parameters
    ----------
    model : MotionModel
    base : array, shape (frames, n)
        The clip's poses on the model's branches, rad and m.
    time : array, shape (frames,)
        The clip's, s.
    coefficients : array, shape (m,)
        The clip's own, whitened.
    options : SolverOptions
    """

    def __init__(
        self,
        model: MotionModel,
        base: FloatArray,
        time: FloatArray,
        coefficients: FloatArray,
        options: SolverOptions,
    ) -> None:
        self._model, self._base, self._options = model, base, options
        self._scale = np.ones(model.size) if options.whiten else model.sigma
        self._phases = phases(time, model.frames)
        self._rest = self._resting(coefficients)

    def key_frame(self, tasks: Sequence[Task]) -> Bent:
        """Solve tasks at any frames by one change for the whole motion."""
        zero = np.zeros(self._model.size)
        if not tasks:
            return self._replayed(zero, 0)
        bounds = self._limits(range(len(self._base)))
        found = solve(self._problem(tasks), zero, self._options, self._rest, bounds)
        return self._replayed(found.x, found.iterations)

    def key_trajectory(self, tasks: Sequence[Task], start: Bent) -> Bent:
        """Solve tasks frame by frame, each from the one change that `start` makes.

        Frames without tasks keep that change, so the tasks must be eased in and out, and what
        freedom they leave stays with it.
        """
        change, added, steps = start.change.copy(), start.added.copy(), start.iterations
        for frame in sorted({task.frame for task in tasks}):
            here = self._problem([task for task in tasks if task.frame == frame])
            first = start.added[frame] * self._scale
            found = solve(here, first, self._options, bounds=self._limits([frame]))
            change[frame] = here.pose(frame, found.x) - self._base[frame]
            added[frame] = found.x / self._scale
            steps += found.iterations
        return Bent(change, added, steps)

    def _problem(self, tasks: Sequence[Task]) -> Problem:
        frames = sorted({task.frame for task in tasks})
        base = {frame: self._base[frame] for frame in frames}
        along = dict(zip(frames, self._directions[frames], strict=True))
        weight = self._options.metres_per_radian
        return Problem(self._model.figure.tree, tasks, base, along, weight)

    @cached_property
    def _directions(self) -> FloatArray:
        """Pose changes a unit of the unknowns at the clip's frames, (frames, m, n)."""
        return self._model.directions_at(self._phases) / self._scale[:, None]

    def _replayed(self, x: FloatArray, iterations: int) -> Bent:
        """The whole motion of one change."""
        added = x / self._scale
        change = np.matmul(x, self._directions)
        return Bent(change, np.tile(added, (len(change), 1)), iterations)

    def _resting(self, own: FloatArray) -> FloatArray | None:
        """Where the free coefficients go, as unknowns."""
        options, wanted = self._options, None
        if options.toward_coefficients:
            wanted = np.array(options.toward_coefficients)
            if wanted.shape != own.shape:
                raise InputError(f"{wanted.size} coefficients to go to; the pattern has {own.size}")
        elif options.toward:
            wanted = own if options.toward == "clip" else np.zeros_like(own)
        return None if wanted is None else (wanted - own) * self._scale

    def _limits(self, frames: Sequence[int]) -> Bounds | None:
        """The joints' limits at frames; where the clip itself is beyond, it may not go on."""
        figure, base = self._model.figure, self._base[list(frames)]
        limited = np.flatnonzero(np.isfinite(figure.lower) | np.isfinite(figure.upper))
        if not limited.size:
            return None
        along = self._directions[list(frames)][:, :, limited]
        G = along.transpose(0, 2, 1).reshape(-1, self._model.size)
        above = np.maximum(figure.upper[limited] - base[:, limited], 0.0).ravel()
        below = np.maximum(base[:, limited] - figure.lower[limited], 0.0).ravel()
        return Bounds(np.concatenate([G, -G]), np.concatenate([above, below]))
