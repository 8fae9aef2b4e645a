"""The hand's task at the end of a reach: a position, and perhaps how the hand is turned.

The hand points from the last joint to the tip; that is what `Pointing` directs. Users of poses give
the tip's whole orientation instead (`Turned`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.kernels import settling
from armsyn.kinematics import SerialChain
from armsyn.kinematics.rotation import checked_rotation, from_rpy

FloatArray = NDArray[np.float64]

DEFAULT_TOLERANCE = float(np.radians(2.0))
"""rad that a hand may be off the orientation that is asked for."""

_STEPS = 100


class HandOrientation(Protocol):
    """How the hand is to be turned at the end."""

    @property
    def tolerance(self) -> float:
        """Of the hand's orientation, rad."""

    @property
    def angles(self) -> int:
        """How many angles it asks for: 2 of a direction, 3 of a whole orientation."""

    @property
    def wanted(self) -> FloatArray:
        """The tip's orientation, or the direction as the first row; shape (3, 3)."""


@dataclass(frozen=True)
class Pointing:
    """The hand points in a direction; its roll about that is free.

    Parameters
    ----------
    direction : array_like, shape (3,)
        Base frame, any length.
    tolerance : float
        rad.

    Raises
    ------
    InputError
        No direction, or a tolerance outside (0, pi].
    """

    direction: ArrayLike
    tolerance: float = DEFAULT_TOLERANCE
    angles = 2

    def __post_init__(self) -> None:
        wanted = np.asarray(self.direction, dtype=np.float64)
        if wanted.shape != (3,) or not np.isfinite(wanted).all() or not wanted.any():
            raise InputError(f"a direction is 3 finite numbers, not all 0, got {wanted.tolist()}")
        wanted = wanted / np.abs(wanted).max()  # whose squares neither overflow nor vanish
        object.__setattr__(self, "direction", wanted / np.linalg.norm(wanted))
        _check_tolerance(self.tolerance)

    @property
    def wanted(self) -> FloatArray:
        """As `HandOrientation.wanted`."""
        return np.array((self.direction,) * 3)


@dataclass(frozen=True)
class Turned:
    """The tip's frame has a given orientation.

    Parameters
    ----------
    rotation : array_like, shape (3, 3)
        Of the tip's frame in the base frame.
    tolerance : float
        rad.

    Raises
    ------
    InputError
        No rotation matrix, or a tolerance outside (0, pi].
    """

    rotation: ArrayLike
    tolerance: float = DEFAULT_TOLERANCE
    angles = 3

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotation", checked_rotation(self.rotation))
        _check_tolerance(self.tolerance)

    @property
    def wanted(self) -> FloatArray:
        """As `HandOrientation.wanted`."""
        return np.array(self.rotation, order="C")


def pointing_axis(chain: SerialChain) -> FloatArray:
    """Direction from the last joint to the tip, in the tip's frame, shape (3,).

    The tip's x axis, where the tip lies in the last joint.
    """
    return _pointing(tuple(chain.tip_xyz), tuple(chain.tip_rpy))


@lru_cache(maxsize=32)
def _pointing(tip_xyz: tuple[float, ...], tip_rpy: tuple[float, ...]) -> FloatArray:
    offset = from_rpy(tip_rpy).T @ np.asarray(tip_xyz)
    length = float(np.linalg.norm(offset))
    return offset / length if length > 1e-6 else np.array([1.0, 0.0, 0.0])


_NOT_TURNED = np.zeros((3, 3))


class HandTask(NamedTuple):
    """What the hand is to be at the end of a reach.

    Attributes
    ----------
    goal : array, shape (3,)
        m, base frame.
    orientation : HandOrientation or None
    """

    goal: FloatArray
    orientation: HandOrientation | None = None

    def left(self, chain: SerialChain, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What is left to do at a posture, and the Jacobian of it.

        Returns
        -------
        array, shape (3,) or (6,)
            m, then rad.
        array, shape (3, n) or (6, n)
        """
        rows = 3 if self.orientation is None else 6
        left, J = np.empty(rows), np.empty((rows, chain.dof))
        posture = np.array(q, dtype=np.float64)
        settling.task_left(chain.arrays, *self.arguments(chain), posture, left, J)
        return left, J

    def arguments(self, chain: SerialChain) -> tuple[FloatArray, int, FloatArray, FloatArray]:
        """Return the task as `armsyn.kernels.settling` takes it: goal, angles, wanted, axis."""
        goal = np.array(self.goal, dtype=np.float64)
        if self.orientation is None:
            return goal, 0, _NOT_TURNED, _NOT_TURNED[0]
        return goal, self.orientation.angles, self.orientation.wanted, pointing_axis(chain)

    def errors(self, chain: SerialChain, q: FloatArray) -> tuple[float, float]:
        """Distance of the hand to the goal, m, and angle to the orientation, rad."""
        if self.orientation is None:
            return math.dist(self.goal, chain.positions(q[None])[0, -1]), 0.0
        left, _ = self.left(chain, q)
        return float(np.linalg.norm(left[:3])), float(np.linalg.norm(left[3:]))


def settled(
    chain: SerialChain, task: HandTask, near: FloatArray, steps: int = _STEPS
) -> FloatArray:
    """Return the posture nearest to a given one, about, in which the hand does its task best.

    Damped least squares within the joints' limits; a joint that presses against its limit is left
    out of a step (as in `armsyn.ik.solve_ik`, which knows no directions).

    Parameters
    ----------
    chain : SerialChain
    task : HandTask
    near : array, shape (n,)
        Where to start, rad or m.
    steps : int
        At most.

    Returns
    -------
    array, shape (n,)
        Within the limits; how well it does is to be asked of the task.
    """
    q = np.array(near, dtype=np.float64)
    settling.settle(chain.arrays, *task.arguments(chain), chain.reach, steps, q)
    return q


def _check_tolerance(tolerance: float) -> None:
    if not 0.0 < tolerance <= np.pi:
        raise InputError(f"an orientation's tolerance is above 0 and at most pi, got {tolerance:g}")
