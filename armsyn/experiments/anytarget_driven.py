"""What an arm gets of predicted reaches: bent, evened, with another swivel, or refused."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import load_arm
from armsyn.errors import RefusedMotionError
from armsyn.experiments.anytarget_people import People
from armsyn.experiments.anytarget_run import DECIMALS, Outcome
from armsyn.experiments.learned import Progress
from armsyn.experiments.tables import Column, Table, Value, centimetres
from armsyn.motion import FloatArray
from armsyn.motion.resample import interpolate
from armsyn.planning.allowed import Finished
from armsyn.planning.checking import PLANNING_RATE_HZ
from armsyn.planning.examples import PHASE
from armsyn.planning.finishing import finished
from armsyn.planning.posing import HandTask
from armsyn.planning.timing import PhasePath, phases
from armsyn.scoring.distance import held_distance
from armsyn.scoring.pairing import pair_up, uncut
from armsyn.synergy.parallel import checked_workers, each

SAME_RAD = 0.01
"""A motion whose joints are all this near to the predicted one is unchanged."""
_EVENED = ("evened by under 10 %", "evened by 10 to 50 %", "evened by 50 % and more")
_WAYS = (
    "as predicted",
    "bent into its ranges, or to its target",
    *_EVENED,
    "another swivel",
    "another swivel, evened",
    "refused",
)
_NOTE = (
    "What the planner makes of each prediction, by `armsyn.planning.finishing`. as predicted: no"
    f" joint goes by more than {SAME_RAD:g} rad elsewhere on its way; evened: brought so much"
    " nearer to minimum jerk of every joint, for the hand would speed up more than once. Held"
    " distance over normalised time in the movement time predicted, ramps from rest and to it"
    " within, without the arm's own slowing (slower: its mean factor, never scored); time given: in"
    " the person's. Refused reaches have no distance after it."
)


def driven_table(outcome: Outcome, arm: str, workers: int | None, on_progress: Progress) -> Table:
    """Finish every prediction of a row as a planner does, and score what is left of it.

    Parameters
    ----------
    outcome : Outcome
        Of people whose chain is the arm's.
    arm : str
        Its name.
    workers : int or None
    on_progress : callable

    Returns
    -------
    Table
        Reaches by what became of them, then all that are driven.
    """
    people = outcome.people
    jobs = [
        _Job(people.only((row,), ()), outcome.angles[row], float(outcome.durations[row]), arm)
        for row in range(len(people.captured))
    ]
    ways, scores = np.empty(len(jobs), dtype=int), np.full((len(jobs), 4), np.nan)
    for done, (row, found) in enumerate(each(_drive, jobs, checked_workers(workers, len(jobs)))):
        ways[row], scores[row] = found.way, np.round(found.scores, DECIMALS)
        on_progress(f"{people.title}: as driven", done + 1, len(jobs), "")
    rows = [_row(title, ways == way, scores) for way, title in enumerate(_WAYS)]
    rows.append(_row("all that are driven", ways != _WAYS.index("refused"), scores))
    columns = (
        Column("what", "what becomes of them"),
        Column("reaches", "reaches", ".0f"),
        Column("share", "share", ".1%"),
        centimetres("held", "as predicted"),
        centimetres("held_driven", "as driven"),
        centimetres("held_driven_time_given", "driven, time given"),
        Column("time_scale", "slower", ".2f"),
    )
    title = f"{people.title}: {outcome.row.title}, as driven by {arm}"
    return Table(title, columns, rows, [_NOTE])


class _Job(NamedTuple):
    people: People
    angles: FloatArray
    duration: float
    arm: str


class _Driven(NamedTuple):
    way: int
    scores: tuple[float, float, float, float]
    """Held distance as predicted, as driven, so with time given, m; time scale."""


def _drive(job: _Job) -> _Driven:
    people, angles = job.people, job.angles
    predicted = _held(people, angles, job.duration)
    task = HandTask(people.examples.targets[0])
    try:
        done = finished(
            load_arm(job.arm, calibrated=False), angles, job.duration, task, PLANNING_RATE_HZ
        )
    except RefusedMotionError:
        return _Driven(_WAYS.index("refused"), (predicted, np.nan, np.nan, np.nan))
    driven = over_phase(done)
    given = _held(people, driven, people.captured[0].duration)
    scores = predicted, _held(people, driven, job.duration), given, done.time_scale
    return _Driven(_WAYS.index(way_of(done, angles)), scores)


def over_phase(done: Finished) -> FloatArray:
    """Return what is driven over normalised time, shape (101, n), rad: its slowing is gone."""
    return interpolate(np.linspace(0.0, 1.0, len(done.angles)), done.angles, PHASE)


def way_of(done: Finished, predicted: FloatArray) -> str:
    """Say what became of a prediction, shape (101, n), in the words of the table."""
    if done.swivel_m is not None:
        return "another swivel, evened" if done.evened else "another swivel"
    if done.evened:
        return _EVENED[int(np.searchsorted((0.1, 0.5), done.evened, side="right"))]
    path = PhasePath(predicted)  # over phase, for the ramps from rest and to it bend no joint
    there = path.at(phases(len(done.angles), *path.ramps()))
    is_same = np.abs(done.angles - there).max() <= SAME_RAD
    return "as predicted" if is_same else "bent into its ranges, or to its target"


def _held(people: People, angles: FloatArray, duration: float) -> float:
    return held_distance(uncut(pair_up(people.captured[0], people.motion(0, angles, duration))))


def _row(title: str, chosen: NDArray[np.bool_], scores: FloatArray) -> tuple[Value, ...]:
    """One line of the table, of the reaches that are chosen."""
    count = int(chosen.sum())
    means = scores[chosen].mean(axis=0) if count else np.full(scores.shape[1], np.nan)
    shown = [float(mean) if np.isfinite(mean) else None for mean in means]
    return (title, count, count / len(chosen), *shown)
