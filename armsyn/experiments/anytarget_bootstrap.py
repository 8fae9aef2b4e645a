"""Differences between two rows, paired by target within a person, with bootstrap intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from armsyn.experiments.anytarget_run import Outcome
from armsyn.motion import FloatArray

RESAMPLES = 10_000
LEVEL = 0.95


class Interval(NamedTuple):
    """A mean with a percentile bootstrap interval of `LEVEL`."""

    mean: float
    low: float
    high: float

    @property
    def verdict(self) -> str:
        """Ahead when the interval lies above zero, behind when below, else undecided."""
        if self.low > 0:
            return "ahead"
        return "behind" if self.high < 0 else "undecided"


def target_differences(first: Outcome, second: Outcome, measure: str = "held") -> list[FloatArray]:
    """Return by how much the second is larger than the first.

    Parameters
    ----------
    first, second : Outcome
        Of the same people.
    measure : str
        A field of `Score`.

    Returns
    -------
    list of array, each of shape (targets,)
        One a person: the mean over the reaches to each target that both predicted.
    """
    people, gaps = first.people, second.of(measure) - first.of(measure)
    found = []
    for subject in people.subjects:
        each = [gaps[people.of(subject, place)] for place in people.places_of(subject)]
        known = [gap[np.isfinite(gap)] for gap in each]
        found.append(np.array([gap.mean() for gap in known if gap.size]))
    return [person for person in found if person.size]


def interval(groups: Sequence[FloatArray], seed: int) -> Interval:
    """Mean over persons of their means over targets, targets drawn again within each person.

    Parameters
    ----------
    groups : sequence of array, each of shape (targets,)
        One a person, at least one.
    seed : int

    Returns
    -------
    Interval

    References
    ----------
    Efron and Tibshirani, An Introduction to the Bootstrap (1993), chapter 13; strata by person.
    """
    rng = np.random.default_rng(seed)
    drawn = [
        group[rng.integers(group.size, size=(RESAMPLES, group.size))].mean(axis=1)
        for group in groups
    ]
    low, high = np.quantile(np.mean(drawn, axis=0), [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(float(np.mean([group.mean() for group in groups])), float(low), float(high))
