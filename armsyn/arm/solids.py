"""An arm's shapes made ready for judging postures: which pairs, and how far joints move them."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm.shapes import BASE, CapsuleDescription, capsules_of
from armsyn.errors import InputError
from armsyn.kernels import distance
from armsyn.kinematics.rotation import from_rpy, turning_z_to

if TYPE_CHECKING:
    from armsyn.arm.description import ArmDescription

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


ON_AXIS = 1e-9
"""m from a joint's axis that are none."""


class _Capsule(NamedTuple):
    """One capsule in the canonical frame of its link; `link` is -1 for the base."""

    link: int
    start: FloatArray
    end: FloatArray
    radius: float
    stand_in: bool


class Solids:
    """What an arm and its surroundings fill.

    Parameters
    ----------
    arm : ArmDescription

    Attributes
    ----------
    names : tuple of (str, str), length k
        The pairs that are judged: a link by its joint's name, ``base``, or a plane or box.
    reach : array, shape (k, n)
        How far each joint moves the two of a pair against each other at most, m/rad or m/m.
    at_rest : array, shape (k,)
        Clearances at the rest posture, not negative, m.
    unjudged : tuple of (str, str)
        Pairs of links that are not, as one has a stand-in for a shape and they touch at rest.

    Raises
    ------
    InputError
        Two that touch at rest and are neither neighbours nor to be ignored.
    """

    def __init__(self, arm: ArmDescription) -> None:
        self._chain = arm.chain.arrays
        self._links = (BASE, *arm.joint_names)
        self._capsules = _capsules(arm)
        things = [[thing.name for thing in arm.plane], [thing.name for thing in arm.box]]
        self._things = (*([] for _ in range(distance.PLANE)), *things)
        pairs = self._pairs(arm)
        self._take(pairs, _arrays(arm, self._capsules, pairs))
        self.unjudged: tuple[tuple[str, str], ...] = ()
        self._drop_touching(arm)

    def clearances(self, path: FloatArray) -> FloatArray:
        """Clearances of all pairs along a path.

        Parameters
        ----------
        path : array, shape (frames, n)
            Contiguous, rad or m; not checked.

        Returns
        -------
        array, shape (frames, k)
            m; below zero the depth of one in the other. NaN where the path is NaN.
        """
        found = np.empty((path.shape[0], len(self.names)))
        distance.clearances(self._chain, self._shapes, path, found)
        return found

    @property
    def arrays(self) -> distance.ShapeArrays:
        """The shapes and pairs as kernels see them."""
        return self._shapes

    @property
    def pairs(self) -> IntArray:
        """What each of `names` is of, shape (k, 3): its kind and two rows.

        The first row is a capsule's, the other, by the kind, a capsule's, plane's or box's.
        Capsules are the base's and then the links', in their order.
        """
        return self._shapes.pairs

    def _take(self, pairs: IntArray, shapes: distance.ShapeArrays) -> None:
        self._shapes = shapes
        self.names = tuple(self._named(*row) for row in pairs.tolist())
        self.reach = np.array([self._reach_of(*row) for row in pairs.tolist()])
        self.reach = self.reach.reshape(len(pairs), self._chain.lower.size)

    def _named(self, kind: int, one: int, other: int) -> tuple[str, str]:
        first = self._links[self._capsules[one].link + 1]
        if kind == distance.CAPSULE:
            return first, self._links[self._capsules[other].link + 1]
        return first, self._things[kind][other]

    def _pairs(self, arm: ArmDescription) -> IntArray:
        """Capsules of links that are no neighbours, and all links with planes and boxes.

        Without those that no joint moves against each other, and links that one joint alone does:
        its limits are their judge, as they are between neighbours.
        """
        ignored = {frozenset(pair) for pair in arm.collision_ignore}
        rows = range(len(self._capsules))
        links = [capsule.link for capsule in self._capsules]
        places = {link: place for place, link in enumerate(sorted({-1, *links}))}
        pairs = [
            (distance.CAPSULE, one, other)
            for one, other in combinations(rows, 2)
            if abs(places[links[one]] - places[links[other]]) > 1
        ]
        for kind in (distance.PLANE, distance.BOX):
            count = len(self._things[kind])
            pairs += [(kind, row, k) for row in rows if links[row] >= 0 for k in range(count)]
        kept = [
            (kind, one, other)
            for kind, one, other in pairs
            if frozenset(self._named(kind, one, other)) not in ignored
            and np.count_nonzero(self._reach_of(kind, one, other)) > (kind == distance.CAPSULE)
        ]
        return np.array(kept, dtype=np.int64).reshape(len(kept), 3)

    def _drop_touching(self, arm: ArmDescription) -> None:
        """Leave out stand-ins that touch at rest; refuse what was described and does."""
        at_rest = self.clearances(arm.rest[None])[0]
        coarse = []
        for row, (kind, one, other) in enumerate(self._shapes.pairs.tolist()):
            if at_rest[row] >= 0.0:
                continue
            both = [self._capsules[one]] + [self._capsules[other]] * (kind == distance.CAPSULE)
            if kind == distance.CAPSULE and any(capsule.stand_in for capsule in both):
                coarse.append(row)
                continue
            first, second = self.names[row]
            raise InputError(
                f"{arm.name}: at its rest posture {first} is {-at_rest[row]:.3f} m inside"
                f" {second}: mend their shapes, or add the two to collision_ignore"
            )
        if coarse:
            self.unjudged = tuple(dict.fromkeys(self.names[row] for row in coarse))
            touching = {*self.unjudged}
            kept = [row for row, pair in enumerate(self.names) if pair not in touching]
            pairs = np.ascontiguousarray(self._shapes.pairs[kept])
            self._take(pairs, self._shapes._replace(pairs=pairs))
        self.at_rest = self.clearances(arm.rest[None])[0]

    def _reach_of(self, kind: int, one: int, other: int) -> FloatArray:
        """Bound of how far each joint moves the second against the first, shape (n,)."""
        if kind != distance.CAPSULE:
            return self._moved_by(self._capsules[one], -1)
        return self._moved_by(self._capsules[other], self._capsules[one].link)

    def _moved_by(self, capsule: _Capsule, still: int) -> FloatArray:
        """How far joints beyond link `still` move a capsule: by their distance along the chain."""
        chain = self._chain
        reach = np.zeros(chain.lower.size)
        ends = np.array([capsule.start, capsule.end])
        far = float(np.linalg.norm(ends, axis=1).max())
        for joint in range(capsule.link, still, -1):
            stroke = float(max(abs(chain.lower[joint]), abs(chain.upper[joint])))
            if chain.prismatic[joint]:
                reach[joint] = 1.0
                far += stroke
            elif joint == capsule.link:  # about its own z axis
                off_axis = float(np.linalg.norm(ends[:, :2], axis=1).max())
                reach[joint] = off_axis if off_axis > ON_AXIS else 0.0
            else:
                reach[joint] = far
            far += float(np.linalg.norm(chain.translation[joint]))
        return reach


