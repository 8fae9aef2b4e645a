"""Make a predicted motion one that an arm may follow, or say why it may not.

What is predicted is brought to its end, bent into the joints' ranges and slowed. If its hand then
speeds up more than once, every joint goes its way by minimum jerk instead; if it touches something,
or a limit does not hold, it is tried again with the elbow elsewhere at its end; and then refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import RefusedMotionError
from armsyn.kernels.reaches import ALLOWED
from armsyn.motion.filtering import hand_speed
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

FloatArray = NDArray[np.float64]

_SWING = 2e-3
"""rad (or m) by which a spline between samples within a range may leave it, and is put right."""


class Finished(NamedTuple):
    """A motion that an arm may follow.

    Attributes
    ----------
    angles : array, shape (frames, n)
        At the rate that was asked for, rad or m.
    time_scale : float
        kappa.
    swivel_m : float or None
        By how much the elbow ends elsewhere, m; None for the motion as predicted.
    evened : bool
        Whether every joint goes by minimum jerk instead of as predicted.
    refused : str
        Why the predicted motion was, if it was.
    """

    angles: FloatArray
    time_scale: float
    swivel_m: float | None = None
    evened: bool = False
    refused: str = ""


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
    tried = 0
    for way in _other_ways(arm, angles, task, uneven=isinstance(refused, UnevenError)):
        tried += way.evened is False
        try:
            done = checked(arm, way.angles, duration, rate_hz)
        except RefusedMotionError:  # the first refusal is the one that is told
            continue
        return done._replace(swivel_m=way.swivel_m, evened=way.evened, refused=str(refused))
    if tried:
        refused.add("other swivels of the arm were tried, too")
    raise refused


def _other_ways(
    arm: ArmDescription, angles: FloatArray, task: HandTask, *, uneven: bool
) -> Iterator[Finished]:
    """What else may serve, as predictions over phase; the one that is likeliest to first."""
    here = Finished(_evened(angles[0], angles[-1]), 1.0, evened=True)
    if uneven:
        yield here
    for swivel in swivels(arm.chain, task, angles[-1]):
        for way in _ways(arm, angles, swivel.posture):
            yield Finished(way, 1.0, swivel.moved_m)
        even = _evened(angles[0], swivel.posture)
        yield Finished(even, 1.0, swivel.moved_m, evened=True)
    if not uneven:
        yield here


def _evened(start: FloatArray, end: FloatArray) -> FloatArray:
    """Every joint by minimum jerk."""
    return np.asarray(start + EASE[:, None] * (end - start))


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
    distance, angle = task.errors(arm.chain, done.angles[-1])
    return PlannedReach(
        trajectory_of(arm, done.angles, rate_hz, source),
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
    bent = within_ranges(arm.chain, angles)
    if outside := leaves_range(arm.chain, bent):
        raise outside
    paced = pace(arm, bent[None], np.array([duration]), rate_hz)
    samples, scale = paced.path(0), float(paced.scales[0])
    if not len(samples):  # which then is refused here, by the joint's name
        samples, scale = in_time(bent, duration, arm, rate_hz)
    swing = np.clip(samples, arm.chain.lower, arm.chain.upper) - samples
    if np.abs(swing).max() < _SWING:
        samples += swing
    if judge(arm, paced).kinds[0] != ALLOWED:  # said in the driver's own words
        check_trajectory(trajectory_of(arm, samples, rate_hz, "the reach"), arm)
    if uneven := uneven_speed(arm, samples, rate_hz):
        raise uneven
    return Finished(samples, scale)


def uneven_speed(arm: ArmDescription, samples: FloatArray, rate_hz: float) -> UnevenError | None:
    """Return the refusal of a motion whose hand speeds up more than once; None for a bell.

    Peaks are those of `armsyn.scoring`: of the speed as it is, or else filtered as there.

    Parameters
    ----------
    arm : ArmDescription
    samples : array, shape (frames, n)
        rad or m, at `rate_hz`.
    rate_hz : float
    """
    hand = tips(arm.chain, samples)
    speed = np.linalg.norm(np.diff(hand, axis=0), axis=1) * rate_hz
    if not speed.size or count_peaks(speed, rate_hz) <= 1:
        return None
    profile = hand_speed(np.arange(len(hand)) / rate_hz, hand)
    peaks = count_peaks(profile.speed, profile.rate)
    if peaks <= 1:
        return None
    return UnevenError(
        f"the hand would speed up {peaks} times on its way: go by way of another target", peaks
    )


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
