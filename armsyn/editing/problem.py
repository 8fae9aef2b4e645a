"""The goals at some frames, as functions of a few unknowns; building it is not solving it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.constraints import Task
from armsyn.editing.priorities import Level
from armsyn.kinematics import quaternion
from armsyn.kinematics.pose_tree import PoseTree

FloatArray = NDArray[np.float64]


class _FrameTasks(NamedTuple):
    frame: int
    tasks: list[Task]
    bodies: NDArray[np.int64]
    points: FloatArray


class Problem:
    """Tasks on poses that depend linearly on unknowns: theta_k = base_k + x D_k.

    Parameters
    ----------
    tree : PoseTree
    tasks : sequence of Task
        At least one.
    base : mapping of int to array, shape (n,)
        Pose of each frame that has tasks where the unknowns are zero, rad and m.
    directions : mapping of int to array, shape (q, n) or (n,)
        Pose change a unit of each unknown; a row of n is the diagonal of an n x n matrix.
    metres_per_radian : float
        What a radian of an orientation counts against a metre on its level.
    """

    def __init__(
        self,
        tree: PoseTree,
        tasks: Sequence[Task],
        base: Mapping[int, FloatArray],
        directions: Mapping[int, FloatArray],
        metres_per_radian: float = 1.0,
    ) -> None:
        self._tree, self._base, self._directions = tree, base, directions
        self.metres_per_radian = metres_per_radian
        self.tasks = sorted(tasks, key=lambda task: (task.frame, task.level))
        self.ranks = sorted({task.level for task in self.tasks})
        self._frames = [self._grouped(frame) for frame in sorted({t.frame for t in self.tasks})]
        first = directions[self.tasks[0].frame]
        self.size = int(first.shape[0])

    def _grouped(self, frame: int) -> _FrameTasks:
        tasks = [task for task in self.tasks if task.frame == frame]
        bodies = np.array([task.body for task in tasks], dtype=np.int64)
        return _FrameTasks(frame, tasks, bodies, np.array([task.point for task in tasks]))

    def pose(self, frame: int, x: FloatArray) -> FloatArray:
        """Return the pose of a frame at unknowns x, shape (q,) to (n,)."""
        D = self._directions[frame]
        return self._base[frame] + (x * D if D.ndim == 1 else x @ D)

    def levels(self, x: FloatArray) -> list[Level]:
        """Return Jacobians and errors of each level, the first priority first.

        Parameters
        ----------
        x : array, shape (q,)

        Returns
        -------
        list of Level
            J is J_theta(theta_k) E_k^T (the chain rule of the second paper's Eq. 7). Rows of
            orientations are weighted.
        """
        rows: dict[int, list[tuple[FloatArray, FloatArray]]] = {rank: [] for rank in self.ranks}
        for frame, tasks, bodies, points in self._frames:
            places, turned, J = self._tree.points(self.pose(frame, x), bodies, points)
            D = self._directions[frame]
            J = J * D if D.ndim == 1 else J @ D.T
            for task, place, turn, moved in zip(tasks, places, turned, J, strict=True):
                rows[task.level].append(self._row(task, error_of(task, place, turn), moved))
        return [
            Level(np.concatenate([J for J, _ in part]), np.concatenate([e for _, e in part]))
            for part in rows.values()
        ]

    def _row(
        self, task: Task, error: FloatArray, moved: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        if not task.turning:
            return moved[task.rows], error
        return self.metres_per_radian * moved[3:], self.metres_per_radian * error

    def errors(self, x: FloatArray) -> list[FloatArray]:
        """Return what each task, in the order of `tasks`, misses at x: m or rad, unweighted."""
        found = []
        for frame, tasks, bodies, points in self._frames:
            places, turned, _ = self._tree.points(self.pose(frame, x), bodies, points)
            found += [error_of(*row) for row in zip(tasks, places, turned, strict=True)]
        return found


def error_of(task: Task, place: FloatArray, turned: FloatArray) -> FloatArray:
    """Return what is missing from a place, m, or an orientation, global rad, to the goal."""
    if not task.turning:
        return np.asarray((task.goal - place)[task.rows])
    return quaternion.to_expmap(quaternion.from_matrix(task.goal @ turned.T))
