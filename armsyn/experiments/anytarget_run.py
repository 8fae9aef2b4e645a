"""Predict and score every reach of the experiment `anytarget`, over several processes."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armsyn.experiments.anytarget_people import Fold, People, Protocol, folds
from armsyn.experiments.anytarget_rows import Row
from armsyn.experiments.anytarget_scores import MEASURES, score
from armsyn.experiments.learned import Progress
from armsyn.motion import FloatArray
from armsyn.synergy.parallel import checked_workers, each

TITLES: dict[Protocol, str] = {
    "target": "leave one target out, within a person",
    "subject": "leave one person out",
}


class _Job(NamedTuple):
    """Reaches that one row predicts by what it learns from others."""

    row: Row
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

    @property
    def is_known(self) -> bool:
        """Whether there was anything to learn from for every reach."""
        return bool(np.isfinite(self.seconds) and np.isfinite(self.durations).all())

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


def predict_all(
    people: People,
    protocol: Protocol,
    rows: Sequence[Row],
    workers: int | None,
    on_progress: Progress,
) -> dict[str, Outcome]:
    """Let every row predict every reach, and score it.

    Parameters
    ----------
    people : People
    protocol : {"target", "subject"}
    rows : sequence of Row
        That can be had on this machine.
    workers : int or None
        Processes; results, but for the times, do not depend on it.
    on_progress : callable

    Returns
    -------
    dict of str to Outcome
        By the rows' keys, in their order.
    """
    places = folds(people, "target")
    jobs, rows_of = [], []
    for row in rows:
        # What does not learn from the fold is the same however folds are cut
        for fold in folds(people, protocol) if row.lessons == "fold" else places:
            for part in _parts(people, row, fold):
                jobs.append(_job(people, row, part))
                rows_of.append((row.key, part.tests))
    stage = f"{people.title}: {TITLES[protocol]}"
    empty = {row.key: _Gathered.of(people) for row in rows}
    for done, (number, found) in enumerate(each(_work, jobs, checked_workers(workers, len(jobs)))):
        key, tests = rows_of[number]
        empty[key].put(tests, found)
        on_progress(stage, done + 1, len(jobs), key)
    return {row.key: empty[row.key].outcome(row, people, protocol) for row in rows}


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
        known = self.seconds[np.isfinite(self.seconds)]
        seconds = float(known.mean()) if known.size else float("nan")
        return Outcome(row, people, protocol, self.scores, self.angles, self.durations, seconds)


def _parts(people: People, row: Row, fold: Fold) -> Iterator[Fold]:
    """Split a fold by what the row may learn from; nothing where there are no such reaches."""
    if row.lessons == "fold":
        if fold.train:
            yield fold
        return
    place = people.examples.places[fold.tests[0]]
    if row.lessons == "own":
        yield fold._replace(train=fold.tests)
    elif row.lessons == "others":
        strangers = [who for who in people.subjects if who != fold.subject]
        train = tuple(one for who in strangers for one in people.of(who, place))
        if train:
            yield fold._replace(train=train)
    elif len(fold.tests) > 2:  # a mean of at least two, as the human floor's
        for test in fold.tests:
            others = tuple(one for one in fold.tests if one != test)
            yield Fold(fold.subject, (test,), others)


def _job(people: People, row: Row, fold: Fold) -> _Job:
    kept = people.only(fold.tests, fold.train)
    return _Job(row, kept, len(fold.tests), people.profiles[fold.subject])


def _work(job: _Job) -> _Done:
    people, tests = job.people, range(job.tests)
    examples = people.examples
    taught = examples.only(range(job.tests, examples.size))
    predictor = job.row.learn(taught)
    asked = examples.only(tests)
    began = time.perf_counter()
    predicted = predictor.predict(asked.starts, asked.targets)
    seconds = (time.perf_counter() - began) / job.tests
    scores = np.array(
        [
            _score(people, row, predicted.angles[row], float(predicted.durations[row]), job.profile)
            for row in tests
        ]
    )
    return _Done(scores, predicted.angles, predicted.durations, seconds)


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
