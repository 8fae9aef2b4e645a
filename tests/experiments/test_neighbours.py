"""Sets used on other targets: means, floors and set cover against plain ways to get them."""

import dataclasses
import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armsyn.experiments import neighbours
from armsyn.experiments.learned import Learned, learn_each
from armsyn.experiments.neighbours_tables import fewest_table, pairs_table
from armsyn.experiments.selections import (
    GARZA,
    HUG_MP,
    HUG_MP_PERSONS,
    Prepared,
    load,
    more_repeats,
)
from armsyn.experiments.serving import Served, fewest_sets, serve
from armsyn.experiments.settings import Settings
from armsyn.experiments.tables import write
from armsyn.motion.captures import load_captures
from armsyn.scoring.floor import human_floor
from armsyn.scoring.repeats import repeats_of
from tests.experiments.conftest import silent

TWO = dataclasses.replace(HUG_MP, captures="hug_mp:S01:1.1.1:R-1,hug_mp:S01:1.2.4:R-9")


@st.composite
def covers(draw: st.DrawFn) -> np.ndarray:
    sets, targets = draw(st.integers(1, 6)), draw(st.integers(1, 6))
    cells = st.lists(st.booleans(), min_size=sets * targets, max_size=sets * targets)
    return np.array(draw(cells)).reshape(sets, targets)


@settings(deadline=None, max_examples=60)
@given(covers(), st.integers(0, 2**32))
def test_no_fewer_sets_would_do(serves: np.ndarray, seed: int) -> None:
    """By trying every choice; between equally few sets the worthiest are taken."""
    worth = np.random.default_rng(seed).random(len(serves))
    wanted = serves.any(axis=0)
    able = [
        rows
        for count in range(len(serves) + 1)
        for rows in itertools.combinations(range(len(serves)), count)
        if (serves[list(rows)].any(axis=0) == wanted).all()
    ]
    best = min(able, key=lambda rows: (len(rows), worth[list(rows)].sum()))
    assert fewest_sets(serves, worth) == list(best)


@pytest.fixture
def served(captures: Path) -> Served:
    """Two sets on four reaches to two targets, with made-up distances."""
    del captures
    reaches = more_repeats(load(TWO), 2)
    assert [name.rpartition(":")[2] for name in reaches.names] == ["R-1", "R-9", "R-1", "R-9"]
    learned = Learned(load(TWO), "svd", "C", 6.0, np.ones((2, 6)), np.array([0.01, 0.02]))
    distances = np.array([[0.01, 0.05, 0.03, 0.07], [0.04, 0.02, 0.06, 0.08]])
    return Served("made", learned, reaches, distances, np.array([0.021, 0.041]))


def test_a_sets_own_reach_does_not_speak_for_it(served: Served) -> None:
    assert served.targets == ["R-1", "R-9"]
    # Set 0 was learned from reach 0, set 1 from reach 1
    np.testing.assert_allclose(served.means, [[0.03, 0.06], [0.05, 0.08]])
    assert served.judged == pytest.approx(served.means)


def test_where_targets_are_reached_once_a_sets_own_reach_is_all_there_is(served: Served) -> None:
    reaches = dataclasses.replace(served.reaches, trainings=served.reaches.trainings[:2])
    alone = Served("made", served.learned, reaches, served.distances[:, :2], None)
    np.testing.assert_array_equal(alone.means, [[np.nan, 0.05], [0.04, np.nan]])
    np.testing.assert_array_equal(alone.judged, [[0.01, 0.05], [0.04, 0.02]])
    assert alone.serves(0.04).tolist() == [[True, False], [True, True]]
    assert alone.fewest(0.04) == [1]
    assert alone.fewest(0.015) == [0]
    assert "training error" in fewest_table([alone]).notes[0]


