"""The recursion of priorities: its projector, its first level, and steps inside bounds."""

import numpy as np
import pytest
from scipy.optimize import minimize

from armsyn.editing.bounded import Bounds, bounded_step
from armsyn.editing.priorities import Damping, Level, priority_step

UNDAMPED = Damping(0.0)


def some_levels(seed: int, q: int = 9) -> list[Level]:
    rng = np.random.default_rng(seed)
    return [Level(rng.normal(size=(p, q)), rng.normal(size=p)) for p in (2, 3, 2)]


@pytest.mark.parametrize("damping", [UNDAMPED, Damping(0.3), Damping(0.2, relative=False)])
def test_the_projector_is_that_of_the_stacked_jacobian(damping: Damping) -> None:
    levels = some_levels(0)
    # The third level repeats a row of the first: rank-deficient together
    levels[2] = Level(np.stack([levels[0].J[0], levels[2].J[1]]), levels[2].error)
    stacked = np.concatenate([level.J for level in levels])
    _, P = priority_step(levels, damping)
    np.testing.assert_allclose(P, np.eye(9) - np.linalg.pinv(stacked) @ stacked, atol=1e-10)


def test_levels_that_agree_are_all_met() -> None:
    levels = some_levels(1)
    step, _ = priority_step(levels, UNDAMPED)
    for J, error in levels:
        np.testing.assert_allclose(J @ step, error, atol=1e-10)


def test_a_lower_level_does_not_disturb_a_higher_one_however_damped() -> None:
    first, second, _ = some_levels(2, q=4)
    step, _ = priority_step([first, second], Damping(0.5))
    alone, _ = priority_step([first], Damping(0.5))
    np.testing.assert_allclose(first.J @ step, first.J @ alone, atol=1e-12)
    assert np.linalg.norm(second.J @ step - second.error) < np.linalg.norm(
        second.J @ alone - second.error
    )


def test_the_null_space_term_moves_no_level() -> None:
    levels, z = some_levels(3), np.ones(9)
    step, P = priority_step(levels, UNDAMPED, z)
    plain, _ = priority_step(levels, UNDAMPED)
    np.testing.assert_allclose(step - plain, P @ z, atol=1e-12)
    assert np.linalg.norm(step - plain) > 0.1
    for J, error in levels:
        np.testing.assert_allclose(J @ step, error, atol=1e-10)


def test_one_level_is_the_damped_pseudo_inverse() -> None:
    (J, error), *_ = some_levels(4)
    xi = 0.7
    step, _ = priority_step([Level(J, error)], Damping(xi, relative=False))
    np.testing.assert_allclose(step, J.T @ np.linalg.solve(J @ J.T + xi**2 * np.eye(2), error))


def test_a_met_first_level_that_takes_all_freedom_leaves_none() -> None:
    rng = np.random.default_rng(9)
    first = Level(rng.normal(size=(12, 4)), np.zeros(12))
    step, P = priority_step([first, Level(rng.normal(size=(3, 4)), np.ones(3))], Damping(0.01))
    np.testing.assert_allclose(step, np.zeros(4), atol=1e-12)
    np.testing.assert_allclose(P, np.zeros((4, 4)), atol=1e-12)


def test_a_level_of_zeros_moves_nothing() -> None:
    step, P = priority_step([Level(np.zeros((2, 3)), np.ones(2))], Damping(0.01))
    np.testing.assert_array_equal(step, np.zeros(3))
    np.testing.assert_array_equal(P, np.eye(3))


@pytest.mark.parametrize("seed", range(6))
def test_a_bounded_level_is_the_least_squares_solution_inside(seed: int) -> None:
    rng = np.random.default_rng(seed)
    level = Level(rng.normal(size=(3, 5)), 3.0 * rng.normal(size=3))
    bounds = Bounds(rng.normal(size=(12, 5)), rng.uniform(0.05, 0.4, 12))
    xi = 0.3
    step = bounded_step([level], Damping(xi, relative=False), bounds, np.zeros(5))

    def cost(y: np.ndarray) -> float:
        return float(np.sum((level.J @ y - level.error) ** 2) + xi**2 * y @ y)

    within = {"type": "ineq", "fun": lambda y: bounds.h - bounds.G @ y}
    best = minimize(cost, np.zeros(5), constraints=[within], method="SLSQP", tol=1e-14)
    free, _ = priority_step([level], Damping(xi, relative=False))
    assert (bounds.G @ free > bounds.h).any()
    assert (bounds.G @ step <= bounds.h + 2e-11).all()
    assert cost(step) == pytest.approx(best.fun, rel=1e-7)


def test_a_bound_that_is_met_already_is_slid_along() -> None:
    rng = np.random.default_rng(11)
    normal = rng.normal(size=5)
    bounds = Bounds(np.stack([normal, -normal]), np.array([0.3, 0.3]))
    x = 0.3 * normal / (normal @ normal) * (1 + 1e-16)
    level = Level(rng.normal(size=(3, 5)), rng.normal(size=3))
    free, _ = priority_step([level], UNDAMPED)
    if normal @ free < 0:
        level = Level(level.J, -level.error)
    step = bounded_step([level], UNDAMPED, bounds, x)
    assert abs(float(normal @ step)) < 1e-10
    np.testing.assert_allclose(level.J @ step, level.error, atol=1e-8)


def test_inside_bounds_the_first_level_still_comes_first() -> None:
    first, second, _ = some_levels(5, q=5)
    box = Bounds(np.concatenate([np.eye(5), -np.eye(5)]), np.full(10, 0.9))
    step = bounded_step([first, second], UNDAMPED, box, np.zeros(5))
    alone = bounded_step([first], UNDAMPED, box, np.zeros(5))
    assert (np.abs(step) <= 0.9 + 2e-11).all()
    np.testing.assert_allclose(first.J @ step, first.J @ alone, atol=1e-6)


def test_bounds_that_are_not_met_change_nothing() -> None:
    levels = some_levels(6)
    far = Bounds(np.eye(9), np.full(9, 1e3))
    wanted, _ = priority_step(levels, Damping(0.1))
    np.testing.assert_array_equal(bounded_step(levels, Damping(0.1), far, np.zeros(9)), wanted)
