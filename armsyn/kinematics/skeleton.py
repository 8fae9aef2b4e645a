"""A body's skeleton: a tree of joints below a free root, each an exponential map.

The local rotation of joint j is ``prerotations[j] exp([w_j]x)``; the global recursion is

    G_j = G_parent prerotations[j] exp([w_j]x),    p_j = p_parent + G_parent (offsets[j] + t_j)

with p_root given. A joint may also be moved by t_j, its translation channels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.kinematics.rotation import from_expmap

FloatArray = NDArray[np.float64]
_FRAMES_AT_ONCE = 4096


class SkeletonFrames(NamedTuple):
    """Where the joints are and how they are turned.

    Attributes
    ----------
    positions : array, shape (frames, joints, 3)
        Global, m.
    orientations : array, shape (frames, joints, 3, 3)
        Global rotation matrices.
    """

    positions: FloatArray
    orientations: FloatArray


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A tree of joints.

    Parameters
    ----------
    names : tuple of str
        Unique; the root first.
    parents : tuple of int
        Index of each joint's parent, which comes before it; -1 for the root alone.
    offsets : array, shape (joints, 3)
        From the parent, in the parent's frame, m. The root's is where it rests.
    prerotations : array, shape (joints, 3, 3), optional
        What each joint is turned by when its channel is zero; the identity by default.

    Raises
    ------
    InputError
        When the parts do not fit each other, or the parents form no tree.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: FloatArray
    prerotations: FloatArray | None = None

    def __post_init__(self) -> None:
        count = len(self.names)
        if count == 0 or len(set(self.names)) != count:
            raise InputError(f"a skeleton's joints need unique names, not {self.names[:60]}")
        if len(self.parents) != count or self.parents[0] != -1:
            raise InputError("a skeleton has one parent a joint; -1 for its first, the root")
        for joint, parent in enumerate(self.parents[1:], start=1):
            if not 0 <= parent < joint:
                raise InputError(
                    f"joint '{self.names[joint]}' has parent {parent}: it must be a joint before it"
                )
        turns = self.prerotations
        if turns is None:
            turns = np.broadcast_to(np.eye(3), (count, 3, 3))
        for part, values, shape in (
            ("offsets", self.offsets, (count, 3)),
            ("prerotations", turns, (count, 3, 3)),
        ):
            array = np.array(values, dtype=np.float64)
            if array.shape != shape or not np.isfinite(array).all():
                raise InputError(f"a skeleton's {part} are finite, of shape {shape}")
            array.flags.writeable = False
            object.__setattr__(self, part, array)

    @property
    def joints(self) -> int:
        """Number of joints, end points included."""
        return len(self.names)

    def index(self, name: str) -> int:
        """Return the index of a joint.

        Raises
        ------
        InputError
            When there is no such joint.
        """
        try:
            return self.names.index(name)
        except ValueError:
            raise InputError(
                f"the skeleton has no joint '{name}'; it has {', '.join(self.names)}"
            ) from None

    def path_to(self, joint: int) -> list[int]:
        """Return the joints from the root to this one, both included."""
        path = [joint]
        while self.parents[path[-1]] >= 0:
            path.append(self.parents[path[-1]])
        return path[::-1]

    def frames(
        self, root: ArrayLike, rotations: ArrayLike, translations: ArrayLike | None = None
    ) -> SkeletonFrames:
        """Global positions and orientations of every joint.

        Parameters
        ----------
        root : array_like, shape (frames, 3)
            Position of the root, m.
        rotations : array_like, shape (frames, joints, 3)
            Exponential maps, rad; the root's is its orientation.
        translations : array_like, shape (frames, joints, 3), optional
            Added to the offsets, m; the root's are ignored.

        Returns
        -------
        SkeletonFrames

        Raises
        ------
        InputError
            When the shapes do not fit the skeleton.
        """
        start, turns, moves = self._checked(root, rotations, translations)
        # Joints first: each one's frames lie together in memory
        by_joint = np.ascontiguousarray(turns.swapaxes(0, 1))
        orientations = np.asarray(self.prerotations)[:, None] @ from_expmap(by_joint)
        positions = np.empty_like(by_joint)
        positions[0] = start
        for joint, parent in enumerate(self.parents[1:], start=1):
            above = orientations[parent]
            offset = self.offsets[joint] + (0.0 if moves is None else moves[:, joint])
            positions[joint] = positions[parent] + (above @ offset[..., None])[..., 0]
            orientations[joint] = above @ orientations[joint]
        return SkeletonFrames(positions.swapaxes(0, 1), orientations.swapaxes(0, 1))

    def positions(
        self, root: ArrayLike, rotations: ArrayLike, translations: ArrayLike | None = None
    ) -> FloatArray:
        """Global positions of every joint, shape (frames, joints, 3), m; as `frames`.

        Orientations are held for a few thousand frames at a time only.
        """
        start, turns, moves = self._checked(root, rotations, translations)
        found = np.empty_like(turns)
        for first in range(0, len(turns), _FRAMES_AT_ONCE):
            part = slice(first, first + _FRAMES_AT_ONCE)
            moved = None if moves is None else moves[part]
            found[part] = self.frames(start[part], turns[part], moved).positions
        return found

    def _checked(
        self, root: ArrayLike, rotations: ArrayLike, translations: ArrayLike | None
    ) -> tuple[FloatArray, FloatArray, FloatArray | None]:
        start, turns = np.asarray(root, dtype=np.float64), np.asarray(rotations, dtype=np.float64)
        moves = None if translations is None else np.asarray(translations, dtype=np.float64)
        shape = (len(start), self.joints, 3)
        if start.ndim != 2 or start.shape[1] != 3 or turns.shape != shape:
            raise InputError(f"root {start.shape} and rotations {turns.shape} do not fit {shape}")
        if moves is not None and moves.shape != shape:
            raise InputError(f"translations {moves.shape} do not fit {shape}")
        return start, turns, moves
