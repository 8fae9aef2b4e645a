"""From constraints on a clip to goals at its frames."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.constraints import (
    Constraint,
    KeyFrame,
    KeyTrajectory,
    Orientation,
    Pin,
    Task,
)
from armsyn.editing.figure import Effector
from armsyn.editing.splines import KochanekBartels, ease
from armsyn.errors import ConstraintError
from armsyn.kinematics.pose_tree import PoseTree
from armsyn.kinematics.rotation import from_expmap

FloatArray = NDArray[np.float64]

_LISTED = 8
"""Of a tree's bodies, at most so many are named where none is near."""


class TaskMaker:
    """Turns constraints into tasks on one clip.

    Parameters
    ----------
    tree : PoseTree
    poses : array, shape (frames, n)
        The clip's: pins and displacements start from them.
    """

    def __init__(self, tree: PoseTree, poses: FloatArray) -> None:
        self._tree = tree
        self._poses = poses

    def tasks(self, constraints: Iterable[tuple[int, Constraint]]) -> list[Task]:
        """Return the tasks of constraints, each with its number.

        Raises
        ------
        ConstraintError
            A frame outside the clip, or a body that is not there.
        """
        found: list[Task] = []
        for number, constraint in constraints:
            if isinstance(constraint, KeyFrame):
                found += self._key_frame(number, constraint)
            elif isinstance(constraint, Orientation):
                found += self._orientation(number, constraint)
            elif isinstance(constraint, Pin):
                found += self._pin(number, constraint)
            else:
                found += self._trajectory(number, constraint)
        return found

    def _frame(self, effector: Effector, frame: int) -> int:
        count = len(self._poses)
        if int(frame) != frame or not -count <= frame < count:
            raise ConstraintError(f"{effector}: frame {frame} is outside the clip's 0..{count - 1}")
        return int(frame) % count

    def _at(self, effector: Effector, frame: int) -> tuple[int, FloatArray, FloatArray, FloatArray]:
        """Return the body, the point in it, and where the clip has both."""
        body = self._body(effector.body)
        point = np.array(effector.point, dtype=np.float64)
        there = self._tree.points(self._poses[frame], np.array([body]), point[None])
        return body, point, there.positions[0], there.orientations[0]

    def _body(self, name: str) -> int:
        bodies = self._tree.bodies
        if name in bodies:
            return bodies.index(name)
        by_lower = {body.lower(): body for body in bodies}
        near = get_close_matches(name.lower(), by_lower, n=3, cutoff=0.5)
        near += [body for body in by_lower if name.lower() in body and body not in near]
        listed = [by_lower[body] for body in near] or list(bodies)
        more = f" ... ({len(bodies)} in all)" if len(bodies) > len(listed[:_LISTED]) else ""
        raise ConstraintError(
            f"no body '{name}' here; {'did you mean' if near else 'there are'}"
            f" {', '.join(listed[:_LISTED])}{more}"
        )

    def _key_frame(self, number: int, constraint: KeyFrame) -> list[Task]:
        frame = self._frame(constraint.effector, constraint.frame)
        body, point, here, _ = self._at(constraint.effector, frame)
        goal = np.array(constraint.position) if constraint.by is None else here + constraint.by
        label, rows = f"key-frame {constraint.effector} @ {frame}", rows_of(constraint.axes)
        return [Task(number, label, constraint.level, frame, body, point, goal, rows)]

    def _orientation(self, number: int, constraint: Orientation) -> list[Task]:
        frame = self._frame(constraint.effector, constraint.frame)
        body, point, _, turned = self._at(constraint.effector, frame)
        goal = constraint.rotation
        if goal is None:
            goal = from_expmap(constraint.by or (0.0, 0.0, 0.0)) @ turned
        label = f"orientation {constraint.effector} @ {frame}"
        return [Task(number, label, constraint.level, frame, body, point, goal)]

    def _pin(self, number: int, constraint: Pin) -> list[Task]:
        frames = range(len(self._poses)) if constraint.frames is None else constraint.frames
        label, level, found = f"pin {constraint.effector}", constraint.level, []
        for wanted in frames:
            frame = self._frame(constraint.effector, wanted)
            body, point, here, turned = self._at(constraint.effector, frame)
            rows = rows_of(constraint.axes)
            found.append(Task(number, label, level, frame, body, point, here, rows))
            if constraint.turned:
                found.append(Task(number, f"{label} turned", level, frame, body, point, turned))
        return found

    def _trajectory(self, number: int, constraint: KeyTrajectory) -> list[Task]:
        frames, goals = self._path(constraint)
        label, rows = f"trajectory {constraint.effector}", rows_of(constraint.axes)
        found = []
        for frame, goal in zip(frames, goals, strict=True):
            body, point, _, _ = self._at(constraint.effector, frame)
            found.append(Task(number, label, constraint.level, frame, body, point, goal, rows))
        return found

    def _path(self, constraint: KeyTrajectory) -> tuple[list[int], FloatArray]:
        """Return the frames in and around the keys, and the eased goals there, m."""
        who = constraint.effector
        keys = np.array([self._frame(who, key.frame) for key in constraint.keys])
        values = np.array([key.value for key in constraint.keys], dtype=np.float64)
        first = max(0, int(keys[0]) - constraint.ease_in)
        last = min(len(self._poses) - 1, int(keys[-1]) + constraint.ease_out)
        frames = list(range(first, last + 1))
        here = np.array([self._at(who, frame)[2] for frame in frames])
        shape = (constraint.tension, constraint.continuity, constraint.bias)
        path = KochanekBartels(keys, values, *shape).at(frames)
        if not constraint.relative:
            # Outside the keys it is the first and last key's displacement that is eased
            inside = np.clip(frames, keys[0], keys[-1]) - first
            path = path - here[inside]
        return frames, here + path * _share(constraint, np.array(frames), keys)[:, None]


def _share(
    constraint: KeyTrajectory, frames: NDArray[np.int64], keys: NDArray[np.int64]
) -> FloatArray:
    rising = 1.0 - (keys[0] - frames) / (constraint.ease_in + 1.0)
    falling = 1.0 - (frames - keys[-1]) / (constraint.ease_out + 1.0)
    return ease(np.minimum(rising, falling))


def rows_of(axes: str) -> NDArray[np.int64]:
    """Return the rows of a position that axes such as ``xz`` name."""
    return np.array(["xyz".index(axis) for axis in sorted(axes)], dtype=np.int64)
