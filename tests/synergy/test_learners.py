"""The other learners on problems whose minimum is known, and what they all keep to."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import minimize

from armsyn.errors import InputError
from armsyn.synergy.evaluation import BudgetSpentError, Evaluator, Problem
from armsyn.synergy.evolution import adapt_covariance, evolve
from armsyn.synergy.least_squares import _Weighted, multistart
from tests.synergy.bowls import LEFT, LOWER, MINIMUM, UPPER, WIDTH, bowl, evaluator

LEARNERS = {"least-squares": multistart, "cma": adapt_covariance, "evolution": evolve}
each_learner = pytest.mark.parametrize("learn", LEARNERS.values(), ids=LEARNERS)


def draws(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def outliers(seed: int = 0) -> Problem:
    """Gaps linear in the parameters, most of them small and some far off: a mean of norms."""
    generator = draws(seed)
    slopes = generator.normal(size=(40, 3, 4))
    apart = 0.01 * generator.normal(size=(40, 3)) + (generator.random(40) < 0.2)[:, None] * 3.0

    def gaps(parameters: np.ndarray) -> np.ndarray:
        shares = (parameters - MINIMUM) / WIDTH
        return np.einsum("pki,li->lpk", slopes, shares) + apart

    def distances(parameters: np.ndarray) -> np.ndarray:
        return np.linalg.norm(gaps(parameters), axis=2).mean(axis=1)

    return Problem(distances, gaps, LOWER, UPPER, np.arange(4))


@each_learner
@pytest.mark.parametrize("minimum", [MINIMUM, [-4.0, 18.0, 9.0, -0.9], [0.0, 10.0, 5.0, 0.0]])
def test_the_bottom_of_a_bowl_is_found(learn, minimum: list[float]) -> None:
    looked = evaluator(900, np.array(minimum))
    found = learn(looked, draws())
    assert np.abs((looked.best - minimum) / WIDTH).max() < 0.01
    assert LEFT <= looked.best_score < LEFT + 1e-3
    assert looked.best_score <= found.scores.min()


@each_learner
def test_a_minimum_outside_the_bounds_is_met_on_them(learn) -> None:
    looked = evaluator(900, np.array([9.0, -3.0, 5.0, 0.0]))
    learn(looked, draws())
    assert looked.best[:2] == pytest.approx([5.0, 0.0], abs=0.02)


@each_learner
@pytest.mark.parametrize("budget", [1, 2, 3, 7, 20, 61, 200])
def test_no_budget_is_overdrawn_and_nothing_leaves_the_bounds(learn, budget: int) -> None:
    problem, seen = bowl(), []

    def watched(function):
        def call(parameters: np.ndarray) -> np.ndarray:
            seen.append(parameters)
            return function(parameters)

        return call

    problem = dataclasses.replace(
        problem, distances=watched(problem.distances), residuals=watched(problem.residuals)
    )
    looked = Evaluator(problem, budget)
    found = learn(looked, draws())
    tried = np.concatenate(seen)
    assert looked.spent == len(tried) <= budget
    assert (tried >= LOWER).all()
    assert (tried <= UPPER).all()
    assert looked.best_score == pytest.approx(bowl().distances(tried).min())
    assert (found.members >= LOWER).all()
    assert (found.members <= UPPER).all()


@each_learner
def test_a_seed_decides_everything(learn) -> None:
    scores = []
    for seed in (3, 3, 4):
        looked = Evaluator(outliers(), 150)
        scores.append(learn(looked, draws(seed)).scores)
    np.testing.assert_array_equal(scores[0], scores[1])
    assert not np.array_equal(scores[0], scores[2])


@each_learner
def test_members_keep_their_scores(learn) -> None:
    found = learn(Evaluator(outliers(), 400), draws())
    np.testing.assert_allclose(found.scores, outliers().distances(found.members), rtol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_reweighting_minimises_the_mean_of_norms_not_of_squares(seed: int) -> None:
    """Against a general minimiser of the mean; plain least squares is drawn to the outliers."""
    problem = outliers(seed)
    looked = Evaluator(problem, 600)
    multistart(looked, draws())
    bounds = list(zip(LOWER, UPPER, strict=True))
    least = min(
        minimize(
            lambda p: problem.distances(p[None])[0],
            start,
            bounds=bounds,
            method="Nelder-Mead",
            options={"maxiter": 4000, "xatol": 1e-9, "fatol": 1e-12},
        ).fun
        for start in (MINIMUM, looked.best)
    )
    assert looked.best_score == pytest.approx(least, rel=2e-3)
    squares = minimize(lambda p: (problem.residuals(p[None]) ** 2).sum(), MINIMUM, bounds=bounds).x
    assert looked.best_score < 0.95 * problem.distances(squares[None])[0]


def test_squeezed_residuals_have_the_same_normal_equations() -> None:
    looked = Evaluator(outliers(), 1000)
    at, ties = np.array([0.3, 0.6, 0.2, 0.9]), np.arange(4)
    weighted = _Weighted(looked, at, ties)
    r, J = weighted.residuals(at), weighted.jacobian(at)
    gaps = outliers().residuals(outliers().at(at)[None])[0]
    roots = 1.0 / np.sqrt(np.linalg.norm(gaps, axis=1))[:, None]

    def long(shares: np.ndarray) -> np.ndarray:
        return (outliers().residuals(outliers().at(shares)[None])[0] * roots).ravel()

    steps = 1e-6 * np.eye(4)
    slopes = np.array([(long(at + h) - long(at - h)) / 2e-6 for h in steps]).T
    assert r @ r == pytest.approx(long(at) @ long(at))
    assert r @ r == pytest.approx(np.linalg.norm(gaps, axis=1).sum())  # the mean of norms
    np.testing.assert_allclose(J.T @ r, slopes.T @ long(at), rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(J.T @ J, slopes.T @ slopes, rtol=1e-6, atol=1e-8)


def test_a_tied_start_is_never_worse_than_the_simpler_model() -> None:
    """Two parameters that are one in the simpler model: freed, they only get better."""
    free = dataclasses.replace(bowl(np.array([1.0, 5.0, 2.0, 0.3])), ties=np.array([0, 1, 1, 2]))
    tied = dataclasses.replace(
        free,
        distances=lambda p: free.distances(p[:, [0, 1, 1, 2]]),
        residuals=lambda p: free.residuals(p[:, [0, 1, 1, 2]]),
        lower=LOWER[[0, 1, 3]],
        upper=UPPER[[0, 1, 3]],
        ties=np.arange(3),
    )
    scores = []
    for problem in (tied, free):
        looked = Evaluator(dataclasses.replace(problem), 500)
        multistart(looked, draws())
        scores.append(looked.best_score)
    assert scores[1] < scores[0]


def test_an_evaluator_counts_and_remembers() -> None:
    looked = Evaluator(bowl(), 10)
    looked.scores(np.array([LOWER, MINIMUM, UPPER]))
    assert (looked.spent, looked.left) == (3, 7)
    np.testing.assert_array_equal(looked.best, MINIMUM)
    assert looked.history == [(3, looked.best_score)]
    looked.residuals(np.array([UPPER] * 7))
    assert looked.history == [(3, looked.best_score)]
    with pytest.raises(BudgetSpentError):
        looked.scores(MINIMUM[None])
    assert looked.spent == 10
    with pytest.raises(InputError, match="at least one evaluation"):
        Evaluator(bowl(), 0)
