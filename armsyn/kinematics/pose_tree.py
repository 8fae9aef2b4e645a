"""Bodies whose pose is one vector: a skeleton's or a chain's, with points' Jacobians.

A skeleton's vector is the root's position, then three numbers a joint (its exponential map, the
root's orientation first), then three a joint that carries translations. A chain's vector is its
joints' values. Both are one compiled tree.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.kernels import editing_tree as kernels
from armsyn.kinematics.chain import SerialChain
from armsyn.kinematics.rotation import from_rpy
from armsyn.kinematics.skeleton import Skeleton

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


class Points(NamedTuple):
    """Points of bodies at one pose.

    Attributes
    ----------
    positions : array, shape (points, 3)
        Global, m.
    orientations : array, shape (points, 3, 3)
        Of their bodies, global.
    jacobians : array, shape (points, 6, n)
        Linear (m a unit of the column), then angular velocity (rad a unit), both global.
    """

    positions: FloatArray
    orientations: FloatArray
    jacobians: FloatArray


class PoseTree:
    """A tree of bodies and the columns of the pose vector that move it.

    Parameters
    ----------
    bodies : tuple of str
        Parents before their children.
    columns : tuple of str
        One a number of the pose vector.
    arrays : Tree
        As the kernels take it.
    """

    def __init__(
        self, bodies: tuple[str, ...], columns: tuple[str, ...], arrays: kernels.Tree
    ) -> None:
        self.bodies = bodies
        self.columns = columns
        self.arrays = arrays

    @property
    def size(self) -> int:
        """Length n of the pose vector."""
        return len(self.columns)

    def body(self, name: str) -> int:
        """Return the index of a body.

        Raises
        ------
        InputError
            When there is none of that name.
        """
        try:
            return self.bodies.index(name)
        except ValueError:
            raise InputError(f"no body '{name}' here; there are {', '.join(self.bodies)}") from None

    def positions(self, poses: ArrayLike) -> FloatArray:
        """Positions of all bodies: (frames, n) to (frames, bodies, 3), m."""
        path = np.ascontiguousarray(poses, dtype=np.float64)
        found = np.empty((len(path), len(self.bodies), 3))
        kernels.place_all(self.arrays, path, found)
        return found

    def points(self, pose: ArrayLike, bodies: IntArray, points: FloatArray) -> Points:
        """Places, orientations and Jacobians of points fixed to bodies, at one pose.

        Parameters
        ----------
        pose : array_like, shape (n,)
            rad and m.
        bodies : array of int, shape (points,)
            Indices.
        points : array, shape (points, 3)
            In their bodies' frames, m.

        Returns
        -------
        Points
        """
        count = len(bodies)
        found = Points(
            np.empty((count, 3)), np.empty((count, 3, 3)), np.empty((count, 6, self.size))
        )
        vector = np.ascontiguousarray(pose, dtype=np.float64)
        kernels.point_jacobians(self.arrays, vector, bodies, points, *found)
        return found


def skeleton_tree(skeleton: Skeleton, moving: ArrayLike = ()) -> PoseTree:
    """Return a skeleton as a tree with one pose vector.

    Parameters
    ----------
    skeleton : Skeleton
    moving : array_like of int
        Joints that carry translations; the root moves anyway.

    Returns
    -------
    PoseTree
    """
    count = skeleton.joints
    soft = np.asarray(moving, dtype=np.int64).ravel()
    moves, move_column = np.zeros(count, np.int64), np.zeros(count, np.int64)
    moves[0] = 3
    moves[soft] = 3
    move_column[soft] = 3 + 3 * count + 3 * np.arange(soft.size)
    offsets = np.array(skeleton.offsets)
    offsets[0] = 0.0  # the root's whole position is in the vector
    arrays = kernels.Tree(
        parent=np.array(skeleton.parents, dtype=np.int64),
        offset=offsets,
        before=np.array(skeleton.prerotations),
        turns=np.full(count, 3, np.int64),
        turn_column=3 + 3 * np.arange(count, dtype=np.int64),
        turn_axis=np.zeros((count, 3)),
        moves=moves,
        move_column=move_column,
        move_axis=np.zeros((count, 3)),
    )
    named = [skeleton.names[0]]
    columns = [f"{name}.{axis}" for name in named for axis in "xyz"]
    columns += [f"{name}.r{axis}" for name in skeleton.names for axis in "xyz"]
    columns += [f"{skeleton.names[joint]}.{axis}" for joint in soft for axis in "xyz"]
    return PoseTree(skeleton.names, tuple(columns), arrays)


def chain_tree(chain: SerialChain) -> PoseTree:
    """Return a serial chain as a tree; its bodies are its joints and, last, ``tip``.

    Parameters
    ----------
    chain : SerialChain

    Returns
    -------
    PoseTree
    """
    count = chain.dof + 1
    slides = np.array([joint.kind == "prismatic" for joint in chain.joints])
    axes = np.array([joint.axis for joint in chain.joints])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    before = np.array([from_rpy(rpy) for rpy in (*(j.rpy for j in chain.joints), chain.tip_rpy)])
    turn_axis, move_axis = np.zeros((count, 3)), np.zeros((count, 3))
    turn_axis[:-1] = axes
    move_axis[:-1] = np.einsum("kij,kj->ki", before[:-1], axes)
    columns = np.append(np.arange(chain.dof), 0)
    arrays = kernels.Tree(
        parent=np.arange(-1, chain.dof, dtype=np.int64),
        offset=np.array([j.xyz for j in chain.joints] + [chain.tip_xyz], dtype=np.float64),
        before=before,
        turns=np.append(~slides, False).astype(np.int64),
        turn_column=columns,
        turn_axis=turn_axis,
        moves=np.append(slides, False).astype(np.int64),
        move_column=columns,
        move_axis=move_axis,
    )
    return PoseTree((*chain.names, "tip"), chain.names, arrays)
