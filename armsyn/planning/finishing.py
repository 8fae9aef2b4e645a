"""Make a predicted motion one that an arm may follow, or say why it may not.

What is predicted is brought to its end, bent into the joints' ranges and slowed. If its hand then
speeds up more than once, it is mixed with minimum jerk of every joint, as little as helps; if it
touches something, or a limit does not hold, it is tried again with the elbow elsewhere at its end;
and then refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import RefusedMotionError
from armsyn.planning.allowed import Finished, checked
from armsyn.planning.bending import keeping_hand, to_end
from armsyn.planning.end_posture import end_posture, fulfilled
from armsyn.planning.ending import EASE
from armsyn.planning.evenness import UnevenError
from armsyn.planning.planned import PlannedReach, trajectory_of
from armsyn.planning.posing import HandTask
from armsyn.planning.postures import tips
from armsyn.planning.swivel import swivels

FloatArray = NDArray[np.float64]

SHARES = (0.25, 0.5, 0.75, 1.0)
"""Of minimum jerk that are tried where a hand would speed up more than once."""


class _Way(NamedTuple):
    """Another motion over phase to the target; see `Finished`."""

    angles: FloatArray
    swivel_m: float | None
    evened: float


def finished(
    arm: ArmDescription, angles: FloatArray, duration: float, task: HandTask, rate_hz: float
) -> Finished:
    """Bend, slow and check a predicted motion; try other ways before it is refused.

    Parameters
    ----------
    arm : ArmDescription
    angles : array, shape (phases, n)
        Predicted, at equal steps of phase; the first row is where the arm is, within its limits.
    duration : float
        As a person would take, s.
    task : HandTask
        What the hand is to do at the end.
    rate_hz : float

    Returns
    -------
    Finished

    Raises
    ------
    UnreachableError
        The hand cannot come within `TOLERANCE_M` of its target, or be turned as asked.
    LimitError, CollisionError, UnevenError
        No way of those tried holds the limits, touches nothing and speeds up once; of the first,
        or, where that speeds up more than once only, of the first that fails otherwise.
    """
    angles = brought_to_end(arm, angles, task)
    try:
        return checked(arm, angles, duration, rate_hz)
    except RefusedMotionError as error:
        refused = told = error
    for way in _other_ways(arm, angles, task, uneven=isinstance(refused, UnevenError)):
        try:
            done = checked(arm, way.angles, duration, rate_hz)
        except RefusedMotionError as error:
            if isinstance(told, UnevenError):  # what is in the way of evening is why
                told = error
            continue
        return done._replace(swivel_m=way.swivel_m, evened=way.evened, refused=str(refused))
    if told is not refused:
        told.add(f"as predicted, {refused}")
    told.add("other ways, with other swivels of the arm, were tried, too")
    raise told


def _other_ways(
    arm: ArmDescription, angles: FloatArray, task: HandTask, *, uneven: bool
) -> Iterator[_Way]:
    """What else may serve; the one that is likeliest to first."""
    here = (_Way(evened(angles, share), None, share) for share in SHARES)
    if uneven:
        yield from here
    for swivel in swivels(arm.chain, task, angles[-1]):
        for way in _ways(arm, angles, swivel.posture):
            yield _Way(way, swivel.moved_m, 0.0)
        yield _Way(evened(way, 1.0), swivel.moved_m, 1.0)
    if not uneven:
        yield from here


def evened(angles: FloatArray, share: float) -> FloatArray:
    """Mix a share of minimum jerk of every joint into motions, shape (..., phases, n)."""
    start, way = angles[..., :1, :], angles[..., -1:, :] - angles[..., :1, :]
    return np.asarray(angles + share * (start + EASE[:, None] * way - angles))


def reach_of(
    arm: ArmDescription,
    task: HandTask,
    done: Finished,
    rate_hz: float,
    *,
    plan: str,
    duration_s: float,
    source: str,
    outside_m: float | None = None,
    **how: Any,
) -> PlannedReach:
    """Make a finished motion a planned reach.

    Parameters
    ----------
    arm : ArmDescription
    task : HandTask
    done : Finished
    rate_hz : float
        That `done` was sampled at.
    plan, duration_s, outside_m, **how
        As in `PlannedReach`.
    source : str
        Of the trajectory, for people.

    Returns
    -------
    PlannedReach
    """
    distance, angle = math.dist(task.goal, done.positions[-1, -1]), 0.0
    if task.orientation is not None:
        _, angle = task.errors(arm.chain, done.angles[-1])
    return PlannedReach(
        trajectory_of(arm, done.angles, done.positions, rate_hz, source),
        task.goal,
        plan,
        done.time_scale,
        duration_s,
        distance,
        outside_m,
        done.swivel_m,
        done.evened,
        done.refused,
        orientation=task.orientation,
        orientation_error=angle,
        **how,
    )


def brought_to_end(arm: ArmDescription, angles: FloatArray, task: HandTask) -> FloatArray:
    """End where the hand does its task; turned otherwise than predicted, its path stays."""
    chain, predicted = arm.chain, angles[-1]
    inside = bool(((predicted >= chain.lower) & (predicted <= chain.upper)).all())
    if inside and fulfilled(task, *task.errors(chain, predicted)):
        return angles
    end = end_posture(arm, task, angles[0], predicted)
    return to_end(angles, end) if task.orientation is None else next(_ways(arm, angles, end))


def _ways(arm: ArmDescription, angles: FloatArray, end: FloatArray) -> Iterator[FloatArray]:
    """The same motion to another end posture: along the hand's own path, or as the joints go."""
    elsewhere = to_end(angles, end)
    hand = to_end(tips(arm.chain, angles), tips(arm.chain, end[None])[0])
    kept = keeping_hand(arm.chain, elsewhere, hand)
    if kept is not None:
        yield kept
    yield elsewhere
