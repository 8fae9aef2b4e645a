"""Motions that must score worse than the prediction they are made from (controls).

A metric that any of them could win would not measure human-likeness.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from armsyn.experiments.anytarget_bootstrap import interval
from armsyn.experiments.anytarget_people import People
from armsyn.experiments.anytarget_run import DECIMALS, Outcome
from armsyn.experiments.learned import Progress
from armsyn.experiments.tables import Column, Table, Value, centimetres
from armsyn.motion import FloatArray, Motion
from armsyn.motion.resample import interpolate
from armsyn.scoring.distance import held_distance
from armsyn.scoring.pairing import pair_up, uncut
from armsyn.scoring.posture import DOWN
from armsyn.synergy.parallel import checked_workers, each

_REST_S = 1.0
_ROUNDING_M = 1e-6


def reversed_in_time(motion: Motion) -> Motion:
    """Play it backwards."""
    return _with(motion, motion.time, _landmarks(motion)[::-1])


def at_constant_speed(motion: Motion) -> Motion:
    """Keep the path and the duration; the hand goes at one speed."""
    steps = np.linalg.norm(np.diff(motion.hand, axis=0), axis=1)
    # The tiniest advance keeps places apart where the hand rests
    gone = np.concatenate([[0.0], np.cumsum(steps + 1e-9)])
    wanted = gone[-1] * (motion.time - motion.time[0]) / motion.duration
    return _with(motion, motion.time, interpolate(gone, _landmarks(motion), wanted))


def with_mirrored_elbow(motion: Motion) -> Motion:
    """Reflect the elbow in the upright plane through shoulder and hand."""
    landmarks = _landmarks(motion).copy()
    names = motion.landmark_names
    inner = [names.index(name) for name in ("elbow", "wrist") if name in names[:-1]]
    shoulder, hand = landmarks[:, names.index("shoulder")], landmarks[:, -1]
    normal = np.cross(hand - shoulder, DOWN)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    for place in inner:
        out = ((landmarks[:, place] - shoulder) * normal).sum(axis=1, keepdims=True)
        landmarks[:, place] -= 2 * out * normal
    return _with(motion, motion.time, landmarks)


def cut_half_way(motion: Motion) -> Motion:
    """Stop at half of the time."""
    return motion.between(0, motion.frames // 2)


def with_rest(motion: Motion) -> Motion:
    """Hold the last posture for another second."""
    count = round(_REST_S * motion.rate)
    later = motion.time[-1] + np.arange(1, count + 1) / motion.rate
    landmarks = _landmarks(motion)
    rest = landmarks[-1:].repeat(count, axis=0)
    return _with(motion, np.append(motion.time, later), np.concatenate([landmarks, rest]))


class Control(NamedTuple):
    """One way to spoil a motion."""

    title: str
    spoil: Callable[[Motion], Motion]
    only_never_better: bool = False
    """It may score the same; else it must score worse on the mean, its interval above zero."""


CONTROLS = (
    Control("reversed in time", reversed_in_time),
    Control("constant speed", at_constant_speed),
    Control("elbow mirrored", with_mirrored_elbow),
    Control("stopped half-way", cut_half_way),
    Control("rest appended, 1 s", with_rest, only_never_better=True),
)


def controls_table(
    outcome: Outcome, seed: int, workers: int | None, on_progress: Progress
) -> Table:
    """Spoil every prediction of a row in every way, and check that it loses.

    Parameters
    ----------
    outcome : Outcome
        Of the row whose predictions are spoilt.
    seed : int
        Of the bootstrap.
    workers : int or None
    on_progress : callable

    Returns
    -------
    Table
    """
    people = outcome.people
    jobs = [
        _Job(people.only((row,), ()), outcome.angles[row], float(outcome.durations[row]))
        for row in range(len(people.captured))
    ]
    distances = np.empty((len(jobs), 1 + len(CONTROLS)))
    stage = f"{people.title}: controls"
    for done, (row, found) in enumerate(each(_spoilt, jobs, checked_workers(workers, len(jobs)))):
        distances[row] = np.round(found, DECIMALS)
        on_progress(stage, done + 1, len(jobs), "")
    columns = (
        Column("control", "control"),
        centimetres("held", "held"),
        centimetres("worse_by", "worse by"),
        centimetres("low", "from"),
        centimetres("high", "to"),
        Column("better", "better in", ".0f"),
        Column("loses", "loses"),
    )
    rows = [_row(people, distances, place, seed) for place in range(len(CONTROLS))]
    lost = all(row[-1] == "yes" for row in rows)
    said = "All of them lose." if lost else "**A control wins: these distances judge nothing.**"
    note = (
        f"Made from the predictions of: {outcome.row.title}, {outcome.mean('held') * 100:.2f} cm."
        " A control loses when its interval lies above zero; appended rest must be better in no"
        f" reach. {said}"
    )
    return Table(f"{people.title}: controls that must lose", columns, rows, [note])


class _Job(NamedTuple):
    people: People
    angles: FloatArray
    duration: float


def _spoilt(job: _Job) -> list[float]:
    """Held distances of a prediction, then of it under every control."""
    captured = job.people.captured[0]
    predicted = job.people.motion(0, job.angles, job.duration)
    motions = [predicted, *(control.spoil(predicted) for control in CONTROLS)]
    return [held_distance(uncut(pair_up(captured, motion))) for motion in motions]


def _row(people: People, distances: FloatArray, place: int, seed: int) -> tuple[Value, ...]:
    control, found = CONTROLS[place], distances[:, 1 + place]
    gaps = found - distances[:, 0]
    groups = [
        np.array([gaps[people.of(subject, to)].mean() for to in people.places_of(subject)])
        for subject in people.subjects
    ]
    mean, low, high = interval(groups, seed)
    better = int((gaps < -_ROUNDING_M).sum())
    loses = better == 0 if control.only_never_better else low > 0
    return (
        control.title,
        float(found.mean()),
        *(mean, low, high),
        better,
        "yes" if loses else "NO",
    )


def _landmarks(motion: Motion) -> FloatArray:
    assert motion.landmarks is not None  # noqa: S101 - made with landmarks
    return motion.landmarks


def _with(motion: Motion, time: FloatArray, landmarks: FloatArray) -> Motion:
    return dataclasses.replace(motion, time=time, landmarks=landmarks)
