"""Inverse kinematics of many reaches at once, and how far outside captured targets one lies."""

import numpy as np
import pytest
from scipy.optimize import minimize

from armsyn.arm import load_arm
from armsyn.errors import CaptureError
from armsyn.planning.hull import Hull
from armsyn.planning.postures import jacobians, postures_at, tips

RANDOM = np.random.default_rng(5)


@pytest.mark.parametrize("name", ["hug_mp4", "human7", "koch", "viperx_300s"])
def test_jacobians_of_many_postures_are_those_of_each(name: str) -> None:
    chain = load_arm(name, calibrated=False).chain
    q = RANDOM.uniform(chain.lower, chain.upper, (20, chain.dof))
    for one, J in zip(q, jacobians(chain, q), strict=True):
        assert np.allclose(J, chain.jacobian(one), atol=1e-12)


def test_postures_reach_what_can_be_reached_and_stay_within_limits() -> None:
    chain = load_arm("human7", calibrated=False).chain
    goal = RANDOM.uniform(0.8 * chain.lower, 0.8 * chain.upper, (500, 7))
    near = np.clip(goal + RANDOM.normal(0.0, 0.3, goal.shape), chain.lower, chain.upper)
    targets = tips(chain, goal)
    found, errors = postures_at(chain, near, targets)
    assert np.mean(errors < 1e-4) > 0.99
    assert (found >= chain.lower).all()
    assert (found <= chain.upper).all()
    assert np.allclose(np.linalg.norm(tips(chain, found) - targets, axis=1), errors, atol=1e-12)
    _, errors = postures_at(chain, near[:1], np.array([[2.0, 0.0, 0.0]]))
    assert errors[0] > 1.0


def test_distance_to_the_hull_is_that_of_an_optimiser() -> None:
    points = RANDOM.normal(0.0, 0.2, (30, 3))
    hull, asked = Hull.of(points), RANDOM.normal(0.0, 0.6, (40, 3))
    planes = {"type": "ineq", "fun": lambda x: -(hull.planes[:, :3] @ x + hull.planes[:, 3])}
    for one, outside in zip(asked, hull.outside(asked), strict=True):
        found = minimize(
            lambda x, one=one: np.sum((x - one) ** 2), points.mean(axis=0), constraints=[planes]
        )
        assert outside == pytest.approx(np.linalg.norm(found.x - one), abs=1e-3)
    assert not hull.outside(points).any()
    with pytest.raises(CaptureError, match="plane"):
        Hull.of(np.column_stack([points[:, :2], np.zeros(30)]))
