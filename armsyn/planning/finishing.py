"""Make a predicted motion one that an arm may follow, or say why it may not.

What is predicted is brought to its end, bent into the joints' ranges and slowed. If its hand then
speeds up more than once, it is evened, in steps, by the first that helps; if it touches something,
or a limit does not hold, it is tried again with the elbow elsewhere at its end. Where the one does
not help the other is tried, too, and at last a hand that speeds up more than once is led straight.
What does not pass then is refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import RefusedMotionError
from armsyn.planning.allowed import Finished, Tried, checked, tried
from armsyn.planning.bending import keeping_hand, leaves_range, to_end
from armsyn.planning.checking import reached_from
from armsyn.planning.end_posture import end_posture, fulfilled
from armsyn.planning.ending import EASE
from armsyn.planning.evening import EVENINGS, WHOLLY, Evening, evened, nearer
from armsyn.planning.evenness import UnevenError, uneven_speed
from armsyn.planning.examples import PHASES
from armsyn.planning.pacing import thinned, thinning
from armsyn.planning.planned import PlannedReach, trajectory_of
from armsyn.planning.posing import HandOrientation, HandTask, settled
from armsyn.planning.postures import tips
from armsyn.planning.swivel import Swivel, swivels
from armsyn.safety import Clearances

FloatArray = NDArray[np.float64]

TOGETHER = 2
"""Evenings that are tried at once: one more costs half as much as one alone."""


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
        refused = error.with_traceback(None)  # whose frames would keep all this in memory
    required, others = Clearances.of(arm, start=angles[0]), []
    uneven = isinstance(refused, UnevenError)
    for end, ways in _other_ways(arm, angles, task, uneven=uneven):
        known = uneven and np.array_equal(end, angles[-1])  # to touch nothing
        if not known and required.broken_by(end):  # and so is every way to it
            others.append(to_end(angles, end))
            continue
        some = list(ways)
        motions = np.array([way.angles for way in some])
        found = tried(arm, motions, np.full(len(some), duration), rate_hz)
        if done := _first_allowed(arm, some, found, duration, rate_hz):
            return done._replace(refused=str(refused))
        others += [
            way.angles
            for way, only_uneven in zip(some, found.uneven, strict=True)
            if not only_uneven
        ]
    raise _told(arm, refused, others, duration, rate_hz)


def warm_up(
    arm: ArmDescription,
    start: FloatArray,
    rate_hz: float,
    orientation: HandOrientation | None = None,
) -> None:
    """Compile what `finished` may need, whatever the first motions need of it.

    Parameters
    ----------
    arm : ArmDescription
    start : array, shape (n,)
        Within the limits, rad or m.
    rate_hz : float
    orientation : HandOrientation, optional
    """
    task = HandTask(tips(arm.chain, start[None])[0], orientation)
    still = np.repeat(start[None], PHASES, axis=0)
    tried(arm, still[None], np.ones(1), rate_hz)
    Clearances.of(arm).broken_by(start)
    uneven_speed(tips(arm.chain, still), rate_hz)
    reached_from(arm, start, task.goal)
    settled(arm.chain, task, start)
    for _, ways in _other_ways(arm, still, task, uneven=True):
        list(ways)


def _first_allowed(
    arm: ArmDescription, ways: Sequence[_Way], found: Tried, duration: float, rate_hz: float
) -> Finished | None:
    """Return the first of some ways that an arm may follow; bent, where it has to be."""
    for row, way in enumerate(ways):
        done = None
        if found.allowed[row]:
            done = Finished(found.paced.path(row), float(found.paced.scales[row]))
        elif found.beyond[row] or found.swung[row]:
            with suppress(RefusedMotionError):
                done = checked(arm, way.angles, duration, rate_hz)
        if done:
            return done._replace(swivel_m=way.swivel_m, evened=way.evened)
    return None


def _told(
    arm: ArmDescription,
    refused: RefusedMotionError,
    others: Sequence[FloatArray],
    duration: float,
    rate_hz: float,
) -> RefusedMotionError:
    """Return what is said where nothing serves.

    Where the motion as predicted is uneven only, that is what is in the way of `others` first.
    """
    told = refused
    for angles in others if isinstance(refused, UnevenError) else ():
        try:
            checked(arm, angles, duration, rate_hz)
        except UnevenError:
            continue
        except RefusedMotionError as error:
            told = error.with_traceback(None)
            told.add(f"as predicted, {refused}")
            break
    told.add("other ways, with other swivels of the arm, were tried, too")
    return told


class _Way(NamedTuple):
    """Another motion over phase to the target; see `Finished`."""

    angles: FloatArray
    swivel_m: float | None
    before: FloatArray
    how: Evening | None = None

    @property
    def evened(self) -> float:
        """How much nearer to minimum jerk than before."""
        return float(nearer(self.before, self.how)) if self.how else 0.0


_Ways = tuple[FloatArray, Iterable[_Way]]
"""An end posture, and ways there."""


def _other_ways(
    arm: ArmDescription, angles: FloatArray, task: HandTask, *, uneven: bool
) -> Iterator[_Ways]:
    """What else may serve; the one that is likeliest to first."""
    here = _evened_ways(arm, angles)
    if uneven:
        yield from here
    for swivel in swivels(arm.chain, task, angles[-1]):
        yield swivel.posture, _swivelled(arm, angles, swivel)
    if not uneven:
        yield from here
    elif (straight := _straight(arm, angles)) is not None:
        yield angles[-1], [straight]


def _evened_ways(arm: ArmDescription, angles: FloatArray) -> Iterator[_Ways]:
    """Smoothed, a joint that turns at its limit swings past: such a way is none."""
    is_bent = leaves_range(arm.chain, angles) is not None  # as then every other is, too
    for first in range(0, len(EVENINGS), TOGETHER):
        some = EVENINGS[first : first + TOGETHER]
        ways = [_Way(evened(angles, how), None, angles, how) for how in some]
        kept = [way for way in ways if is_bent or leaves_range(arm.chain, way.angles) is None]
        if kept:
            yield angles[-1], kept


def _straight(arm: ArmDescription, angles: FloatArray) -> _Way | None:
    """The hand goes straight by minimum jerk, the joints as nearly so as that lets them."""
    plain = evened(angles, WHOLLY)
    first, last = tips(arm.chain, plain[[0, -1]])
    kept = keeping_hand(arm.chain, plain, first + EASE[:, None] * (last - first))
    return None if kept is None else _Way(kept, None, plain, WHOLLY)


def _swivelled(arm: ArmDescription, angles: FloatArray, swivel: Swivel) -> Iterator[_Way]:
    for way in _ways(arm, angles, swivel.posture):
        yield _Way(way, swivel.moved_m, way)
    yield _Way(evened(way, WHOLLY), swivel.moved_m, way, WHOLLY)


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
        Sampled so many times as often (`armsyn.planning.pacing.thinning`), that the
        limits hold between frames, too.
    rate_hz : float
        Of the trajectory.
    plan, duration_s, outside_m, **how
        As in `PlannedReach`.
    source : str
        Of the trajectory, for people.

    Returns
    -------
    PlannedReach
    """
    angles = thinned(done.angles, thinning(rate_hz))
    positions = arm.chain.positions(angles)
    distance, angle = math.dist(task.goal, positions[-1, -1]), 0.0
    if task.orientation is not None:
        _, angle = task.errors(arm.chain, angles[-1])
    return PlannedReach(
        trajectory_of(arm, angles, positions, rate_hz, source),
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
