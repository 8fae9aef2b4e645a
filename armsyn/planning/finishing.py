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
from armsyn.kernels.reaches import ALLOWED
from armsyn.motion.peaks import count_peaks
from armsyn.planning.bending import keeping_hand, leaves_range, to_end, within_ranges
from armsyn.planning.end_posture import end_posture, fulfilled
from armsyn.planning.ending import EASE
from armsyn.planning.generation.judging import judge
from armsyn.planning.generation.pacing import pace
from armsyn.planning.planned import PlannedReach, trajectory_of
from armsyn.planning.posing import HandTask
from armsyn.planning.postures import tips
from armsyn.planning.swivel import swivels
from armsyn.planning.timing import in_time
from armsyn.safety import check_trajectory
from armsyn.scoring import movement

FloatArray = NDArray[np.float64]

SHARES = (0.25, 0.5, 0.75, 1.0)
"""Of minimum jerk that are tried where a hand would speed up more than once."""

_SWING = 1e-4
"""rad (or m) by which a spline between samples within a range may leave it, and is put right."""


class Finished(NamedTuple):
    """A motion that an arm may follow.

    Attributes
    ----------
    angles : array, shape (frames, n)
        At the rate that was asked for, rad or m.
    positions : array, shape (frames, n + 1, 3)
        Of every joint and the tip then, m.
    time_scale : float
        kappa.
    swivel_m : float or None
        By how much the elbow ends elsewhere, m; None for the motion as predicted.
    evened : float
        How much of it is minimum jerk of every joint instead of what was predicted, 0 to 1.
    refused : str
        Why the predicted motion was, if it was.
    """

    angles: FloatArray
    positions: FloatArray
    time_scale: float
    swivel_m: float | None = None
    evened: float = 0.0
    refused: str = ""


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
        No way of those tried holds the limits, touches nothing and speeds up once; of the first.
    """
    angles = _brought_to_end(arm, angles, task)
    try:
        return checked(arm, angles, duration, rate_hz)
    except RefusedMotionError as error:
        refused = error
    for way in _other_ways(arm, angles, task, uneven=isinstance(refused, UnevenError)):
        try:
            done = checked(arm, way.angles, duration, rate_hz)
        except RefusedMotionError:  # the first refusal is the one that is told
            continue
        return done._replace(swivel_m=way.swivel_m, evened=way.evened, refused=str(refused))
    refused.add("other ways, with other swivels of the arm, were tried, too")
    raise refused


def _other_ways(
    arm: ArmDescription, angles: FloatArray, task: HandTask, *, uneven: bool
) -> Iterator[_Way]:
    """What else may serve; the one that is likeliest to first."""
    here = (_Way(_evened(angles, share), None, share) for share in SHARES)
    if uneven:
        yield from here
    for swivel in swivels(arm.chain, task, angles[-1]):
        for way in _ways(arm, angles, swivel.posture):
            yield _Way(way, swivel.moved_m, 0.0)
        yield _Way(_evened(way, 1.0), swivel.moved_m, 1.0)
    if not uneven:
        yield from here


def _evened(angles: FloatArray, share: float) -> FloatArray:
    """Mix a share of minimum jerk of every joint into a motion."""
    even = angles[0] + EASE[:, None] * (angles[-1] - angles[0])
    return np.asarray(angles + share * (even - angles))


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


def _brought_to_end(arm: ArmDescription, angles: FloatArray, task: HandTask) -> FloatArray:
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


def checked(arm: ArmDescription, angles: FloatArray, duration: float, rate_hz: float) -> Finished:
    """Bend a motion into the ranges, slow it, and refuse it if that fails or if it touches.

    Parameters
    ----------
    arm : ArmDescription
    angles : array, shape (phases, n)
        rad or m; the first and the last row within the limits.
    duration : float
        s.
    rate_hz : float

    Returns
    -------
    Finished

    Raises
    ------
    LimitError, CollisionError
        In the words of `armsyn.safety.check_trajectory`.
    UnevenError
        The hand's speed has more than one peak.
    """
    chain = arm.chain
    bent = within_ranges(chain, angles)
    paced = pace(arm, bent[None], np.array([duration]), rate_hz)
    if _swing(arm, paced.paths) > _SWING:  # the spline between samples that are within
        bent = within_ranges(chain, angles, inset=True)
        paced = pace(arm, bent[None], np.array([duration]), rate_hz)
    if outside := leaves_range(chain, bent):
        raise outside
    samples, scale = paced.path(0), float(paced.scales[0])
    if not len(samples):  # which then is refused here, by the joint's name
        samples, scale = in_time(bent, duration, arm, rate_hz)
    if _swing(arm, samples) < _SWING:
        np.clip(samples, chain.lower, chain.upper, out=samples)
    if judge(arm, paced).kinds[0] != ALLOWED:  # said in the driver's own words
        positions = chain.positions(samples)
        check_trajectory(trajectory_of(arm, samples, positions, rate_hz, "the reach"), arm)
    positions = arm.chain.positions(samples)
    if uneven := uneven_speed(positions[:, -1], rate_hz):
        raise uneven
    return Finished(samples, positions, scale)


def _swing(arm: ArmDescription, samples: FloatArray) -> float:
    """How far samples leave the joints' ranges, rad or m."""
    beyond = np.maximum(arm.chain.lower - samples, samples - arm.chain.upper)
    return float(beyond.max(initial=0.0))


def uneven_speed(hand: FloatArray, rate_hz: float) -> UnevenError | None:
    """Return the refusal of a motion whose hand speeds up more than once; None for a bell.

    Peaks are those of `armsyn.scoring`: of the speed as it is, or else filtered as there.

    Parameters
    ----------
    hand : array, shape (frames, 3)
        m, at `rate_hz`.
    rate_hz : float
    """
    speed = np.linalg.norm(np.diff(hand, axis=0), axis=1) * rate_hz
    if not speed.size or count_peaks(speed, rate_hz) <= 1:
        return None
    peaks = count_peaks(*_movement(hand, rate_hz))
    if peaks <= 1:
        return None
    return UnevenError(
        f"the hand would speed up {peaks} times on its way: go by way of another target", peaks
    )


def _movement(hand: FloatArray, rate_hz: float) -> tuple[FloatArray, float]:
    """The hand's speed from onset to offset, m/s, and its rate, as it is measured of any motion."""
    moved = movement(np.arange(len(hand)) / rate_hz, hand)
    return moved.speed, moved.rate


class UnevenError(RefusedMotionError):
    """A reach whose hand would speed up more than once.

    Parameters
    ----------
    message : str
        One line.
    peaks : int
        Of the hand's speed.
    """

    def __init__(self, message: str, peaks: int) -> None:
        super().__init__(message)
        self.peaks = peaks
