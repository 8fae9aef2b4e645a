"""Regression on features, the choice of its kernel, and movement times."""

import dataclasses

import numpy as np

from armsyn.planning.features import Kernel, best_kernel, regression
from armsyn.planning.movement_time import learn_movement_time
from armsyn.planning.postures import tips
from tests.planning.people import made_examples


def test_a_bend_is_learned_where_enough_targets_show_it() -> None:
    draw = np.random.default_rng(2)
    x = draw.uniform(-1, 1, (60, 3))
    y = np.sin(3 * x[:, :1]) + 0.01 * draw.normal(size=(60, 1))
    names = tuple(str(row) for row in range(60))
    kernels = (Kernel(1.0), Kernel(1.0, 100.0))
    assert best_kernel(x, y, names, kernels) == kernels[1]
    assert best_kernel(x, x @ [[1.0], [2.0], [3.0]], names, kernels) == kernels[0]
    assert best_kernel(x, y, ("a", "b", "c") * 20, kernels) == kernels[0]


def test_ridge_regression_is_that_of_its_normal_equations() -> None:
    draw = np.random.default_rng(2)
    x, y = draw.normal(2.0, 3.0, (30, 3)), draw.normal(size=(30, 2))
    z = (x - x.mean(axis=0)) / x.std(axis=0)
    slopes = np.linalg.solve(z.T @ z + 10 * np.eye(3), z.T @ (y - y.mean(axis=0)))
    assert np.allclose(regression(x, y, Kernel(0.1))(x), y.mean(axis=0) + z @ slopes)


def test_more_time_is_predicted_for_a_farther_target() -> None:
    examples = made_examples()
    time = learn_movement_time(examples)
    hands = tips(examples.chain, examples.starts)
    way = np.linalg.norm(examples.targets - hands, axis=1)
    slow = learn_movement_time(dataclasses.replace(examples, durations=0.5 + way))
    predicted = slow(examples.chain, examples.starts, examples.targets)
    assert np.corrcoef(predicted, way)[0, 1] > 0.9
    far = time(examples.chain, examples.starts[:1], np.array([[9.0, 0.0, 0.0]]))
    assert far[0] <= examples.durations.max()
