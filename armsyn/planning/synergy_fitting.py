"""Fit synergies to the captured reaches of many places at once.

Captured reaches are followed over normalised time (`armsyn.synergy.phased`), in place and velocity
of all joints and the hand, each end led to its target as every prediction's is; targets count
alike, however often they were reached. One set that is common to all comes first: S_C from several
starts, freed to S_D where that is asked for. Then either a map, linear in the place and pulled
towards the common set, is fitted to all reaches as one; or each place gets its own set, pulled
towards the common one, and a field is laid through these.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain
from armsyn.planning.ending import ended_at
from armsyn.planning.examples import PHASES, Examples
from armsyn.planning.linear import with_one
from armsyn.planning.postures import tips
from armsyn.planning.workspace import (
    Field,
    InverseDistance,
    LinearField,
    Nearest,
    gaussian_process,
    thin_plate,
)
from armsyn.synergy.mapping import MapProblem, fit_map
from armsyn.synergy.phased import PhasedSynergies

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

FIELDS: dict[str, Callable[[FloatArray, FloatArray], Field] | None] = {
    "map": None,
    "common": None,
    "nearest": Nearest,
    "idw": InverseDistance,
    "rbf": thin_plate,
    "gp": gaussian_process,
}
"""``map`` (linear, fitted as one), ``common`` (one set everywhere), and what is laid through the
sets of places."""

STRIDE = 4
"""Every so many phases are looked at."""
PACE = 0.3
"""Of a whole reach: a gap between velocities counts as much as one between positions that it opens
in that time. With positions alone every joint takes its own sudden moment, and of 150 reaches of
human7 half had a second peak of speed; with it a fourteenth."""
HALVES_AND_SLOPES = ((0.2, 4.0), (0.3, 6.0), (0.3, 12.0), (0.45, 8.0))
"""Half-way moments and slopes over normalised time that the common set is looked for from."""
RIDGES = (0.3, 0.1, 0.03)
"""m."""
ONE_START_M = 0.1
"""Root mean square up to which the hand is taken to start at one place."""
FOLDS = 6
"""Into which places are parted, to leave one part out after the other."""
_STEPS, _FEW_STEPS, _SCREENING_STEPS = 40, 6, 12
_STILL_M = 1e-3


@dataclass(frozen=True)
class SynergyFits:
    """Captured reaches to be followed by one family of synergies.

    Parameters
    ----------
    examples : Examples
    family : PhasedSynergies
    rows : tuple of int
        Of the chain's positions that are compared.
    groups : array of int, shape (N,)
        Which person's which place each reach goes to.
    places : array, shape (N, k)
        Where the hand ends, and where it starts if that varies, m.
    """

    examples: Examples
    family: PhasedSynergies
    rows: tuple[int, ...]
    groups: IntArray
    places: FloatArray

    @staticmethod
    def of(examples: Examples, family: PhasedSynergies) -> SynergyFits:
        """Find out what is compared, and what places are told apart by."""
        pairs = list(zip(examples.subjects, examples.places, strict=True))
        known = list(dict.fromkeys(pairs))
        begins = tips(examples.chain, examples.starts)
        spread = np.sqrt(begins.var(axis=0).sum())
        parts = [examples.targets] + [begins] * bool(spread > ONE_START_M)
        return SynergyFits(
            examples,
            family,
            moving_points(examples.chain, examples.angles),
            np.array([known.index(pair) for pair in pairs]),
            np.concatenate(parts, axis=1),
        )

    def field(self, name: str, ridge: float | None) -> Field:
        """Return the coordinates over places.

        Parameters
        ----------
        name : str
            Of `FIELDS`.
        ridge : float or None
            m; chosen of `RIDGES` when None.
        """
        make = FIELDS[name]
        if make is not None:
            return self._through_places(make, ridge)
        slopes = np.zeros((self.places.shape[1], self.common.size))
        if name == "common":
            return LinearField(self._centre, self.common, slopes)
        fitted = self._map(self._best_map_ridge() if ridge is None else ridge)
        return LinearField(self._centre, fitted[0], fitted[1:] / self._scale[:, None])

    @cached_property
    def common(self) -> FloatArray:
        """One set for all, shape (P,)."""
        ones, none = np.ones((self.examples.size, 1)), np.zeros(1)
        simple = PhasedSynergies(self.family.chain, "C", self.family.duration, self.family.ik)
        problem = self._problem(ones, simple)
        best, found = np.inf, simple.middle
        for half, slope in HALVES_AND_SLOPES:
            first = simple.middle
            first[-2:] = half * simple.duration, np.log(slope / simple.duration)
            fitted = fit_map(problem, first[None], none, _SCREENING_STEPS)
            cost = float(problem.weights @ fitted.distances)
            if cost < best:
                best, found = cost, fitted.coefficients[0]
        found = fit_map(problem, found[None], none).coefficients[0]
        free = np.clip(found, simple.lower, simple.upper)[self.family.ties]
        return np.asarray(fit_map(self._problem(ones), free[None], none).coefficients[0])

    # a map fitted as one

    @property
    def _centre(self) -> FloatArray:
        return np.asarray(self.places.mean(axis=0))

    @property
    def _scale(self) -> FloatArray:
        return np.asarray(np.maximum(self.places.std(axis=0), _STILL_M))

    @cached_property
    def _features(self) -> FloatArray:
        return with_one((self.places - self._centre) / self._scale)

    def _map(self, ridge: float, kept: IntArray | None = None, steps: int = _STEPS) -> FloatArray:
        """Coefficients on the features, shape (1 + k, P)."""
        count = self._features.shape[1]
        first = np.zeros((count, self.common.size))
        first[0] = self.common
        ridges = np.where(np.arange(count) == 0, 0.0, ridge)
        return fit_map(self._problem(self._features, kept=kept), first, ridges, steps).coefficients

    def _best_map_ridge(self) -> float:
        def missed(ridge: float) -> float:
            total = 0.0
            for fold in range(FOLDS):
                left = np.flatnonzero(self.groups % FOLDS == fold)
                others = np.flatnonzero(self.groups % FOLDS != fold)
                fitted = self._map(ridge, others, _FEW_STEPS)
                total += float(self._distances(self._features[left] @ fitted, left).mean())
            return total

        return min(RIDGES, key=missed)

    # a set for each place, and a field through them

    def _through_places(
        self, make: Callable[[FloatArray, FloatArray], Field], ridge: float | None
    ) -> Field:
        """Lay a field through the places' sets; choose the ridge that serves places left out."""
        count = int(self.groups.max()) + 1
        middles = np.array([self.places[self.groups == g].mean(axis=0) for g in range(count)])
        sets = {one: self._sets(one) for one in (RIDGES if ridge is None else (ridge,))}

        def missed(candidate: float) -> float:
            total = 0.0
            for group in range(count):
                others, left = np.arange(count) != group, np.flatnonzero(self.groups == group)
                field = make(middles[others], sets[candidate][others])
                total += float(self._distances(field(self.places[left]), left).mean())
            return total

        best = min(sets, key=missed) if len(sets) > 1 else next(iter(sets))
        return make(middles, sets[best])

    def _sets(self, ridge: float) -> FloatArray:
        """A set for each place, shape (places, P)."""
        count = int(self.groups.max()) + 1
        first = np.repeat(self.common[None], count, axis=0)
        problem = self._problem(np.eye(count)[self.groups])
        fitted = fit_map(problem, first, np.full(count, ridge / count))
        return np.clip(fitted.coefficients, self.family.lower, self.family.upper)

    # what both play

    def _problem(
        self,
        features: FloatArray,
        family: PhasedSynergies | None = None,
        kept: IntArray | None = None,
    ) -> MapProblem:
        rows = np.arange(self.examples.size) if kept is None else kept
        playing = family or self.family
        weights = 1.0 / np.bincount(self.groups)[self.groups[rows]]
        return MapProblem(
            lambda coordinates, which: self._play(playing, coordinates, rows[which]),
            self._wanted[rows],
            features[rows],
            weights / weights.sum(),
            playing.lower,
            playing.upper,
        )

    @cached_property
    def _wanted(self) -> FloatArray:
        return self._points(self.examples.angles[:, ::STRIDE])

    def _play(
        self, family: PhasedSynergies, coordinates: FloatArray, which: IntArray
    ) -> FloatArray:
        starts, targets = self.examples.starts[which], self.examples.targets[which]
        free = family.play(coordinates, starts, targets, PHASES)
        angles, _ = ended_at(self.examples.chain, free, targets)
        return self._points(angles[:, ::STRIDE])

    def _points(self, angles: FloatArray) -> FloatArray:
        """Positions and velocities to be followed, shape (N, points, 3), m."""
        count, phases, n = angles.shape
        rows = list(self.rows)
        positions = self.examples.chain.positions(angles.reshape(-1, n))[:, rows]
        positions = positions.reshape(count, phases, len(rows), 3)
        velocities = np.diff(positions, axis=1) * (PACE * (PHASES - 1) / STRIDE)
        return np.concatenate([positions, velocities], axis=1).reshape(count, -1, 3)

    def _distances(self, coordinates: FloatArray, which: IntArray) -> FloatArray:
        """Mean gap of reaches played with parameters, shape (len(which),), m."""
        gaps = self._play(self.family, coordinates, which) - self._wanted[which]
        return np.asarray(np.linalg.norm(gaps, axis=2).mean(axis=1))


def moving_points(chain: SerialChain, angles: FloatArray) -> tuple[int, ...]:
    """Return which of a chain's positions move, each place once, the tip last.

    Parameters
    ----------
    chain : SerialChain
    angles : array, shape (N, phases, n)
        Of motions, rad or m.

    Returns
    -------
    tuple of int
        Rows of ``chain.positions``.
    """
    positions = chain.positions(angles.reshape(-1, chain.dof))
    rows: list[int] = []
    for row in reversed(range(chain.dof + 1)):
        is_still = np.abs(positions[:, row] - positions[0, row]).max() < _STILL_M
        same = (np.abs(positions[:, row] - positions[:, one]).max() < _STILL_M for one in rows)
        if not is_still and not any(same):
            rows.append(row)
    return tuple(rows[::-1])
