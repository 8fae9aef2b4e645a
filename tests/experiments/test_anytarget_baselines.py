"""Baselines of unseen targets, and the controls that must lose."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.experiments.anytarget_baselines import nearest_mean, raw_ik
from armsyn.experiments.anytarget_controls import (
    CONTROLS,
    at_constant_speed,
    controls_table,
    reversed_in_time,
    with_mirrored_elbow,
    with_rest,
)
from armsyn.experiments.anytarget_people import People, load_hug_mp
from armsyn.experiments.anytarget_primitives import why_missing
from armsyn.experiments.anytarget_rows import ROWS
from armsyn.experiments.anytarget_run import Group, Outcome, predict_all
from armsyn.motion import Motion
from armsyn.motion.rebuilding import segment_lengths
from armsyn.planning.prediction import Predicted
from armsyn.scoring.posture import swivel_angles
from armsyn.scoring.profile import minimum_jerk_speed
from tests.experiments.conftest import silent

BY_KEY = {row.key: row for row in ROWS}
BASELINES = [row for row in ROWS if row.kind == "baseline"]


@pytest.fixture(scope="module")
def people(captures: Path) -> People:
    del captures
    return load_hug_mp(("S01",), at_most=2)


def predicted(people: People, key: str) -> Predicted:
    """What a row makes of the last target's reaches, learned from all others."""
    place = people.examples.places[-1]
    tests = people.of("S01", place)
    train = [row for row in people.of("S01") if row not in tests]
    predictor = BY_KEY[key].learn(people.examples.only(train))
    asked = people.examples.only(tests)
    return predictor.predict(asked.starts, asked.targets)


@pytest.mark.parametrize("key", [row.key for row in BASELINES])
def test_every_baseline_starts_and_ends_where_it_was_asked_to(people: People, key: str) -> None:
    if BY_KEY[key].missing():
        pytest.skip(str(BY_KEY[key].missing()))
    asked = people.examples.only(people.of("S01", people.examples.places[-1]))
    found = predicted(people, key)
    assert found.angles.shape == asked.angles.shape
    np.testing.assert_allclose(found.angles[:, 0], asked.starts, atol=1e-9)
    hands = asked.chain.positions(found.angles[:, -1])[:, -1]
    np.testing.assert_allclose(hands, asked.targets, atol=1e-4)
    assert ((found.durations > 0.3) & (found.durations < 8.1)).all()


def test_the_straight_hand_goes_straight_by_minimum_jerk(people: People) -> None:
    path = people.examples.chain.positions(predicted(people, "straight").angles[0])[:, -1]
    along = path - path[0]
    line = along[-1] / np.linalg.norm(along[-1])
    assert np.linalg.norm(along - np.outer(along @ line, line), axis=1).max() < 1e-3
    speed = np.gradient(along @ line, 0.01) / np.linalg.norm(along[-1])
    np.testing.assert_allclose(
        speed[2:-2], minimum_jerk_speed(np.linspace(0, 1, 101))[2:-2], atol=0.02
    )


def test_raw_ik_takes_the_gain_that_serves_best_and_is_cut_as_captures_are(people: People) -> None:
    ik = raw_ik(people.examples, "svd")
    start, target = people.examples.starts[0], people.examples.targets[0]
    hand = people.examples.chain.positions(ik.play(start, target))[:, -1]
    speed = np.linalg.norm(np.diff(hand, axis=0), axis=1)
    assert 0.05 <= speed[-1] / speed.max() < 0.06
    # A decay: what is left of the way at the cut is as little
    assert np.linalg.norm(hand[-1] - target) < 0.06 * np.linalg.norm(hand[0] - target)


def test_the_nearest_mean_is_of_the_nearest_target(people: People) -> None:
    examples = people.examples
    place = examples.places[0]
    at = people.of("S01", place)
    centre = examples.targets[at].mean(axis=0)
    np.testing.assert_allclose(
        nearest_mean(examples)(centre[None])[0], examples.angles[at].mean(axis=0)
    )


def test_what_is_not_installed_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    assert why_missing() is None
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    assert why_missing() == "not installed: movement_primitives (armsyn[test])"
    assert {row.key for row in ROWS if row.missing()} == {"dmp", "promp"}


@pytest.fixture(scope="module")
def linear(people: People) -> Outcome:
    return predict_all([Group(people, "target")], [BY_KEY["linear"]], 1, silent)[0]["linear"]


def motion_of(outcome: Outcome) -> Motion:
    return outcome.people.motion(0, outcome.angles[0], float(outcome.durations[0]))


def test_a_reversed_reach_goes_the_same_way_back(linear: Outcome) -> None:
    motion = motion_of(linear)
    np.testing.assert_array_equal(reversed_in_time(motion).hand, motion.hand[::-1])


def test_a_constant_speed_keeps_the_path(linear: Outcome) -> None:
    motion = motion_of(linear)
    even = at_constant_speed(motion)
    steps = np.linalg.norm(np.diff(even.hand, axis=0), axis=1)
    assert steps.std() < 0.02 * steps.mean()
    np.testing.assert_allclose(even.hand[[0, -1]], motion.hand[[0, -1]], atol=1e-9)
    assert even.duration == motion.duration


def test_a_mirrored_elbow_keeps_lengths_and_turns_the_swivel_over(linear: Outcome) -> None:
    motion = motion_of(linear)
    mirrored = with_mirrored_elbow(motion)
    assert motion.landmarks is not None
    assert mirrored.landmarks is not None
    lengths = [segment_lengths(part.landmarks) for part in (motion, mirrored)]
    np.testing.assert_allclose(*lengths, atol=1e-9)
    swivels = [
        swivel_angles(*np.moveaxis(part, 1, 0)) for part in (motion.landmarks, mirrored.landmarks)
    ]
    known = np.isfinite(swivels[0]) & np.isfinite(swivels[1])
    assert known.sum() > 20
    np.testing.assert_allclose(swivels[0][known], -swivels[1][known], atol=1e-9)


def test_appended_rest_only_holds(linear: Outcome) -> None:
    motion = motion_of(linear)
    rested = with_rest(motion)
    assert rested.duration == pytest.approx(motion.duration + 1.0, abs=0.02)
    np.testing.assert_array_equal(rested.hand[motion.frames :], motion.hand[-1:].repeat(100, 0))


def test_controls_lose_against_a_prediction_and_are_told_when_they_do_not(linear: Outcome) -> None:
    table = controls_table(linear, 0, 1, silent)
    assert [row["loses"] for row in table.as_dict()["rows"]] == ["yes"] * len(CONTROLS)
    assert "All of them lose" in table.notes[0]
    backwards = Outcome(
        linear.row,
        linear.people,
        linear.protocol,
        linear.scores,
        linear.angles[:, ::-1].copy(),
        linear.durations,
        linear.seconds,
    )
    wins = controls_table(backwards, 0, 1, silent)
    by_control = {row["control"]: row["loses"] for row in wins.as_dict()["rows"]}
    assert by_control["reversed in time"] == "NO"
    assert "A control wins" in wins.notes[0]
