"""Repeats that differ as captured ones do, with start and end kept."""

from __future__ import annotations

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.errors import CaptureError, InputError
from armsyn.planning.ending import ended_at
from armsyn.planning.examples import PHASE, PHASES, Examples
from armsyn.planning.generation.variability import Variability, learn_variability
from armsyn.planning.minimum_jerk import MinimumJerkPredictor

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


def test_a_document_comes_back_and_damage_is_told(learned: Variability) -> None:
    document = learned.as_document()
    back = Variability.from_document(document)
    assert (back.modes == learned.modes).all()
    assert (back.times == learned.times).all()
    assert back.modes.shape[1:] == (PHASES, 7)
    for damaged in (
        {},
        document | {"modes": "none"},
        document | {"times": [0.0]},
        document | {"times": [float("nan")] * len(learned.times)},
    ):
        with pytest.raises(InputError, match="variability"):
            Variability.from_document(damaged)


def test_a_persons_repeats_vary_as_much_again(captures: object) -> None:
    """Those of S01: the hand's spread midway, of captured repeats and of drawn ones."""
    from armsyn.planning.examples import examples_of_people
    from armsyn.planning.predictor import learn_predictor

    del captures
    person = examples_of_people("S01")
    linear = learn_predictor("linear", person)
    varied = learn_variability(person, linear)
    place = max(set(person.places), key=person.places.count)
    mine = person.only([k for k, name in enumerate(person.places) if name == place])
    count = 400
    targets = np.tile(mine.targets.mean(axis=0), (count, 1))
    starts = np.tile(mine.starts.mean(axis=0), (count, 1))
    drawn = varied.vary(person.chain, linear.predict(starts, targets), targets, 0, 0)

    def spread(angles: np.ndarray) -> float:
        hands = person.chain.positions(angles[:, PHASES // 2])[:, -1]
        return float(np.sqrt(((hands - hands.mean(axis=0)) ** 2).sum(axis=1).mean()))

    assert 0.5 < spread(drawn.angles) / spread(mine.angles) < 2.0
