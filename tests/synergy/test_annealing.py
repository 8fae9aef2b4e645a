"""Annealing on objectives whose minimum is known."""

import dataclasses

import numpy as np
import pytest

from armsyn.errors import InputError
from armsyn.synergy.annealing import Schedule, anneal, anneal_once
from armsyn.synergy.evaluation import Evaluator, Problem
from tests.synergy.bowls import LEFT, LOWER, MINIMUM, UPPER, WIDTH, bowl, evaluator

QUICK = Schedule(population=16, generations=200, patience=50, max_generations=600)


def draws(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def watched(problem: Problem, budget: int) -> tuple[Evaluator, list[np.ndarray]]:
    """Return an evaluator and the batches that it will have been asked for."""
    seen: list[np.ndarray] = []

    def distances(parameters: np.ndarray) -> np.ndarray:
        seen.append(parameters)
        return problem.distances(parameters)

    return Evaluator(dataclasses.replace(problem, distances=distances), budget), seen


@pytest.mark.parametrize("minimum", [MINIMUM, [-4.0, 18.0, 9.0, -0.9], [0.0, 10.0, 5.0, 0.0]])
def test_the_bottom_of_a_bowl_is_found(minimum: list[float]) -> None:
    looked = evaluator(QUICK.evaluations, np.array(minimum))
    found = anneal_once(looked, draws(), QUICK)
    assert np.abs((looked.best - minimum) / WIDTH).max() < 0.01
    assert LEFT <= looked.best_score < LEFT + 0.01
    assert looked.best_score <= found.scores.min()
    assert looked.spent < QUICK.evaluations  # it was stable


def test_a_minimum_outside_the_bounds_is_met_on_them() -> None:
    looked, seen = watched(bowl(np.array([9.0, -3.0, 5.0, 0.0])), 10_000)
    anneal_once(looked, draws(), QUICK)
    assert looked.best[:2] == pytest.approx([5.0, 0.0], abs=0.05)
    tried = np.concatenate(seen)
    assert (tried >= LOWER).all()
    assert (tried <= UPPER).all()


def test_valleys_do_not_trap_the_whole_population() -> None:
    """A bowl with ripples ten times steeper than itself: one descent ends in the next ripple."""

    def rippled(parameters: np.ndarray) -> np.ndarray:
        share = (parameters - MINIMUM) / WIDTH
        return np.sqrt((share**2 + 0.02 * (1 - np.cos(30 * share))).sum(axis=1))

    looked = Evaluator(dataclasses.replace(bowl(), distances=rippled), QUICK.evaluations)
    anneal(looked, draws(), QUICK)
    assert np.abs((looked.best - MINIMUM) / WIDTH).max() < 0.02


def test_a_seed_decides_everything() -> None:
    once, again, other = (
        anneal_once(evaluator(QUICK.evaluations), draws(seed), QUICK) for seed in (3, 3, 4)
    )
    np.testing.assert_array_equal(once.members, again.members)
    assert not np.array_equal(once.members, other.members)


def test_members_keep_their_scores() -> None:
    looked = evaluator(QUICK.evaluations)
    found = anneal(looked, draws(), QUICK)
    np.testing.assert_array_equal(found.scores, looked.problem.distances(found.members))


def test_a_population_that_is_stable_starts_again_while_the_budget_lasts() -> None:
    alone, again = evaluator(100_000), evaluator(30_000)
    anneal_once(alone, draws(), QUICK)
    anneal(again, draws(), QUICK)
    assert alone.spent < 15_000
    assert 30_000 - again.spent < 2 * QUICK.population
    assert again.best_score <= alone.best_score


@pytest.mark.parametrize("budget", [1, 2, 15, 16, 40, 200, 1000])
def test_no_budget_is_overdrawn_and_next_to_nothing_is_left(budget: int) -> None:
    schedule = Schedule.within(budget)
    looked, seen = watched(bowl(), budget)
    found = anneal(looked, draws(), schedule)
    assert looked.spent == sum(map(len, seen)) <= budget
    assert budget - looked.spent < 2 * schedule.population
    assert looked.best_score == min(bowl().distances(np.concatenate(seen)))
    assert np.isfinite(found.scores).all()


def test_more_budget_finds_better() -> None:
    scores = []
    for budget in (100, 1000, 10_000):
        looked = evaluator(budget)
        anneal(looked, draws(), Schedule.within(budget))
        scores.append(looked.best_score)
    assert scores == sorted(scores, reverse=True)
    assert scores[-1] < LEFT + 0.01


def test_steps_and_temperature_fall_as_stated() -> None:
    plan = Schedule(generations=100, first_step=0.2, last_step=0.005, first_temperature=0.02)
    assert plan.step(0) == pytest.approx(0.2)
    assert plan.step(50) == pytest.approx(np.sqrt(0.2 * 0.005))
    assert plan.step(100) == plan.step(500) == pytest.approx(0.005)
    assert plan.temperature(0) == pytest.approx(0.02)
    assert plan.temperature(50) == pytest.approx(0.02 * (plan.step(50) / 0.2) ** 2)
    assert plan.temperature(100) == 0.0


def test_it_ends_when_never_stable() -> None:
    generator, level = draws(), 1.0

    def restless(parameters: np.ndarray) -> np.ndarray:
        nonlocal level
        level *= 0.9  # falls for ever
        return level * (1 + 0.01 * generator.random(len(parameters)))

    looked = Evaluator(dataclasses.replace(bowl(), distances=restless), 100_000)
    anneal_once(looked, draws(), QUICK)
    assert looked.spent == QUICK.evaluations


@pytest.mark.parametrize("field", ["population", "generations", "patience", "max_generations"])
def test_counts_are_at_least_one(field: str) -> None:
    with pytest.raises(InputError, match="at least 1"):
        Schedule(**{field: 0})
