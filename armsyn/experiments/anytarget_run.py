"""Predict and score every reach of the experiment `anytarget`, over several processes."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armsyn.experiments.anytarget_people import Fold, People, Protocol, folds
from armsyn.experiments.anytarget_rows import Predicts, Row
from armsyn.experiments.anytarget_scores import MEASURES, score
from armsyn.experiments.learned import Progress
from armsyn.motion import FloatArray
from armsyn.scoring.floor import FEWEST_REPEATS
from armsyn.synergy.parallel import checked_workers, each

TITLES: dict[Protocol, str] = {
    "target": "leave one target out, within a person",
    "subject": "leave one person out",
}
DECIMALS = 7
"""That are kept of every measure: the last bits depend on how a machine splits its sums."""


class _Job(NamedTuple):
    """Reaches that rows predict by what they learn from others."""

    rows: tuple[Row, ...]
    """One, or all that share what they learn from."""
    people: People
    """Tests first, then those learned from."""
    tests: int
    profile: FloatArray


class _Done(NamedTuple):
    scores: FloatArray
    angles: FloatArray
    durations: FloatArray
    seconds: float


@dataclass(frozen=True, eq=False)
class Outcome:
    """What one row came to on every reach of some people.

    Parameters
    ----------
    row : Row
    people : People
    protocol : {"target", "subject"}
    scores : array, shape (reaches, measures)
        By the fields of `Score`; NaN where the row has nothing to learn from.
    angles, durations : array, shape (reaches, 101, n) and (reaches,)
        As predicted.
    seconds : float
        To predict one reach, on this machine.
    """

    row: Row
    people: People
    protocol: Protocol
    scores: FloatArray
    angles: FloatArray
    durations: FloatArray
    seconds: float

    def of(self, measure: str) -> FloatArray:
        """One measure of every reach, shape (reaches,)."""
        return np.asarray(self.scores[:, MEASURES.index(measure)])

    def by_subject(self, measure: str) -> dict[str, float]:
        """Mean of a measure over each person's reaches, where it can be taken."""
        values = self.of(measure)
        means = {}
        for subject in self.people.subjects:
            own = values[self.people.of(subject)]
            known = own[np.isfinite(own)]
            means[subject] = float(known.mean()) if known.size else float("nan")
        return means

    def mean(self, measure: str) -> float:
        """Mean over persons of the means over their reaches."""
        return float(np.mean(list(self.by_subject(measure).values())))


class Group(NamedTuple):
    """Some people, and how their reaches are left out."""

    people: People
    protocol: Protocol


def predict_all(
    groups: Sequence[Group], rows: Sequence[Row], workers: int | None, on_progress: Progress
) -> list[dict[str, Outcome]]:
    """Let every row predict every reach, and score it.

    Parameters
    ----------
    groups : sequence of Group
    rows : sequence of Row
        That can be had on this machine.
    workers : int or None
        Processes; results, but for the times, do not depend on it.
    on_progress : callable

    Returns
    -------
    list of dict of str to Outcome
        For each group, by the rows' keys and in their order, without rows that have nothing to
        learn from.
    """
    gathered: dict[_Key, _Gathered] = {}
    jobs, places = [], []
    for group in groups:
        new = [row for row in rows if _key(group, row) not in gathered]
        gathered |= {_key(group, row): _Gathered.of(group.people) for row in new}
        for family in _families(new):
            for part in _parts(group.people, family[0], group.protocol):
                jobs.append(_job(group.people, family, part))
                places.append(([gathered[_key(group, row)] for row in family], part.tests))
    for done, (number, found) in enumerate(each(_work, jobs, checked_workers(workers, len(jobs)))):
        for place, one in zip(places[number][0], found, strict=True):
            place.put(places[number][1], one)
        on_progress("reaches predicted", done + 1, len(jobs), jobs[number].rows[0].title)
    return [
        {
            row.key: gathered[_key(group, row)].outcome(row, *group)
            for row in rows
            if gathered[_key(group, row)].is_full
        }
        for group in groups
    ]


_Key = tuple[int, str, Protocol | None]


