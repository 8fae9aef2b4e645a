"""What has a pose vector: one seam for a skeleton's motion and for an arm's.

Everything else of this room sees a `Figure`: a tree of bodies, the columns that move it and their
limits, and the way from a clip to its pose vectors and back.
"""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.sharing import moving_joints, on_same_rests, translations_on
from armsyn.errors import ConstraintError, PatternError
from armsyn.kinematics.chain import SerialChain
from armsyn.kinematics.pose_tree import PoseTree, chain_tree, skeleton_tree
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.body import BodyMotion
from armsyn.motion.motion import Motion

FloatArray = NDArray[np.float64]
Clip = BodyMotion | Motion


@dataclass(frozen=True)
class Effector:
    """A point fixed to a body.

    Parameters
    ----------
    body : str
        A joint of the skeleton; of an arm, a joint or ``tip``.
    point : 3-tuple of float
        In the body's frame, m; its origin by default.
    """

    body: str
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if len(self.point) != 3 or not np.isfinite(self.point).all():
            raise ConstraintError(f"{self.body}: a point is three finite metres, not {self.point}")

    def __str__(self) -> str:
        at = "" if not any(self.point) else f"({', '.join(f'{x:g}' for x in self.point)})"
        return f"{self.body}{at}"


class Figure(ABC):
    """What has a pose vector.

    Attributes
    ----------
    tree : PoseTree
        Its bodies, the names of its columns, positions and Jacobians.
    metres : array of bool, shape (n,)
        Columns that are lengths; the others are angles.
    turns : array of int, shape (turning joints,)
        First columns of exponential maps.
    lower, upper : array, shape (n,)
        Limits; infinite where there are none.
    """

    tree: PoseTree
    metres: NDArray[np.bool_]
    turns: NDArray[np.int64]
    lower: FloatArray
    upper: FloatArray

    @property
    def size(self) -> int:
        """Length n of the pose vector."""
        return self.tree.size

    def inside(self, poses: FloatArray, captured: FloatArray) -> FloatArray:
        """Return poses without what rounding puts beyond a limit.

        Parameters
        ----------
        poses, captured : array, shape (frames, n)
            Where a captured value is beyond a limit, it is the limit.

        Returns
        -------
        array, shape (frames, n)
        """
        lower, upper = np.minimum(self.lower, captured), np.maximum(self.upper, captured)
        return np.clip(poses, lower, upper)

    @abstractmethod
    def poses(self, clip: Clip) -> FloatArray:
        """Return a clip's pose vectors, shape (frames, n), as captured.

        Raises
        ------
        SkeletonMismatchError, PatternError
            When the clip is of another figure; the message names the clip.
        """

    @abstractmethod
    def with_poses(self, clip: Clip, poses: FloatArray) -> Clip:
        """Return a clip with other poses, shape (frames, n)."""


class SkeletonFigure(Figure):
    """A skeleton below a free root.

    Parameters
    ----------
    skeleton : Skeleton
    moving : tuple of int
        Joints that carry translations beside the root.
    """

    def __init__(self, skeleton: Skeleton, moving: tuple[int, ...] = ()) -> None:
        self.skeleton = skeleton
        self.moving = tuple(int(joint) for joint in moving)
        self.tree = skeleton_tree(skeleton, self.moving)
        self.turns = 3 + 3 * np.arange(skeleton.joints)
        self.metres = np.ones(self.size, dtype=np.bool_)
        self.metres[3 : 3 + 3 * skeleton.joints] = False
        self.lower, self.upper = np.full(self.size, -np.inf), np.full(self.size, np.inf)

    def poses(self, clip: Clip) -> FloatArray:
        """Return the root, exponential maps and translations of a body's motion."""
        if not isinstance(clip, BodyMotion):
            raise PatternError(f"{clip.source or 'motion'}: has no skeleton, but the pattern does")
        clip = on_same_rests(clip, self.skeleton)
        moved = translations_on(clip, self.skeleton, self.moving)
        parts = (clip.root, clip.rotations, moved)
        return np.concatenate([part.reshape(clip.frames, -1) for part in parts], axis=1)

    def with_poses(self, clip: Clip, poses: FloatArray) -> Clip:
        """Return the body's motion with other poses, on the figure's skeleton."""
        if not isinstance(clip, BodyMotion):
            raise PatternError(f"{clip.source or 'motion'}: has no skeleton, but the pattern does")
        count, translations = self.skeleton.joints, None
        if self.moving:
            translations = np.zeros((clip.frames, count, 3))
            translations[:, self.moving] = poses[:, 3 + 3 * count :].reshape(clip.frames, -1, 3)
        return dataclasses.replace(
            clip,
            skeleton=self.skeleton,
            root=poses[:, :3],
            rotations=poses[:, 3 : 3 + 3 * count].reshape(clip.frames, count, 3),
            translations=translations,
        )


class ChainFigure(Figure):
    """An arm's serial chain; its base stands still.

    Parameters
    ----------
    chain : SerialChain
    name : str
        Of the arm, for messages and files.
    """

    def __init__(self, chain: SerialChain, name: str = "arm") -> None:
        self.chain = chain
        self.name = name
        self.tree = chain_tree(chain)
        self.turns = np.empty(0, dtype=np.int64)
        self.metres = np.array([joint.kind == "prismatic" for joint in chain.joints])
        self.lower, self.upper = chain.lower, chain.upper

    def poses(self, clip: Clip) -> FloatArray:
        """Return the chain's joints of a motion with angles, by their names."""
        motion, columns = self._columns(clip)
        angles = np.array(motion.angles)[:, columns]
        if not np.isfinite(angles).all():
            raise PatternError(f"{clip.source or 'motion'}: its joint angles are not all finite")
        return angles

    def with_poses(self, clip: Clip, poses: FloatArray) -> Clip:
        """Return the motion with other angles; landmarks of the chain's bodies follow."""
        motion, columns = self._columns(clip)
        angles = np.array(motion.angles)
        angles[:, columns] = poses
        known = [name for name in motion.landmark_names if name in self.tree.bodies]
        places = self.tree.positions(poses)[:, [self.tree.body(name) for name in known]]
        return dataclasses.replace(
            motion,
            angles=angles,
            landmark_names=tuple(known),
            landmarks=places if known else None,
            filled=None,
        )

    def _columns(self, clip: Clip) -> tuple[Motion, list[int]]:
        source = clip.source or "motion"
        if not isinstance(clip, Motion) or clip.angles is None:
            raise PatternError(f"{source}: has no joint angles of {self.name}")
        missing = [name for name in self.chain.names if name not in clip.joint_names]
        if missing:
            raise PatternError(f"{source}: has no joint '{missing[0]}' of {self.name}")
        return clip, [clip.joint_names.index(name) for name in self.chain.names]


def figure_of(clips: list[BodyMotion]) -> SkeletonFigure:
    """Return the figure that all these body motions are of: the first one's skeleton.

    Parameters
    ----------
    clips : list of BodyMotion

    Returns
    -------
    SkeletonFigure
        With translations for every joint that moves beyond its offset in one of them.

    Raises
    ------
    SkeletonMismatchError
        When a clip has another skeleton; by its name.
    """
    if not clips:
        raise PatternError("no motions were given")
    skeleton = clips[0].skeleton
    return SkeletonFigure(skeleton, moving_joints(clips, skeleton))
