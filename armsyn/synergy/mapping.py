"""Fit parameters of many motions at once, as a regularised linear map from features of each.

What is minimised is the mean over motions of the paper's distance (the mean norm of the gaps
between landmarks), plus ridges: ``sum_k ridge_k |B_k - B0_k|^2`` over the rows B_k of the map
``parameters = features @ B``, lengths counted in shares of the parameters' ranges. With a lone
feature of 1 that is one set for all; with one feature a motion it is a set for each, regularised
towards the set of all; with a place's coordinates it is a map over the workspace.

Gauss and Newton's steps on reweighted squares (as `armsyn.synergy.least_squares`), damped
(Levenberg 1944, Marquardt 1963). Motions are differentiated by their own few parameters, whatever
the number of features.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Play = Callable[[FloatArray, IntArray], FloatArray]
"""From parameters, shape (lanes, P), and the motion that each lane plays, shape (lanes,), to its
landmarks, shape (lanes, points, 3), m."""

DIFFERENCE = 1e-3
"""Step of the finite differences, as a share of a parameter's range."""
LEAST_GAP_M = 1e-4
LONGEST_STEP = 0.3
"""Of a parameter's range, for any motion."""
OUTSIDE = 0.3
"""m: what a range beyond the bounds costs, squared, so that the map comes back into them."""
STEPS = 40
FALL_M = 2e-6
"""A step that lowers the mean distance by less is the last."""
_FIRST_DAMPING, _TRIES = 1e-2, 8


@dataclass(frozen=True)
class MapProblem:
    """Motions to be followed by one map.

    Parameters
    ----------
    play : callable
        `Play`.
    wanted : array, shape (motions, points, 3)
        Captured landmarks, m.
    features : array, shape (motions, features)
    weights : array, shape (motions,)
        Of the motions in the mean; they sum to 1.
    lower, upper : array, shape (P,)
        Bounds of the parameters; `play` keeps within them what lies outside.
    """

    play: Play
    wanted: FloatArray
    features: FloatArray
    weights: FloatArray
    lower: FloatArray
    upper: FloatArray


class FittedMap(NamedTuple):
    """What was found.

    Attributes
    ----------
    coefficients : array, shape (features, P)
    distances : array, shape (motions,)
        Mean gap of each motion, m: training errors.
    """

    coefficients: FloatArray
    distances: FloatArray


def fit_map(
    problem: MapProblem, first: FloatArray, ridges: FloatArray, steps: int = STEPS
) -> FittedMap:
    """Fit a map.

    Parameters
    ----------
    problem : MapProblem
    first : array, shape (features, P)
        Coefficients to start from, which the ridges pull towards.
    ridges : array, shape (features,)
        m; 0 leaves a row free.
    steps : int
        At most.

    Returns
    -------
    FittedMap
    """
    descent = _Descent(problem, first, ridges)
    for _ in range(steps):
        if descent.step() < FALL_M:
            break
    return FittedMap(descent.coefficients, descent.distances)