def test_serving_is_counted_in_floors_of_the_target(served: Served) -> None:
    assert served.serves(1.5).tolist() == [[True, True], [False, False]]
    assert served.serves(2.0).tolist() == [[True, True], [False, True]]
    rows = fewest_table([served]).as_dict()["rows"]
    by_tolerance = {row["tolerance_floors"]: row for row in rows}
    assert by_tolerance[1.5]["sets"] == 1
    assert (by_tolerance[1.5]["chosen"], by_tolerance[1.5]["not_served"]) == ("R-1", "-")
    assert (by_tolerance[1.0]["sets"], by_tolerance[1.0]["not_served"]) == (0, "R-1 R-9")


def test_how_far_targets_are_apart(served: Served) -> None:
    hands = np.array([training.landmarks[-1, -1] for training in served.reaches.trainings])
    gap = np.linalg.norm((hands[0] + hands[2]) / 2 - (hands[1] + hands[3]) / 2)
    np.testing.assert_allclose(served.apart, [[0, gap], [gap, 0]], atol=1e-12)
    apart = {row["apart_m"] for row in pairs_table([served]).as_dict()["rows"]}
    assert sorted(apart) == pytest.approx([0, gap])


@pytest.mark.usefixtures("captures")
def test_repeats_are_the_same_persons_to_the_same_targets() -> None:
    everything = load_captures("hug_mp:S01:all")
    reaches = more_repeats(load(TWO), None)
    wanted = [c.name for c in everything if c.name.endswith((":R-1", ":R-9"))]
    assert sorted(reaches.names) == sorted(wanted)
    assert reaches.names[:2] == load(TWO).names
    once = load(dataclasses.replace(GARZA, at_most=1))
    assert more_repeats(once, None) is once
    assert [person.captures for person in HUG_MP_PERSONS] == [
        f"hug_mp:S0{number}" for number in (1, 2, 3, 4)
    ]


def test_a_captured_motion_that_is_played_as_it_was_has_no_distance(
    captures: Path, tiny: Settings
) -> None:
    """What `serve` measures is the held distance: nil for the capture itself, then held at rest."""
    del captures
    prepared = load(dataclasses.replace(GARZA, at_most=2))

    class Repeated(Learned):
        def play(self, row: int, onto: object = None, longer: float = 1.0) -> np.ndarray:
            del row
            training = next(each for each in self.prepared.trainings if each is onto)
            held = round(longer * training.time.size) - training.time.size
            return np.concatenate([training.landmarks, training.landmarks[-1:].repeat(held, 0)])

    learned = learn_each(prepared, [("svd", "C")], tiny, silent)
    copy = {f.name: getattr(learned["svd", "C"], f.name) for f in dataclasses.fields(Learned)}
    served = serve("made", Repeated(**copy), prepared, {}, silent, "used")
    np.testing.assert_allclose(served.distances, 0, atol=1e-3)
    assert served.floors is None
    really = serve("made", learned["svd", "C"], prepared, {}, silent, "used")
    assert (really.distances > 0.01).all()


def test_the_whole_experiment_sets_floors_of_scoring_beside_it(
    captures: Path, tiny: Settings, tmp_path: Path
) -> None:
    del captures
    few = (TWO, dataclasses.replace(GARZA, at_most=2))
    write(neighbours.run(tiny, tmp_path, silent, few), tmp_path)
    assert (tmp_path / "neighbours.png").is_file()
    document = json.loads((tmp_path / "neighbours.json").read_text())
    tables = {table["title"]: table["rows"] for table in document["tables"]}
    reaches: Prepared = more_repeats(load(TWO), neighbours.FEW_REPEATS)
    floors = []
    for name in reaches.names:
        repeats = repeats_of(name)
        assert repeats is not None
        floors.append((name.endswith("R-1"), human_floor(*repeats).distance))
    expected = np.mean([floor for is_first, floor in floors if is_first])
    same, *_ = (row for row in tables["Every set on every target"] if row["target"] == "R-1")
    assert same["learned_from"] == "hug_mp:S01:1.1.1:R-1"
    assert same["floors"] == pytest.approx(same["held_m"] / expected)
    garza = [row for row in tables["Every set on every target"] if row["who"].startswith("garza")]
    assert {row["bounds"] for row in garza} == {"paper", "positive"}
    assert all(row["floors"] is None for row in garza)
    assert "not** learned from" in document["notes"][0]
