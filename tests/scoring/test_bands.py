"""Bands of human-likeness: what they are made of, placed in, and kept as."""

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.errors import CaptureError, FormatError, InputError
from armsyn.motion import Motion
from armsyn.motion.captures import load_captures
from armsyn.scoring.bands import Band, Bands, bands_of
from armsyn.scoring.bands_file import bands_as_dict, load_bands, save_bands
from armsyn.scoring.coordination import explained_variance
from armsyn.scoring.human_likeness import MEASURES, How, human_likeness, relative_speed
from armsyn.scoring.profile import minimum_jerk_speed
from armsyn.scoring.score import Settings, score_as_dict, score_motions

from .arms import reach


def some_reaches(count: int = 9) -> list[tuple[str, Motion]]:
    return [(f"r{n}", reach(duration=1 + n / 10, skew=1 + n / 40)) for n in range(count)]


def made(how: How | None = None) -> Bands:
    return bands_of("nine", some_reaches(), how or How())


def test_one_joint_direction_explains_all_and_two_do_not() -> None:
    phase = np.linspace(0, 1, 50)
    line = np.outer(phase**2, [1.0, -2.0, 0.5, 0.1])
    assert explained_variance(line) == pytest.approx([1, 1, 1])
    circle = np.stack([np.cos(2 * np.pi * phase[:-1]), np.sin(2 * np.pi * phase[:-1])], axis=1)
    assert explained_variance(circle) == pytest.approx([0.5, 1, 1])


def test_variance_agrees_with_the_covariances_eigenvalues() -> None:
    angles = np.random.default_rng(3).normal(size=(80, 5)).cumsum(axis=0)
    values = np.sort(np.linalg.eigvalsh(np.cov(angles.T)))[::-1]
    assert explained_variance(angles) == pytest.approx(values.cumsum()[:3] / values.sum())


def test_joints_at_rest_have_no_coordination_and_gaps_are_refused() -> None:
    assert np.isnan(explained_variance(np.full((20, 3), 0.7))).all()
    with pytest.raises(CaptureError, match="gaps"):
        explained_variance(np.array([[0.0, math.nan]] * 4))


def test_a_band_is_the_percentiles_of_its_captures() -> None:
    bands = made()
    times = [human_likeness(motion, How())["movement_time_s"] for _, motion in some_reaches()]
    band = bands.measures["movement_time_s"]
    assert band == (np.median(times), *np.percentile(times, [5, 95]), 9)
    assert bands.reaches == 9
    assert "variance_1_component" not in bands.measures  # there are no joint angles
    assert bands.speed.shape == (3, 101)
    assert (np.diff(bands.speed, axis=0) >= 0).all()


def test_relative_speed_of_minimum_jerk() -> None:
    whole = relative_speed(reach(), How(cutoff=None, fraction=0.0))
    assert whole.mean() == pytest.approx(1, abs=0.02)
    # A landmark on a straight line, without rest: the closed form.
    time = np.linspace(0, 1, 101)
    share = 10 * time**3 - 15 * time**4 + 6 * time**5
    line = Motion(time, landmark_names=("hand",), landmarks=np.outer(share, [1.0, 0, 0])[:, None])
    inside = relative_speed(line, How(cutoff=None))
    at = np.linspace(0, 1, 101)[10:-10]
    cut = (1 - 0.88113) / 2  # what the cut at 5 % leaves out on either side
    expected = minimum_jerk_speed(cut + at * 0.88113) * 0.88113 / 0.99617
    np.testing.assert_allclose(inside[10:-10], expected, atol=0.01)


@given(st.floats(-5, 5))
def test_a_place_is_below_within_or_above(value: float) -> None:
    place = Band(0.0, -1.0, 1.0, 9).place(value)
    assert place == ("below" if value < -1 else "above" if value > 1 else "within")


def test_what_is_not_defined_has_no_place() -> None:
    assert Band(0.0, -1.0, 1.0, 9).place(math.nan) is None