class _Descent:
    def __init__(self, problem: MapProblem, first: FloatArray, ridges: FloatArray) -> None:
        self._problem, self._first, self._ridges = problem, first, ridges
        self._width = problem.upper - problem.lower
        self._damping = _FIRST_DAMPING
        self.coefficients = first.copy()
        self._gaps = self._gaps_of(first)
        self._cost = self._cost_of(first, self._gaps)

    @property
    def distances(self) -> FloatArray:
        """Mean gap of each motion, m."""
        return np.asarray(np.linalg.norm(self._gaps, axis=2).mean(axis=1))

    def step(self) -> float:
        """Make one step; return by how much the cost fell, 0 where no step lowers it."""
        curvature, slope = self._normal_equations()
        scale = np.tile(self._width**-2, len(self._first))
        for _ in range(_TRIES):
            damped = curvature + np.diag(self._damping * scale)
            change = -np.linalg.solve(damped, slope).reshape(self._first.shape)
            reach = np.abs(self._problem.features @ change / self._width).max()
            trial = self.coefficients + change * min(1.0, LONGEST_STEP / max(reach, 1e-12))
            gaps = self._gaps_of(trial)
            cost = self._cost_of(trial, gaps)
            if cost < self._cost:
                fall, self._cost = self._cost - cost, cost
                self.coefficients, self._gaps = trial, gaps
                self._damping = max(self._damping / 5, 1e-10)
                return fall
            self._damping *= 5
        return 0.0

    def _parameters(self, coefficients: FloatArray) -> FloatArray:
        return np.asarray(self._problem.features @ coefficients)

    def _gaps_of(self, coefficients: FloatArray) -> FloatArray:
        every = np.arange(len(self._problem.wanted))
        return self._problem.play(self._parameters(coefficients), every) - self._problem.wanted

    def _beyond(self, coefficients: FloatArray) -> FloatArray:
        """How far each motion's parameters lie outside their bounds, in ranges."""
        parameters = self._parameters(coefficients)
        inside = np.clip(parameters, self._problem.lower, self._problem.upper)
        return np.asarray((parameters - inside) / self._width)

    def _cost_of(self, coefficients: FloatArray, gaps: FloatArray) -> float:
        weights, beyond = self._problem.weights, self._beyond(coefficients)
        moved = (coefficients - self._first) / self._width
        return float(
            weights @ np.linalg.norm(gaps, axis=2).mean(axis=1)
            + OUTSIDE * weights @ (beyond**2).sum(axis=1)
            + self._ridges @ (moved**2).sum(axis=1)
        )

    def _normal_equations(self) -> tuple[FloatArray, FloatArray]:
        """Curvature and slope of the cost by the coefficients, row after row."""
        problem, (features, P) = self._problem, self._first.shape
        J, gaps = self._derivatives(), self._gaps
        lengths = np.maximum(np.linalg.norm(gaps, axis=2), LEAST_GAP_M)
        shares = problem.weights[:, None] / (gaps.shape[1] * lengths)
        weighted = J * shares[:, None, :, None]
        count = len(gaps)
        curvature = weighted.reshape(count, P, -1) @ J.reshape(count, P, -1).transpose(0, 2, 1)
        slope = (weighted.reshape(count, P, -1) @ gaps.reshape(count, -1, 1))[..., 0]
        beyond = self._beyond(self.coefficients)
        stiff = 2 * OUTSIDE * problem.weights[:, None]
        curvature += np.eye(P) * (stiff * (beyond != 0) / self._width**2)[:, None]
        slope += stiff * beyond / self._width
        X = problem.features
        whole = np.einsum("mpq,mj,mk->jpkq", curvature, X, X, optimize=True)
        whole = whole.reshape(features * P, features * P)
        pull = 2 * self._ridges[:, None] / self._width**2
        steep = X.T @ slope + pull * (self.coefficients - self._first)
        return whole + np.diag(pull.ravel()), steep.ravel()

    def _derivatives(self) -> FloatArray:
        """Of the landmarks by the motions' own parameters, shape (motions, P, points, 3)."""
        problem = self._problem
        at = self._parameters(self.coefficients)
        inside = np.clip(at, problem.lower, problem.upper)
        count, P = at.shape
        steps = (
            DIFFERENCE
            * self._width
            * np.where(inside + DIFFERENCE * self._width > problem.upper, -1, 1)
        )
        moved = np.repeat(inside[:, None], P, axis=1) + steps[:, :, None] * np.eye(P)
        which = np.repeat(np.arange(count), P)
        played = problem.play(moved.reshape(-1, P), which).reshape(count, P, -1, 3)
        now = (self._gaps + problem.wanted)[:, None]
        # outside its bounds a parameter changes nothing
        slopes = (played - now) / steps[:, :, None, None]
        return np.asarray(slopes * (at == inside)[:, :, None, None])
