"""Predicted reaches: exact start, end within a millimetre, times and the captured workspace."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from armsyn.arm import load_arm
from armsyn.errors import CaptureError, InputError
from armsyn.planning.examples import examples_of_people
from armsyn.planning.hull import Hull
from armsyn.planning.postures import jacobians, postures_at, tips
from armsyn.planning.predictor import PREDICTORS, learn_predictor
from tests.planning.people import made_examples

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


@pytest.mark.parametrize("kind", PREDICTORS)
def test_a_prediction_starts_and_ends_where_it_was_asked_to(kind: str) -> None:
    examples = made_examples(noise=0.05)
    predictor = learn_predictor(kind, examples)
    goals = RANDOM.uniform([-0.75, -0.6, -0.3, 1.0], [-0.65, -0.5, -0.2, 1.1], (50, 4))
    targets = tips(examples.chain, goals)
    starts = examples.starts.mean(axis=0) + RANDOM.normal(0.0, 0.05, (50, 4))
    found = predictor.predict(starts, targets)
    assert found.angles.shape == (50, 101, 4)
    assert predictor.name == kind
    assert (found.angles[:, 0] == starts).all()
    gaps = np.linalg.norm(tips(examples.chain, found.angles[:, -1]) - targets, axis=1)
    assert gaps.max() < 1e-3
    assert np.allclose(gaps, found.errors, atol=1e-9)
    assert found.reached.all()
    assert (found.durations >= examples.durations.min()).all()
    assert (found.durations <= examples.durations.max()).all()


@pytest.mark.parametrize("kind", PREDICTORS)
def test_what_cannot_be_predicted_is_refused(kind: str) -> None:
    examples = made_examples()
    with pytest.raises(CaptureError):
        learn_predictor(kind, examples.only(range(3)))
    predictor = learn_predictor(kind, examples)
    with pytest.raises(InputError, match="reach 1"):
        predictor.predict(np.zeros((2, 4)), np.array([[0, 0, 0], [0, np.nan, 0]]))
    with pytest.raises(InputError, match="shape"):
        predictor.predict(np.zeros((2, 4)), np.zeros((3, 3)))
    far = predictor.predict(examples.starts[:1], np.array([[5.0, 0.0, 0.0]]))
    assert not far.reached[0]
    assert far.outside[0] > 4.0


def test_an_unknown_predictor_is_refused_by_name() -> None:
    with pytest.raises(InputError, match="known: linear"):
        learn_predictor("guess", made_examples())


def test_examples_of_a_person_end_at_their_targets(captures: Path) -> None:
    assert captures
    examples = examples_of_people("S01")
    assert examples.size == 100
    assert set(examples.subjects) == {"S01"}
    assert len(set(examples.places)) == 7
    assert examples.angles.shape == (100, 101, 4)
    assert np.allclose(tips(examples.chain, examples.angles[:, -1]), examples.targets)
    whole = examples_of_people("S01", cut="segment")
    assert (whole.durations > examples.durations).mean() > 0.9
    some = examples.only(np.array(examples.places) == "R-9")
    assert set(some.places) == {"R-9"}
    assert some.size == examples.places.count("R-9")