def _capsules(arm: ArmDescription) -> list[_Capsule]:
    """All capsules of an arm, in the order of their links."""
    found = [_capsule(-1, shape, np.eye(3), stand_in=False) for shape in arm.base_shape]
    for row, joint in enumerate(arm.chain.joints):
        turn = turning_z_to(joint.axis)
        stand_in = arm.joint[row].shape is None
        found += [_capsule(row, shape, turn, stand_in=stand_in) for shape in capsules_of(arm, row)]
    return found


def _capsule(link: int, shape: CapsuleDescription, turn: FloatArray, *, stand_in: bool) -> _Capsule:
    start, end = np.array(shape.start) @ turn, np.array(shape.end) @ turn
    return _Capsule(link, start, end, shape.radius, stand_in)


def _arrays(arm: ArmDescription, capsules: list[_Capsule], pairs: IntArray) -> distance.ShapeArrays:
    normals = np.array([plane.normal for plane in arm.plane]).reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = np.array([plane.point for plane in arm.plane]).reshape(-1, 3)
    offsets = np.sum(normals * points, axis=1, keepdims=True)
    return distance.ShapeArrays(
        link=np.array([capsule.link for capsule in capsules], dtype=np.int64),
        start=np.array([capsule.start for capsule in capsules]).reshape(-1, 3),
        end=np.array([capsule.end for capsule in capsules]).reshape(-1, 3),
        radius=np.array([capsule.radius for capsule in capsules], dtype=np.float64),
        planes=np.hstack([normals, offsets]),
        box_rotation=np.array([from_rpy(box.rpy) for box in arm.box]).reshape(-1, 3, 3),
        box_centre=np.array([box.centre for box in arm.box]).reshape(-1, 3),
        box_half=0.5 * np.array([box.size for box in arm.box]).reshape(-1, 3),
        pairs=pairs,
    )
