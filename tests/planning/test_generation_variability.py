"""Repeats that differ as captured ones do, with start and end kept."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from armsyn.arm import load_arm
from armsyn.errors import CaptureError
from armsyn.planning.ending import ended_at
from armsyn.planning.examples import PHASE, Examples, examples_of_people
from armsyn.planning.generation.variability import Variability, learn_variability
from armsyn.planning.minimum_jerk import MinimumJerkPredictor
from armsyn.planning.predictor import learn_predictor
from armsyn.scoring.posture import swivel_angles

FloatArray = NDArray[np.float64]

ARM = load_arm("human7", calibrated=False)
PLACES = np.array([[0.35, -0.1, -0.15], [0.4, -0.25, -0.05], [0.3, 0.05, -0.3]])
BELLS = np.stack([np.sin(np.pi * PHASE) ** 2, np.sin(2.0 * np.pi * PHASE) * PHASE])
SPREAD = np.array([0.04, 0.02])
TIME_SPREAD = 0.1
REPEATS = 60


def people() -> Examples:
    """A minimum-jerk reacher whose repeats differ by two bells, and who is odd at each place."""
    rng = np.random.default_rng(1)
    targets = np.repeat(PLACES, REPEATS, axis=0)
    starts = np.tile(ARM.rest, (len(targets), 1))
    predicted = MinimumJerkPredictor(ARM.chain).predict(starts, targets)
    z = rng.normal(size=(len(targets), 2)) * SPREAD
    own = np.repeat(rng.normal(size=(3, 1)), REPEATS, axis=0) * 0.2
    angles = predicted.angles + ((z @ BELLS + own * BELLS[0])[..., None] * [1, 0.5, 0, 0, 0, 0, 0])
    angles, _ = ended_at(ARM.chain, angles, targets)
    durations = predicted.durations * np.exp(rng.normal(size=len(targets)) * TIME_SPREAD + 0.3)
    names = tuple(f"reach {row}" for row in range(len(targets)))
    places = tuple(f"place {row // REPEATS}" for row in range(len(targets)))
    return Examples(ARM.chain, names, ("one",) * len(names), places, angles, durations, targets)


@pytest.fixture(scope="module")
def learned() -> Variability:
    return learn_variability(people(), MinimumJerkPredictor(ARM.chain))


def test_repeats_differ_as_captured_ones_around_their_own_mean(learned: Variability) -> None:
    targets = np.tile([0.38, -0.15, -0.1], (3000, 1))
    starts = np.tile(ARM.rest, (3000, 1))
    predicted = MinimumJerkPredictor(ARM.chain).predict(starts, targets)
    varied = learned.vary(ARM.chain, predicted, targets, 5, 0)
    left = varied.angles - predicted.angles
    # what people are odd by at a place is no spread between their repeats
    wanted = np.sqrt((SPREAD**2) @ BELLS**2)
    np.testing.assert_allclose(left[:, :, 0].std(axis=0), wanted, atol=0.004)
    np.testing.assert_allclose(left[:, :, 1].std(axis=0), 0.5 * wanted, atol=0.004)
    np.testing.assert_allclose(left.mean(axis=0), 0.0, atol=0.004)
    spread = np.log(varied.durations / predicted.durations).std()
    assert spread == pytest.approx(TIME_SPREAD, rel=0.15)


def test_start_and_end_stay_and_each_index_has_its_own_chance(learned: Variability) -> None:
    targets = np.repeat(PLACES, 10, axis=0)
    predicted = MinimumJerkPredictor(ARM.chain).predict(np.tile(ARM.rest, (30, 1)), targets)
    varied = learned.vary(ARM.chain, predicted, targets, 5, 100)
    assert (varied.angles[:, 0] == predicted.angles[:, 0]).all()
    hands = ARM.chain.positions(varied.angles[:, -1])[:, -1]
    assert np.linalg.norm(hands - targets, axis=1).max() < 1e-3
    assert varied.errors.max() < 1e-3
    again = learned.vary(ARM.chain, predicted, targets, 6, 100)
    assert not (again.durations == varied.durations).any()
    part = Variability(learned.modes, learned.times, learned.repeats)
    rest = type(predicted)(*(values[7:9] for values in vars(predicted).values()))
    some = part.vary(ARM.chain, rest, targets[7:9], 5, 107)
    np.testing.assert_allclose(some.angles, varied.angles[7:9], rtol=0.0, atol=1e-9)


def test_captures_without_repeats_are_refused() -> None:
    few = people().only([0, 1, REPEATS, REPEATS + 1, 2 * REPEATS])
    with pytest.raises(CaptureError, match="2 repeats"):
        learn_variability(few, MinimumJerkPredictor(ARM.chain))


def test_ends_differ_by_all_that_repeats_do_with_the_hand_where_it_is() -> None:
    """Modes in no posture's null space: four of seven directions would be left of them."""
    rng = np.random.default_rng(3)
    modes = 0.02 * rng.normal(size=(12, 1, 7)) * PHASE[:, None]
    spread = Variability(modes, np.zeros(12), 20)
    for goal in PLACES:
        targets = np.tile(goal, (4000, 1))
        starts = np.tile(ARM.rest, (4000, 1))
        predicted = MinimumJerkPredictor(ARM.chain).predict(starts, targets)
        ends = spread.vary(ARM.chain, predicted, targets, 2, 0).angles[:, -1]
        whole = np.sum(modes[:, -1] ** 2)
        assert ends.var(axis=0).sum() == pytest.approx(whole, rel=0.06)
        hands = ARM.chain.positions(ends)[:, -1]
        assert np.linalg.norm(hands - goal, axis=1).max() < 2e-5


def within_places(values: FloatArray, places: tuple[str, ...]) -> FloatArray:
    """Variance around each place's own mean."""
    rows = [[row for row, name in enumerate(places) if name == place] for place in {*places}]
    around = [values[some] - values[some].mean(axis=0) for some in rows]
    freedom = sum(len(some) - 1 for some in rows)
    return np.asarray(sum((part**2).sum(axis=0) for part in around) / freedom)


@pytest.mark.parametrize("subject", ["S01", "S02", "S03", "S04"])
def test_a_persons_repeats_vary_as_much_again(subject: str, captures: object) -> None:
    """Around what is predicted: posture over the reach, and the elbow's swivel at its end."""
    del captures
    person = examples_of_people(subject)
    linear = learn_predictor("linear", person)
    varied = learn_variability(person, linear)
    phases = [25, 50, 75, 90, 100]

    def swivels(angles: FloatArray) -> FloatArray:
        shoulder, elbow, hand = person.chain.positions(angles[:, -1])[:, [0, 3, 4]].swapaxes(0, 1)
        return swivel_angles(shoulder, elbow, hand)

    predicted = linear.predict(person.starts, person.targets)
    captured = within_places(person.angles - predicted.angles, person.places)
    turned = within_places(swivels(person.angles) - swivels(predicted.angles), person.places)
    drawn = [
        varied.vary(person.chain, predicted, person.targets, seed, 0).angles for seed in range(20)
    ]
    change = (np.stack(drawn) - predicted.angles)[:, :, phases]
    ratio = (change**2).mean(axis=(0, 1)).sum(axis=1) / captured[phases].sum(axis=1)
    assert ((ratio > 0.9) & (ratio < 1.1)).all()
    swivel = np.stack([swivels(angles) - swivels(predicted.angles) for angles in drawn])
    assert 0.7 < np.mean(swivel**2) / turned < 1.5