def _key(group: Group, row: Row) -> _Key:
    """Return what is predicted once: without folds to learn from they may be cut in any way."""
    protocol = group.protocol if row.lessons == "fold" else None
    return id(group.people), row.key, protocol


class _Gathered(NamedTuple):
    """What jobs of one row have come to so far."""

    scores: FloatArray
    angles: FloatArray
    durations: FloatArray
    seconds: FloatArray

    @classmethod
    def of(cls, people: People) -> _Gathered:
        count, phases, joints = people.examples.angles.shape
        shapes = (count, len(MEASURES)), (count, phases, joints), (count,), (count,)
        return cls(*(np.full(shape, np.nan) for shape in shapes))

    def put(self, tests: Sequence[int], done: _Done) -> None:
        rows = list(tests)
        self.scores[rows], self.angles[rows] = done.scores, done.angles
        self.durations[rows], self.seconds[rows] = done.durations, done.seconds

    def outcome(self, row: Row, people: People, protocol: Protocol) -> Outcome:
        seconds = float(self.seconds.mean())
        return Outcome(row, people, protocol, self.scores, self.angles, self.durations, seconds)

    @property
    def is_full(self) -> bool:
        """Whether there was something to learn from for every reach."""
        return bool(np.isfinite(self.seconds).all())


def _parts(people: People, row: Row, protocol: Protocol) -> Iterator[Fold]:
    """Folds by what the row may learn from: nothing where there are no such reaches."""
    if row.lessons == "fold":
        yield from (fold for fold in folds(people, protocol) if fold.train)
        return
    for fold in folds(people, "target"):
        place = people.examples.places[fold.tests[0]]
        if row.lessons == "own":
            yield fold._replace(train=fold.tests)
        elif row.lessons == "others":
            strangers = [who for who in people.subjects if who != fold.subject]
            train = tuple(one for who in strangers for one in people.of(who, place))
            if train:
                yield fold._replace(train=train)
        elif len(fold.tests) > FEWEST_REPEATS:
            for test in fold.tests:
                others = tuple(one for one in fold.tests if one != test)
                yield Fold(fold.subject, (test,), others)


def _families(rows: Sequence[Row]) -> list[tuple[Row, ...]]:
    """Rows that learn from the same, together."""
    shared = list(dict.fromkeys(row.shared for row in rows if row.shared))
    alone = [(row,) for row in rows if row.shared is None]
    return [*(tuple(row for row in rows if row.shared is one) for one in shared), *alone]


def _job(people: People, rows: tuple[Row, ...], fold: Fold) -> _Job:
    kept = people.only(fold.tests, fold.train)
    return _Job(rows, kept, len(fold.tests), people.profiles[fold.subject])


def _work(job: _Job) -> list[_Done]:
    examples = job.people.examples
    taught = examples.only(range(job.tests, examples.size))
    shared = job.rows[0].shared
    lesson = shared(taught) if shared else taught
    return [_tried(job, row.learn(lesson)) for row in job.rows]


def _tried(job: _Job, predictor: Predicts) -> _Done:
    people, tests = job.people, range(job.tests)
    asked = people.examples.only(tests)
    began = time.perf_counter()
    predicted = predictor.predict(asked.starts, asked.targets)
    seconds = (time.perf_counter() - began) / job.tests
    scores = np.array(
        [
            _score(people, row, predicted.angles[row], float(predicted.durations[row]), job.profile)
            for row in tests
        ]
    )
    return _Done(np.round(scores, DECIMALS), predicted.angles, predicted.durations, seconds)


def _score(
    people: People, row: int, angles: FloatArray, duration: float, profile: FloatArray
) -> FloatArray:
    captured, chain = people.captured[row], people.examples.chain
    rounding = 1e-9
    in_range = (angles >= chain.lower - rounding).all() and (angles <= chain.upper + rounding).all()
    found = score(
        captured,
        people.motion(row, angles, duration),
        people.motion(row, angles, captured.duration),
        people.examples.targets[row],
        profile,
        in_range=bool(in_range),
    )
    return np.array(found)
