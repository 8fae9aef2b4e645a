"""What is judged before and after a plan: where it starts, where it is to end, why it cannot."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import InputError, LimitError, UnreachableError
from armsyn.ik import IkResult, solve_ik
from armsyn.planning.prediction import real_numbers

FloatArray = NDArray[np.float64]

TOLERANCE_M = 1e-3
"""Every accepted reach ends within this distance of its target."""

PLANNING_RATE_HZ = 200.0
"""Frames a second of a plan, whatever rate it is streamed at: the explicit step of the controller
needs lambda dt g well below 1, and the driver interpolates."""

FARTHEST = 1e6
"""m or rad: what no arm has to do with, and far below what would overflow when it is squared."""

_TICK = 2.0 * np.pi / 4096.0


def checked_start(arm: ArmDescription, posture: ArrayLike, *, stands: bool = False) -> FloatArray:
    """Return where a plan starts, within the joints' ranges.

    Encoders round: a posture may lie a tick outside a limit, not more.

    Parameters
    ----------
    arm : ArmDescription
    posture : array_like, shape (n,)
        rad or m.
    stands : bool
        Whether an arm is there, which can be moved; else it is asked for.

    Returns
    -------
    array, shape (n,)

    Raises
    ------
    InputError
        Another count, no numbers, or not finite.
    LimitError
        The posture is outside the joints' ranges; the message names the first such joint.
    """
    start = arm.chain.checked_posture(real_numbers(posture, "a posture"))
    inside = np.clip(start, arm.chain.lower, arm.chain.upper)
    outside = np.flatnonzero(np.abs(start - inside) > _TICK)
    if outside.size:
        joint, value = arm.joint[int(outside[0])], float(start[outside[0]])
        raise LimitError(
            f"{joint.name} {'stands' if stands else 'is to start'} at {value:.3f} rad, outside its"
            f" range {joint.lower:g} to {joint.upper:g}"
            + (": move it back by hand" if stands else ""),
            joint.name,
            value,
            float(inside[outside[0]]),
        )
    return inside


def checked_target(target: ArrayLike) -> FloatArray:
    """Return a target as an array, shape (3,), m.

    Raises
    ------
    InputError
        No numbers, another count, not finite, or beyond `FARTHEST`.
    """
    goal = real_numbers(target, "a target")
    if goal.shape != (3,):
        raise InputError(f"a target is 3 finite numbers of metres, got an array of {goal.shape}")
    if not np.isfinite(goal).all():
        raise InputError(f"a target is 3 finite numbers of metres, got {goal.tolist()}")
    if np.abs(goal).max() > FARTHEST:
        raise InputError(f"a target lies within {FARTHEST:g} m of the base, got {goal.tolist()}")
    return goal


def checked_rate(rate_hz: float) -> float:
    """Return a trajectory's rate, Hz; InputError for one that is not positive."""
    if not 0 < rate_hz < np.inf:
        raise InputError(f"a trajectory needs a positive rate, got {rate_hz:g} Hz")
    return rate_hz


def reached_from(arm: ArmDescription, start: FloatArray, goal: FloatArray) -> IkResult:
    """Look for a posture at a target, from a start and then from random ones.

    Parameters
    ----------
    arm : ArmDescription
    start : array, shape (n,)
        rad or m.
    goal : array, shape (3,)
        m, base frame.

    Returns
    -------
    IkResult
    """
    return solve_ik(arm.chain, goal, start, restarts=20, tolerance=0.5 * TOLERANCE_M)


def out_of_reach(
    arm: ArmDescription, start: FloatArray, goal: FloatArray
) -> UnreachableError | None:
    """Return the refusal of a target that no posture found reaches; None for one within reach."""
    best = reached_from(arm, start, goal)
    return None if best.success else too_far(arm, goal, best)


def not_finite() -> UnreachableError:
    """Return the refusal of a target that no motion is predicted to."""
    return UnreachableError("the prediction is not finite", float("nan"))


def too_far(arm: ArmDescription, goal: FloatArray, best: IkResult) -> UnreachableError:
    """Return the refusal of a target that no posture found reaches.

    Parameters
    ----------
    arm : ArmDescription
    goal : array, shape (3,)
        m, base frame.
    best : IkResult
        The nearest that was found.

    Returns
    -------
    UnreachableError
        How near the hand comes, and what may be wrong.
    """
    return UnreachableError(
        f"target {where(goal)} cannot be reached by {arm.name}: its hand stays"
        f" {best.position_error:.3f} m away; {_advice(arm, goal)}",
        best.position_error,
    )


def where(goal: FloatArray) -> str:
    """A target in words."""
    return "({:.3f}, {:.3f}, {:.3f}) m".format(*goal)


def _advice(arm: ArmDescription, goal: FloatArray) -> str:
    base = arm.chain.forward(arm.rest).positions[0]
    distance, reach = float(np.linalg.norm(goal - base)), arm.chain.reach
    if distance > 10 * reach:
        return "targets are in metres"
    if distance > reach:
        return f"the arm is {reach:.2f} m long, the target {distance:.2f} m from its first joint"
    facing = np.array([np.cos(arm.facing), np.sin(arm.facing)]).round(2) + 0.0
    return (
        "it is too near, behind the arm or outside its joints' ranges: the arm faces"
        f" x {facing[0]:g}, y {facing[1]:g}"
    )
