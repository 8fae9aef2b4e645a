"""The hand's task at the end of a reach: a position, and perhaps how the hand is turned.

The hand points from the last joint to the tip; that is what `Pointing` directs. Users of poses give
the tip's whole orientation instead (`Turned`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.kinematics import SerialChain, quaternion
from armsyn.kinematics.rotation import checked_rotation, from_rpy

FloatArray = NDArray[np.float64]

DEFAULT_TOLERANCE = float(np.radians(2.0))
"""rad that a hand may be off the orientation that is asked for."""

_DAMPING = 1e-3
_LARGEST_STEP = 0.3
_STEPS = 100
_PROGRESS, _PATIENCE = 0.995, 8
"""Steps that bring less than that count as none; after so many of them there is nothing to come."""
_CLOSE = 1e-5
"""m (with turns weighed by a third of the reach) that are there."""


class HandOrientation(Protocol):
    """How the hand is to be turned at the end."""

    @property
    def tolerance(self) -> float:
        """Of the hand's orientation, rad."""

    @property
    def angles(self) -> int:
        """How many angles it asks for: 2 of a direction, 3 of a whole orientation."""

    def left(self, chain: SerialChain, hand: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the turn that is left, as a rotation vector, and what turns count, (3, 3)."""


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
        if wanted.shape != (3,) or not np.isfinite(wanted).all() or not np.linalg.norm(wanted):
            raise InputError(f"a direction is 3 finite numbers, not all 0, got {wanted.tolist()}")
        object.__setattr__(self, "direction", wanted / np.linalg.norm(wanted))
        _check_tolerance(self.tolerance)

    def left(self, chain: SerialChain, hand: FloatArray) -> tuple[FloatArray, FloatArray]:
        """As `HandOrientation.left`."""
        points = hand @ pointing_axis(chain)
        wanted = np.asarray(self.direction)
        across = np.cross(points, wanted)
        sine, cosine = float(np.linalg.norm(across)), float(points @ wanted)
        if sine < 1e-9 and cosine < 0.0:  # the other way: about any axis across
            across, sine = np.linalg.svd(points[None])[2][1], 1.0
        turn = np.arctan2(sine if cosine > -1.0 + 1e-15 else 0.0, cosine)
        return across * (turn / max(sine, 1e-12)), np.eye(3) - np.outer(points, points)


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

    def left(
        self,
        chain: SerialChain,  # noqa: ARG002 - as directions need it
        hand: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """As `HandOrientation.left`."""
        turn = np.asarray(self.rotation) @ hand.T
        return quaternion.to_expmap(quaternion.from_matrix(turn)), np.eye(3)


def pointing_axis(chain: SerialChain) -> FloatArray:
    """Direction from the last joint to the tip, in the tip's frame, shape (3,).

    The tip's x axis, where the tip lies in the last joint.
    """
    offset = from_rpy(chain.tip_rpy).T @ np.asarray(chain.tip_xyz)
    length = float(np.linalg.norm(offset))
    return offset / length if length > 1e-6 else np.array([1.0, 0.0, 0.0])


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
        if self.orientation is None:
            return self.goal - chain.positions(q[None])[0, -1], chain.jacobian(q)
        frames, jacobian = chain.forward(q), chain.jacobian(q, pose=True)
        turn, counts = self.orientation.left(chain, frames.orientations[-1])
        jacobian[3:] = counts @ jacobian[3:]
        return np.concatenate([self.goal - frames.tip, turn]), jacobian

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
    scale = np.concatenate([np.ones(3), np.full(3, 0.3 * chain.reach)])
    q = np.clip(near, chain.lower, chain.upper)
    best, least, stale = q, np.inf, 0
    for _ in range(steps):
        left, jacobian = task.left(chain, q)
        rows = scale[: left.size]
        left, jacobian = left * rows, jacobian * rows[:, None]
        miss = float(np.linalg.norm(left))
        stale = 0 if miss < _PROGRESS * least else stale + 1
        if miss < least:
            best, least = q, miss
        if miss < _CLOSE or stale > _PATIENCE:
            break
        q = np.clip(q + _step(chain, q, left, jacobian), chain.lower, chain.upper)
    return best


def _step(chain: SerialChain, q: FloatArray, left: FloatArray, jacobian: FloatArray) -> FloatArray:
    free = np.ones(q.size, dtype=bool)
    for _ in range(q.size):
        J = jacobian * free
        damping = _DAMPING * chain.reach * min(1.0, float(np.linalg.norm(left)) / chain.reach)
        dq = J.T @ np.linalg.solve(J @ J.T + (damping**2 + 1e-12) * np.eye(left.size), left)
        pressing = free & (((q <= chain.lower) & (dq < 0)) | ((q >= chain.upper) & (dq > 0)))
        if not pressing.any():
            break
        free &= ~pressing
    largest = float(np.abs(dq).max())
    return np.asarray(dq * min(1.0, _LARGEST_STEP / max(largest, 1e-12)))


def _check_tolerance(tolerance: float) -> None:
    if not 0.0 < tolerance <= np.pi:
        raise InputError(f"an orientation's tolerance is above 0 and at most pi, got {tolerance:g}")