def test_too_few_captures_make_no_band_and_it_says_why() -> None:
    with pytest.raises(CaptureError, match="four: 4 usable captures, a band needs 5"):
        bands_of("four", some_reaches(4), How())
    blind = ("blind", Motion(np.arange(9.0), ("elbow",), np.zeros((9, 1)), source="blind"))
    with pytest.raises(CaptureError, match="only angles"):
        bands_of("five", [*some_reaches(4), blind], How())
    bands = bands_of("six", [*some_reaches(5), blind], How())
    assert bands.reaches == 5
    assert "only angles" in bands.left_out["blind"]


def test_bands_go_to_a_file_and_back(tmp_path: Path) -> None:
    bands = made(How(cutoff=None, fraction=0.1, rate=200.0))
    save_bands(tmp_path / "bands.json", bands)
    found = load_bands(tmp_path / "bands.json")
    assert found.measures == bands.measures
    assert (found.how, found.captures, found.reaches) == (bands.how, "nine", 9)
    np.testing.assert_allclose(found.speed, bands.speed, atol=1e-6)
    first = (tmp_path / "bands.json").read_bytes()
    save_bands(tmp_path / "bands.json", made(How(cutoff=None, fraction=0.1, rate=200.0)))
    assert (tmp_path / "bands.json").read_bytes() == first


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"schema": "other"}, "schema 'other'"),
        ({"measures": {"sparc": {"median": "x", "p5": 0, "p95": 0, "n": 1}}}, "is no number"),
        ({"measures": []}, "no measures"),
        ({"speed_over_mean_speed": {"p5": [1], "median": [1], "p95": [1]}}, "3 rows of 101"),
        ({"measured_how": None}, "no bands"),
        ({"human_floor_m": {}}, "no 'floor'"),
    ],
)
def test_a_damaged_file_is_one_line(tmp_path: Path, change: dict[str, object], said: str) -> None:
    path = tmp_path / "bands.json"
    path.write_text(json.dumps({**bands_as_dict(made()), **change}))
    with pytest.raises(FormatError, match=said) as caught:
        load_bands(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


@given(st.binary(max_size=200))
def test_any_bytes_are_bands_or_a_format_error(tmp_path_factory, content: bytes) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path_factory.mktemp("bands") / "bands.json"
    path.write_bytes(content)
    with pytest.raises(FormatError):
        load_bands(path)


def test_a_score_places_both_in_the_bands() -> None:
    slow = reach(duration=4.0)
    score = score_motions(("a", reach(duration=1.4)), ("b", slow), Settings(bands=made()))
    placed = score_as_dict(score)["bands"]
    assert placed["captures"] == "nine"
    assert placed["measures"]["movement_time_s"]["captured"] == "within"
    assert placed["measures"]["movement_time_s"]["other"] == "above"
    assert placed["measures"]["peak_speed_m_s"]["other"] == "below"


def test_bands_taken_another_way_are_refused_with_what_to_do() -> None:
    with pytest.raises(InputError, match=r"--cutoff none --cut 0\.1: score with the same"):
        score_motions(
            ("a", reach()), ("b", reach()), Settings(bands=made(How(cutoff=None, fraction=0.1)))
        )


@pytest.mark.usefixtures("captures")
def test_bands_of_captured_reaches_are_those_of_people() -> None:
    captures = [(c.name, c.motion) for c in load_captures("hug_mp:S02")]
    bands = bands_of("hug_mp:S02", captures, How())
    assert set(bands.measures) == set(MEASURES)
    # Bockemuehl 2010: two components explain over 90 % within one movement.
    assert bands.measures["variance_2_components"].low > 0.9
    assert -1.7 < bands.measures["sparc"].median < -1.4
    assert 1.0 < bands.measures["path_over_distance"].median < 1.1
    constant = dataclasses.replace(captures[0][1], landmarks=_at_constant_speed(captures[0][1]))
    assert bands.measures["peak_over_mean"].place(
        human_likeness(constant, How())["peak_over_mean"]
    ) == ("below")


def _at_constant_speed(motion: Motion) -> np.ndarray:
    assert motion.landmarks is not None
    share = np.linspace(0, 1, motion.frames)[:, None, None]
    return motion.landmarks[0] * (1 - share) + motion.landmarks[-1] * share
