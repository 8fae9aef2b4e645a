"""How well a set learned for one reach serves others of the same person, and how few sets do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from armsyn.experiments.learned import FloatArray, Learned, Progress
from armsyn.experiments.selections import Prepared
from armsyn.motion import Motion
from armsyn.scoring.distance import held_distance
from armsyn.scoring.pairing import pair_up, trim
from armsyn.synergy.training import Training

BoolArray = NDArray[np.bool_]
LONGER = 2.0
"""A set is played for so many times its capture's duration: its pace is its own."""
SERVES = 1.5
"""Human floors up to which a set is said to serve a target."""
SERVES_M = 0.05
"""The same where there is no floor, m."""


@dataclass(frozen=True)
class Served:
    """One person's sets of parameters, each used on every reach of that person.

    Parameters
    ----------
    bounds : str
        What the sets were bounded by.
    learned : Learned
        One set a row.
    reaches : Prepared
        The reaches that they are used on; those learned from are among them.
    distances : array, shape (sets, reaches)
        Held distance of the played motion to the captured one, m.
    floors : array, shape (targets,) or None
        Human floor of each target, mean over its reaches, m.
    """

    bounds: str
    learned: Learned
    reaches: Prepared
    distances: FloatArray
    floors: FloatArray | None

    @property
    def title(self) -> str:
        """Who."""
        return self.reaches.selection.title

    @cached_property
    def targets(self) -> list[str]:
        """Every target once, in the order of the reaches."""
        return targets_of(self.reaches)

    @cached_property
    def positions(self) -> FloatArray:
        """Where each target is on the mean, shape (targets, 3), m."""
        ends = np.array([training.target for training in self.reaches.trainings])
        return np.array([ends[_at(self.reaches, place)].mean(axis=0) for place in self.targets])

    @cached_property
    def own(self) -> list[int]:
        """Column of the target that each set was learned at."""
        return [self.targets.index(place_of(name)) for name in self.learned.prepared.names]

    @cached_property
    def apart(self) -> FloatArray:
        """From the target that a set was learned at to each target, shape (sets, targets), m."""
        return np.asarray(
            np.linalg.norm(self.positions[self.own][:, None] - self.positions, axis=2)
        )

    @cached_property
    def means(self) -> FloatArray:
        """Mean held distance over a target's reaches, shape (sets, targets), m.

        Without the reach that a set was learned from; NaN where it is a target's only one.
        """
        names = np.array(self.reaches.names)
        is_own = np.array([names == name for name in self.learned.prepared.names])
        totals, counts = (
            np.stack([part[:, _at(self.reaches, place)].sum(axis=1) for place in self.targets], 1)
            for part in (np.where(is_own, 0.0, self.distances), ~is_own)
        )
        return np.where(counts > 0, totals / np.maximum(counts, 1), np.nan)

    @cached_property
    def judged(self) -> FloatArray:
        """`means`, or a set's distance to its own reach where that is the target's only one."""
        lone = np.array(
            [
                self.distances[row, self.reaches.names.index(name)]
                for row, name in enumerate(self.learned.prepared.names)
            ]
        )
        return np.where(np.isnan(self.means), lone[:, None], self.means)

    @property
    def usual_tolerance(self) -> float:
        """Up to which a set is said to serve: in floors, or in m where there is none."""
        return SERVES_M if self.floors is None else SERVES

    def serves(self, tolerance: float) -> BoolArray:
        """Whether each set serves each target.

        Parameters
        ----------
        tolerance : float
            In human floors, or in m where there are none.

        Returns
        -------
        array of bool, shape (sets, targets)
        """
        limits = tolerance if self.floors is None else tolerance * self.floors
        return np.asarray(self.judged <= limits)

    def fewest(self, tolerance: float) -> list[int]:
        """Return the rows of the fewest sets that serve all that any set serves."""
        return fewest_sets(self.serves(tolerance), self.judged.mean(axis=1))


def place_of(name: str) -> str:
    """Target in a capture's name: its last part."""
    return name.rpartition(":")[2]


def targets_of(reaches: Prepared) -> list[str]:
    """Every target once, in the order of the reaches."""
    return list(dict.fromkeys(map(place_of, reaches.names)))


def _at(reaches: Prepared, place: str) -> BoolArray:
    """Whether each reach goes to a target."""
    return np.array([place_of(name) == place for name in reaches.names])


def serve(
    bounds: str,
    learned: Learned,
    reaches: Prepared,
    floors: Mapping[str, float],
    on_progress: Progress,
    stage: str,
) -> Served:
    """Use every set on every reach.

    Parameters
    ----------
    bounds : str
        What the sets were bounded by.
    learned : Learned
    reaches : Prepared
        On the same arm at the same rate, those learned from among them.
    floors : mapping of str to float
        Human floor of each reach, m; empty when there are none.
    on_progress : callable
    stage : str
        Its name in the progress.

    Returns
    -------
    Served
    """
    captured = [_as_motion(training, training.landmarks) for training in reaches.trainings]
    distances = np.empty((len(learned.distances), len(captured)))
    for row in range(len(distances)):
        for column, training in enumerate(reaches.trainings):
            played = _as_motion(training, learned.play(row, training, LONGER))
            distances[row, column] = held_distance(trim(pair_up(captured[column], played)))
        on_progress(stage, row + 1, len(distances), "")
    each = np.array([floors[name] for name in reaches.names]) if floors else None
    by_target = (
        None
        if each is None
        else np.array([each[_at(reaches, place)].mean() for place in targets_of(reaches)])
    )
    return Served(bounds, learned, reaches, distances, by_target)


def _as_motion(training: Training, landmarks: FloatArray) -> Motion:
    return Motion(
        time=np.arange(len(landmarks)) * training.time[1],
        landmark_names=training.capture.motion.landmark_names,
        landmarks=landmarks,
        source=training.capture.name,
    )


def fewest_sets(serves: BoolArray, worth: FloatArray) -> list[int]:
    """Return the fewest sets that together serve every target that any of them serves.

    Set cover, solved exactly as an integer program: minimise the number of chosen sets so that
    each target is served by one chosen set at least (Karp 1972, problem 6).

    Parameters
    ----------
    serves : array of bool, shape (sets, targets)
    worth : array, shape (sets,)
        Between equally few sets those with the least sum of it are taken; not negative.

    Returns
    -------
    list of int
        Rows of the chosen sets.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp  # noqa: PLC0415  heavy

    coverable = serves[:, serves.any(axis=0)].T.astype(np.float64)
    if not coverable.size:
        return []
    # The second term is below 1 for all sets together: it only decides between equals
    cost = 1.0 + 0.5 * worth / max(float(worth.sum()), np.finfo(float).tiny)
    found = milp(
        cost,
        integrality=np.ones(len(serves), dtype=np.int64),
        bounds=Bounds(0, 1),
        constraints=LinearConstraint(coverable, lb=1),
    )
    assert found.x is not None, found.message  # noqa: S101 - every column has a set that serves it
    return [int(row) for row in np.flatnonzero(found.x > 0.5)]
