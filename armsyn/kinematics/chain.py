"""Serial chains of revolute and prismatic joints: frames and Jacobians."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.kernels import chain as kernels
from armsyn.kinematics.rotation import from_expmap, from_rpy, turning_z_to

FloatArray = NDArray[np.float64]
Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Joint:
    """One moving joint, as URDF describes it.

    Parameters
    ----------
    name : str
    kind : {"revolute", "prismatic"}
    xyz : 3-tuple of float
        Origin in the parent joint's frame at zero, m.
    rpy : 3-tuple of float
        Orientation in the parent joint's frame at zero: fixed-axis roll, pitch, yaw, rad.
    axis : 3-tuple of float
        Axis in the joint's own frame; made a unit vector.
    lower, upper : float
        Limits, rad (revolute) or m (prismatic).
    """

    name: str
    kind: Literal["revolute", "prismatic"] = "revolute"
    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)
    axis: Triple = (0.0, 0.0, 1.0)
    lower: float = -np.pi
    upper: float = np.pi

    def __post_init__(self) -> None:
        if self.kind not in ("revolute", "prismatic"):
            raise InputError(f"joint {self.name}: kind {self.kind!r} is not revolute or prismatic")
        values = np.array([*self.xyz, *self.rpy, *self.axis, self.lower, self.upper])
        if values.shape != (11,) or not np.isfinite(values).all():
            raise InputError(f"joint {self.name}: xyz, rpy, axis and limits must be finite numbers")
        if not np.linalg.norm(self.axis) > 1e-9:
            raise InputError(f"joint {self.name}: its axis has no length")
        if not self.lower < self.upper:
            raise InputError(
                f"joint {self.name}: lower limit {self.lower:g} is not below upper {self.upper:g}"
            )


class ChainFrames(NamedTuple):
    """Forward kinematics of one posture, in the base frame.

    Attributes
    ----------
    positions : array, shape (n + 1, 3)
        Of every joint's frame and, last, of the tip, m.
    orientations : array, shape (n + 1, 3, 3)
        Of every joint's frame after its own motion and, last, of the tip.
    """

    positions: FloatArray
    orientations: FloatArray

    @property
    def tip(self) -> FloatArray:
        """Position of the tip, shape (3,), m."""
        return np.asarray(self.positions[-1])


class SerialChain:
    """A serial chain of joints with a tip.

    Parameters
    ----------
    joints : sequence of Joint
        From base to tip; at least one.
    tip_xyz, tip_rpy : 3-tuple of float
        The tip in the last joint's frame, m and rad (fixed-axis roll, pitch, yaw).

    Raises
    ------
    InputError
        No joints, or two of one name.
    """

    def __init__(
        self,
        joints: tuple[Joint, ...],
        tip_xyz: Triple = (0.0, 0.0, 0.0),
        tip_rpy: Triple = (0.0, 0.0, 0.0),
    ) -> None:
        if not joints:
            raise InputError("a serial chain needs at least one joint")
        names = tuple(joint.name for joint in joints)
        if len(set(names)) != len(names):
            raise InputError(f"two joints of the chain share a name: {names}")
        self.joints = tuple(joints)
        self.names = names
        self.tip_xyz = tip_xyz
        self.tip_rpy = tip_rpy
        self.arrays = self._canonical_arrays()

    def _canonical_arrays(self) -> kernels.ChainArrays:
        """Turn every frame so that its joint's axis is z."""
        turns = np.array([turning_z_to(joint.axis) for joint in self.joints])
        before = np.concatenate([np.eye(3)[None], turns]).transpose(0, 2, 1)
        after = np.concatenate([turns, np.eye(3)[None]])
        shifts = np.array([j.xyz for j in self.joints] + [self.tip_xyz])
        return kernels.ChainArrays(
            rotation=np.ascontiguousarray(before @ self._fixed_rotations @ after),
            translation=np.ascontiguousarray(np.einsum("kij,kj->ki", before, shifts)),
            prismatic=np.array([j.kind == "prismatic" for j in self.joints]),
            lower=np.array([j.lower for j in self.joints]),
            upper=np.array([j.upper for j in self.joints]),
        )

    @cached_property
    def _fixed_rotations(self) -> FloatArray:
        """Of every joint and the tip in the parent's frame at zero, shape (n + 1, 3, 3)."""
        return np.array([from_rpy(rpy) for rpy in (*(j.rpy for j in self.joints), self.tip_rpy)])

    @cached_property
    def _turning_axes(self) -> FloatArray:
        """Unit axes in the joints' own frames, zero for prismatic joints, shape (n, 3)."""
        axes = np.array([joint.axis for joint in self.joints])
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        axes[self.arrays.prismatic] = 0.0
        return axes

    @property
    def dof(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def lower(self) -> FloatArray:
        """Lower limits, shape (n,), rad or m."""
        return self.arrays.lower

    @property
    def upper(self) -> FloatArray:
        """Upper limits, shape (n,), rad or m."""
        return self.arrays.upper

    @cached_property
    def reach(self) -> float:
        """Greatest distance from the first joint to the tip that link lengths allow, m.

        An upper bound: joint limits may keep the tip nearer. Offsets between consecutive joints
        count in full; the base's own offset does not.
        """
        links = float(np.linalg.norm(self.arrays.translation[1:], axis=1).sum())
        strokes = [max(abs(j.lower), abs(j.upper)) for j in self.joints if j.kind == "prismatic"]
        return links + sum(strokes)

    def checked_posture(self, q: ArrayLike) -> FloatArray:
        """Return `q` as an array of shape (n,).

        Raises
        ------
        InputError
            Wrong count, or not finite.
        """
        posture = np.array(q, dtype=np.float64)
        if posture.shape != (self.dof,) or not np.isfinite(posture).all():
            raise InputError(
                f"a posture of this chain is {self.dof} finite numbers, got {posture.tolist()}"
            )
        return posture

    def forward(self, q: ArrayLike) -> ChainFrames:
        """Positions and orientations of every joint and the tip.

        Parameters
        ----------
        q : array_like, shape (n,)
            Joint values, rad or m; limits are not applied.

        Returns
        -------
        ChainFrames

        Raises
        ------
        InputError
            Wrong count, or not finite.
        """
        posture = self.checked_posture(q)
        orientations = self._fixed_rotations.copy()
        turns = from_expmap(posture[:, None] * self._turning_axes)
        orientation = np.eye(3)
        for row in range(self.dof):
            orientation = orientation @ orientations[row] @ turns[row]
            orientations[row] = orientation
        orientations[-1] = orientation @ orientations[-1]
        return ChainFrames(self.positions(posture[None])[0], orientations)

    def positions(self, angles: ArrayLike) -> FloatArray:
        """Positions of every joint and the tip along a path.

        Parameters
        ----------
        angles : array_like, shape (frames, n)
            Joint values, rad or m.

        Returns
        -------
        array, shape (frames, n + 1, 3)
            In the base frame, m.

        Raises
        ------
        InputError
            Wrong count, or not finite.
        """
        path = np.ascontiguousarray(angles, dtype=np.float64)
        if path.ndim != 2 or path.shape[1] != self.dof or not np.isfinite(path).all():
            raise InputError(f"a path of this chain has {self.dof} finite columns")
        return kernels.positions_along(self.arrays, path)

    def jacobian(self, q: ArrayLike, *, pose: bool = False) -> FloatArray:
        """Geometric Jacobian of the tip in the base frame.

        Parameters
        ----------
        q : array_like, shape (n,)
            Joint values, rad or m.
        pose : bool
            With the three rows of angular velocity below those of linear velocity.

        Returns
        -------
        array, shape (3, n) or (6, n)
            m/rad and rad/rad (m/m and 0 for prismatic joints).

        Raises
        ------
        InputError
            Wrong count, or not finite.
        """
        J = np.empty((6 if pose else 3, self.dof))
        kernels.jacobian_at(self.arrays, self.checked_posture(q), J)
        return J
