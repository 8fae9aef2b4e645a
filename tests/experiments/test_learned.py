"""What the experiments share, against the scoring room and the captures' own tables."""

import csv
import dataclasses
from pathlib import Path

import numpy as np
import pytest

from armsyn.experiments.learned import Learned, learn_each, speed
from armsyn.experiments.selections import BOTH, GARZA, HUG_MP, Selection, load
from armsyn.experiments.settings import Settings
from armsyn.experiments.twosubjects import TWO
from armsyn.motion.captures import load_captures
from armsyn.scoring import mean_distance
from tests.experiments.conftest import silent


@pytest.mark.parametrize("selection", BOTH, ids=lambda selection: selection.key)
def test_fourteen_reaches_are_the_papers_experiment(captures: Path, selection: Selection) -> None:
    del captures
    assert len(load(selection).trainings) == 14


def test_garza_reaches_stand_still_and_keep_the_tables_order(captures: Path) -> None:
    with (captures / "segments" / "garza.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["frm"] == "rest"]
    moved = {row["to"].removesuffix("01"): float(row["root_move_m"]) for row in rows}
    chosen = [name.removeprefix("garza:") for name in GARZA.captures.split(",")]
    assert max(moved[place] for place in chosen) < 0.1
    assert chosen == [place for place in moved if place in chosen]


def test_hug_mp_is_two_repetitions_of_seven_targets(captures: Path) -> None:
    del captures
    targets = [name.rpartition(":")[2] for name in load(HUG_MP).names]
    assert sorted(targets) == sorted(2 * ["R-1", "R-2", "R-3", "R-4", "R-9", "R-10", "R-11"])


def test_192_motions_of_two_persons(captures: Path) -> None:
    del captures
    names = [
        capture.name
        for selection in TWO
        for capture in load_captures(selection.captures)[: selection.at_most]
    ]
    assert len(names) == len(set(names)) == 192
    assert [name.split(":")[1] for name in names] == 96 * ["S01"] + 96 * ["S02"]


@pytest.fixture
def learned(tiny: Settings, two_of_each: tuple[Selection, ...]) -> list[Learned]:
    return [
        each
        for selection in two_of_each
        for each in learn_each(load(selection), [("svd", "A"), ("njt", "C")], tiny, silent).values()
    ]


def test_distances_are_those_of_the_motions_that_are_played(learned: list[Learned]) -> None:
    """The kernel's score while learning, against the scoring room on what is drawn."""
    assert [(each.ik, each.rate) for each in learned] == 2 * [("svd", 6.0), ("njt", 3.0)]
    for each in learned:
        for row, training in enumerate(each.prepared.trainings):
            played = each.play(row)
            assert played.shape == training.landmarks.shape
            np.testing.assert_allclose(
                mean_distance(training.landmarks, played), each.distances[row], rtol=1e-6
            )


def test_a_set_played_onto_another_reach_starts_there(learned: list[Learned]) -> None:
    for each in learned:
        other = each.prepared.trainings[1]
        onto = each.play(0, other)
        assert onto.shape == other.landmarks.shape
        np.testing.assert_allclose(onto[0], other.landmarks[0], atol=1e-4)
        assert not np.allclose(onto, each.play(1))


def test_speed_of_a_hand_that_turns_in_a_circle() -> None:
    """0.2 m about, 3 rad/s: 0.6 m/s in the middle, whatever the filter does at the ends."""
    time = np.arange(0, 2, 0.01)
    hand = 0.2 * np.stack([np.cos(3 * time), np.sin(3 * time), 0 * time], axis=1)
    np.testing.assert_allclose(speed(time, hand)[60:140], 0.6, rtol=1e-3)


def test_the_captured_motion_itself_correlates_fully(learned: list[Learned]) -> None:
    class Played(Learned):
        def play(self, row: int, onto: object = None, longer: float = 1.0) -> np.ndarray:
            del onto, longer
            return self.prepared.trainings[row].landmarks

    fields = {field.name: getattr(learned[0], field.name) for field in dataclasses.fields(Learned)}
    each = Played(**fields)
    np.testing.assert_allclose(each.speed_rs, 1.0)
    assert (learned[0].speed_rs < 0.99).all()
