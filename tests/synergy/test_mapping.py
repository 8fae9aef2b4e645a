"""Maps fitted to motions of known parameters: found again, pulled by ridges, kept within bounds."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

from armsyn.synergy.mapping import MapProblem, fit_map

FloatArray = NDArray[np.float64]
RANDOM = np.random.default_rng(3)
MOTIONS, POINTS = 12, 20
OUTLINES = RANDOM.normal(0.0, 0.1, (MOTIONS, 2, POINTS, 3))
BENT = RANDOM.normal(0.0, 0.1, (MOTIONS, POINTS, 3))
NOISE = RANDOM.normal(0.0, 0.05, (MOTIONS, POINTS, 3))
LOWER, UPPER = np.array([-2.0, -1.0]), np.array([2.0, 3.0])


def play(parameters: FloatArray, which: NDArray[np.int64]) -> FloatArray:
    """Landmarks that depend smoothly, not linearly, on two parameters kept within bounds."""
    p = np.clip(parameters, LOWER, UPPER)
    straight = np.einsum("lp,lpkx->lkx", p, OUTLINES[which])
    return np.asarray(straight + np.sin(p[:, :1, None] * p[:, 1:, None]) * BENT[which])


def problem(features: FloatArray, truth: FloatArray, noise: float = 0.0) -> MapProblem:
    wanted = play(features @ truth, np.arange(MOTIONS)) + noise * NOISE
    weights = np.full(MOTIONS, 1.0 / MOTIONS)
    return MapProblem(play, wanted, features, weights, LOWER, UPPER)


def cost(problem: MapProblem, B: FloatArray, first: FloatArray, ridges: FloatArray) -> float:
    """The cost as its definition says."""
    gaps = problem.play(problem.features @ B, np.arange(MOTIONS)) - problem.wanted
    moved = (B - first) / (UPPER - LOWER)
    return float(np.linalg.norm(gaps, axis=2).mean() + ridges @ (moved**2).sum(axis=1))


def test_one_set_and_a_map_are_found_again() -> None:
    ones = np.ones((MOTIONS, 1))
    truth = np.array([[0.6, 1.2]])
    found = fit_map(problem(ones, truth), np.zeros((1, 2)), np.zeros(1))
    assert found.coefficients == pytest.approx(truth, abs=1e-3)
    assert found.distances.max() < 1e-4
    features = np.concatenate([ones, RANDOM.normal(0.0, 1.0, (MOTIONS, 2))], axis=1)
    slopes = np.array([[0.6, 1.2], [0.1, -0.2], [-0.15, 0.1]])
    found = fit_map(problem(features, slopes), np.zeros((3, 2)), np.zeros(3))
    assert found.coefficients == pytest.approx(slopes, abs=5e-3)


def test_the_end_is_the_least_of_the_cost_as_it_is_defined() -> None:
    features = np.concatenate([np.ones((MOTIONS, 1)), RANDOM.normal(0, 1, (MOTIONS, 1))], axis=1)
    asked = problem(features, np.array([[0.6, 1.2], [0.3, -0.2]]), noise=1.0)
    first, ridges = np.array([[0.5, 1.0], [0.0, 0.0]]), np.array([0.0, 0.5])
    found = fit_map(asked, first, ridges).coefficients

    def of(x: FloatArray) -> float:
        return cost(asked, x.reshape(2, 2), first, ridges)

    closely = {"xatol": 1e-6, "fatol": 1e-9, "maxiter": 4000.0}
    best = minimize(of, found.ravel(), method="Nelder-Mead", options=closely)  # type: ignore[call-overload]
    assert cost(asked, found, first, ridges) < best.fun + 5e-6


def test_a_ridge_pulls_each_motions_set_towards_the_common_one() -> None:
    own = np.column_stack([RANDOM.uniform(0.2, 0.8, MOTIONS), RANDOM.uniform(0.8, 1.6, MOTIONS)])
    asked = problem(np.eye(MOTIONS), own, noise=1.0)
    common = np.repeat(own.mean(axis=0)[None], MOTIONS, axis=0)

    def spread(ridge: float) -> float:
        found = fit_map(asked, common, np.full(MOTIONS, ridge / MOTIONS)).coefficients
        return float(np.abs(found - common).mean())

    free = spread(0.0)
    assert spread(3.0) < 0.8 * spread(0.3) < 0.9 * free
    assert spread(1e4) < 1e-3 * free


def test_a_best_set_beyond_the_bounds_ends_at_them() -> None:
    ones = np.ones((MOTIONS, 1))
    wanted = np.einsum("p,mpkx->mkx", [3.5, 0.0], OUTLINES)
    weights = np.full(MOTIONS, 1.0 / MOTIONS)
    asked = MapProblem(play, wanted, ones, weights, LOWER, UPPER)
    found = fit_map(asked, np.zeros((1, 2)), np.zeros(1)).coefficients
    assert found[0, 0] == pytest.approx(UPPER[0], abs=0.02)
