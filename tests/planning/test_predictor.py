"""Predicted reaches: exact start, end within a millimetre, times and the captured workspace."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import minimize

from armsyn.arm import load_arm
from armsyn.errors import CaptureError, InputError
from armsyn.planning.examples import PHASE
from armsyn.planning.features import Kernel
from armsyn.planning.latent import learn_latent
from armsyn.planning.minimum_jerk import MinimumJerkPredictor, StraightHandPredictor
from armsyn.planning.postures import tips
from armsyn.planning.predictor import learn_predictor
from tests.planning.people import made_examples

RANDOM = np.random.default_rng(5)


WHOLE_MOTIONS = ("linear", "latent", "minjerk", "minjerk_hand")


@pytest.mark.parametrize("kind", WHOLE_MOTIONS)
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
    inside = (found.angles >= examples.chain.lower) & (found.angles <= examples.chain.upper)
    assert inside[:, 1:].all()
    assert (found.durations >= examples.durations.min()).all()
    assert (found.durations <= examples.durations.max()).all()


@pytest.mark.parametrize("kind", WHOLE_MOTIONS)
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


@pytest.mark.parametrize("kind", WHOLE_MOTIONS)
def test_many_reaches_at_once_are_those_of_each(kind: str) -> None:
    examples = made_examples(noise=0.05)
    predictor, rows = learn_predictor(kind, examples), range(20)
    starts, targets = examples.starts[:20] + 0.02, examples.targets[:20] - 0.01
    together = predictor.predict(starts, targets)
    for row in rows:
        alone = predictor.predict(starts[row : row + 1], targets[row : row + 1])
        assert np.allclose(alone.angles[0], together.angles[row], atol=1e-9)
        assert alone.durations[0] == pytest.approx(together.durations[row])


def test_the_latent_motion_is_the_likeliest_given_start_and_end() -> None:
    """An optimiser that knows nothing of steps or Jacobians finds no likelier deviation."""
    examples = made_examples(noise=0.1, seed=3)
    model = learn_latent(examples, kernel=Kernel(0.1))
    start, target = examples.starts[:1] + 0.03, examples.targets[1:2]
    coefficients = model.fit(target)
    base = model.mean + coefficients[0] @ model.components

    def surprise(x: np.ndarray) -> float:
        motion = base + x @ model.deviations
        miss = np.concatenate(
            [start[0] - motion[:4], target[0] - tips(examples.chain, motion[None, -4:])[0]]
        )
        return float(x @ x + np.sum((miss / model.damping) ** 2))

    best = minimize(surprise, np.zeros(len(model.deviations)), tol=1e-12).x
    found = model.deviation(coefficients, start, target)[0]
    assert surprise(found) <= surprise(best) * (1 + 1e-5)
    assert np.allclose(found, best, atol=1e-2)


def test_what_repeats_vary_together_is_corrected_together() -> None:
    """A start that is off in a joint moves the others as it does in the examples."""
    examples = made_examples(count=60, seed=4)
    draw = np.random.default_rng(1).normal(0.0, 0.1, (60, 1))
    bent = examples.angles.copy()
    bent[:, :60, 2:3] += (draw * (1 - PHASE[:60]))[:, :, None]
    bent[:, :60, 3:4] -= (draw * (1 - PHASE[:60]))[:, :, None]
    model = learn_latent(dataclasses.replace(examples, angles=bent))
    start = bent[:, 0].mean(axis=0)
    starts = np.array([start, start + np.array([0.0, 0.0, 0.2, -0.2])])
    found = model.predict(starts, examples.targets[[0, 0]]).angles
    apart = (found[1] - found[0])[30]
    assert apart[2] == pytest.approx(0.14, abs=0.03)
    assert apart[3] == pytest.approx(-0.14, abs=0.03)


def test_captures_that_start_alike_are_not_stretched_to_another_start() -> None:
    examples = made_examples(noise=0.05)
    alike = examples.angles + (examples.starts[0] - examples.starts)[:, None] * (1 - PHASE)[:, None]
    model = learn_latent(dataclasses.replace(examples, angles=alike))
    starts, targets = examples.starts[:1] + np.array([[0.0], [0.2]]), examples.targets[[0, 0]]
    near, far = model.deviation(model.fit(targets), starts, targets)
    assert np.abs(far - near).max() < 1e-6
    assert model.predict(starts, targets).reached.all()


def test_minimum_jerk_has_its_closed_form_and_needs_no_captures() -> None:
    chain = load_arm("human7", calibrated=False).chain
    starts, ends = RANDOM.uniform(0.5 * chain.lower, 0.5 * chain.upper, (2, 10, 7))
    targets = tips(chain, 0.8 * starts + 0.2 * ends)
    joints = MinimumJerkPredictor(chain).predict(starts, targets)
    s = np.linspace(0.0, 1.0, 101)[:, None]
    share = 6 * s**5 - 15 * s**4 + 10 * s**3
    assert np.allclose(
        joints.angles, starts[:, None] + (joints.angles[:, -1:] - starts[:, None]) * share
    )
    assert np.isnan(joints.outside).all()
    straight = StraightHandPredictor(chain).predict(starts, targets)
    for motion, start, target in zip(straight.angles, starts, targets, strict=True):
        from_hand = tips(chain, start[None])
        assert np.allclose(tips(chain, motion), from_hand + (target - from_hand) * share, atol=1e-4)


def test_joints_stay_within_their_limits_on_the_way() -> None:
    examples = made_examples()
    bulge = examples.angles.copy()
    bulge[:, :, 3] += 3.0 * np.sin(np.pi * PHASE)
    found = learn_predictor("linear", dataclasses.replace(examples, angles=bulge)).predict(
        examples.starts[:3], examples.targets[:3]
    )
    assert found.angles[:, :, 3].max() == examples.chain.upper[3]
    assert found.reached.all()


def test_an_unknown_predictor_is_refused_by_name() -> None:
    with pytest.raises(InputError, match="known: linear"):
        learn_predictor("guess", made_examples())
