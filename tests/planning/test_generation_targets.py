"""Where generated reaches go: files read by line, grids, and chance by index."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy import stats

from armsyn.errors import FormatError, InputError
from armsyn.planning.generation.chance import normal, uniform
from armsyn.planning.generation.target_file import read_targets
from armsyn.planning.generation.targets import (
    GridTargets,
    RandomTargets,
    checked_axis,
    checked_box,
    random_within,
)
from armsyn.planning.hull import Hull
from armsyn.planning.posing import Pointing, Turned

JOINTS = ("first", "second")


def written(folder: Path, text: str | bytes) -> Path:
    path = folder / "targets.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    "text",
    [
        "0.1,0.2,0.3\n-0.4,5e-1,.6\n",
        "0.1 0.2 0.3\n-0.4\t5e-1 .6",
        "\ufeffx,y,z\n0.1,0.2,0.3\n-0.4,0.5,0.6\n",
        "# made by hand\n\nz, y, x\n0.3, 0.2, 0.1  # near\n0.6, 0.5, -0.4\r\n",
        "X Y Z\n0.1 0.2 0.3\n-0.4 0.5 0.6\n",
    ],
)
def test_a_file_is_read_by_commas_or_blanks_with_or_without_names(
    text: str, tmp_path: Path
) -> None:
    found = read_targets(written(tmp_path, text), JOINTS)
    assert found.starts is None
    assert found.targets.tolist() == [[0.1, 0.2, 0.3], [-0.4, 0.5, 0.6]]


def test_a_file_may_say_where_reaches_start(tmp_path: Path) -> None:
    text = "second,x,y,z,first\n2,0.1,0.2,0.3,1\n4,0.4,0.5,0.6,3\n"
    targets, starts, _ = read_targets(written(tmp_path, text), JOINTS).some(1, 2)
    assert targets.tolist() == [[0.4, 0.5, 0.6]]
    assert starts is not None
    assert starts.tolist() == [[3.0, 4.0]]


@pytest.mark.parametrize(
    ("columns", "values", "wanted"),
    [
        ("px,py,pz", "0,0,-3", Pointing([0, 0, -1], 0.1)),
        ("Roll,Pitch,Yaw", "0,90,0", Turned([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], 0.1)),
    ],
)
def test_a_file_may_say_how_hands_are_turned(
    columns: str, values: str, wanted: Pointing | Turned, tmp_path: Path
) -> None:
    text = f"second,{columns},z,y,x,first\n2,{values},0.3,0.2,0.1,1\n"
    found = read_targets(written(tmp_path, text), JOINTS, 0.1)
    assert found.targets.tolist() == [[0.1, 0.2, 0.3]]
    assert found.starts is not None
    assert found.starts.tolist() == [[1.0, 2.0]]
    sent = pickle.loads(pickle.dumps(found))  # noqa: S301  to other processes
    (orientation,) = sent.some(0, 1).orientations
    assert type(orientation) is type(wanted)
    assert orientation.tolerance == 0.1
    for name in ("direction", "rotation"):
        if hasattr(wanted, name):
            assert_allclose(getattr(orientation, name), getattr(wanted, name), atol=1e-12)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x,y,z,px,py\n0,0,0,0,0\n", "line 1: pz is missing; columns are x, y, z"),
        ("x,y,z,px,py,pz\n1,1,1,0,0,1\n1,1,1,0,0,0\n", "line 3: px, py, pz are all 0"),
        ("x,y,z,px,py,pz,roll,pitch,yaw\n" + "1," * 8 + "1\n", "a hand points (px, py, pz) or"),
        ("0.1,0.2,0.3\n0.1,0.2\n", "line 2: 2 numbers, expected 3"),
        ("# note\n\n0.1,0.2,0.3,0.4\n", "line 3: 4 numbers, expected x y z"),
        ("0.1,0.2,abc\n", "line 1: 'abc' is not a number"),
        ("x,y,z\n0.1,,0.3\n", "line 2: '' is not a number"),
        ("0.1 0.2 nan\n", "line 1: 'nan' is not a finite number"),
        ("nan nan nan\n", "line 1: a target is 3 finite numbers"),
        ("0.1,0.2,1e308\n", "line 1: '1e308' is beyond 1e+06"),
        ("1_0,0,0\n", "line 1: '1_0' is not a finite number"),
        ("0.1,0.2,1e999\n", "line 1: '1e999' is not a finite number"),
        ("x,y,w\n0,0,0\n", "line 1: z is missing; w is unknown; columns are x, y, z"),
        ("x,y,z,first\n0,0,0,0\n", "second is missing; columns"),
        ("x,y,z,first,first\n0,0,0,0,0\n", "first is there twice"),
        ("0.1;0.2;0.3\n", "line 1: separate numbers by commas or blanks"),
        ("x,y,z\n", "no targets in it"),
        ("", "no targets in it"),
        (b"\xff\xfe\x00\x01", "not a text file"),
        ("1" * 20_000, "line 1: longer than any"),
    ],
)
def test_a_malformed_file_is_refused_by_its_line(
    text: str | bytes, said: str, tmp_path: Path
) -> None:
    path = written(tmp_path, text)
    with pytest.raises(FormatError) as caught:
        read_targets(path, JOINTS)
    assert said in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@given(st.binary(max_size=200))
def test_whatever_is_in_a_file_it_is_read_or_refused(content: bytes) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        try:
            found = read_targets(written(Path(folder), content), JOINTS)
        except FormatError:
            return
    assert np.isfinite(found.targets).all()


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="cannot read it"):
        read_targets(tmp_path / "none.csv", JOINTS)


def test_a_line_of_many_places_costs_no_more_than_those_asked_for() -> None:
    grid = GridTargets(((0.0, 1.0, 10**18), (0.2, 0.2, 1), (0.5, 0.1, 1)))
    some, *_ = grid.some(5 * 10**17, 5 * 10**17 + 2)
    np.testing.assert_allclose(some, [[0.5, 0.2, 0.5]] * 2, rtol=1e-12)


def test_a_grid_is_every_combination() -> None:
    grid = GridTargets((checked_axis("0:1:3"), checked_axis("5"), checked_axis("-1:1:2")))
    assert grid.size == 6
    targets, *_ = grid.some(0, 6)
    assert targets.tolist() == [[x, 5.0, z] for x in (0.0, 0.5, 1.0) for z in (-1.0, 1.0)]
    assert grid.some(2, 4)[0].tolist() == targets[2:4].tolist()


@pytest.mark.parametrize(
    "text", ["", "a", "0:1", "0:1:0", "0:1:-2", "0:1:2:3", "0:inf:2", "0:1:2.5", "1e308"]
)
def test_a_malformed_axis_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        checked_axis(text)


@pytest.mark.parametrize("text", ["1:0", "0:1:2", "a:b", "0:nan"])
def test_a_malformed_box_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        checked_box(["0:1", text, "0:1"])


def test_chance_depends_on_seed_purpose_and_index_only() -> None:
    whole = uniform(3, "targets", 0, 50, 5)
    for first, last in ((0, 7), (7, 8), (8, 50)):
        assert (uniform(3, "targets", first, last, 5) == whole[first:last]).all()
    assert not (uniform(4, "targets", 0, 50, 5) == whole).any()
    assert not (uniform(3, "repeats", 0, 50, 5) == whole).any()
    assert ((whole > 0.0) & (whole < 1.0)).all()


def test_chance_is_even_and_normal() -> None:
    assert stats.kstest(uniform(1, "targets", 0, 2000, 5).ravel(), "uniform").pvalue > 1e-3
    z = normal(1, "repeats", 0, 2000, 5)
    assert stats.kstest(z.ravel(), "norm").pvalue > 1e-3
    assert_allclose(np.cov(z.T), np.eye(5), atol=0.1)


def test_random_targets_fill_the_hull_and_nothing_else() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    drawn = random_within(1500, 9, Hull.of(corners))
    targets, *_ = drawn.some(0, 1500)
    outside = Hull.of(corners).outside(targets) > 0.0
    # the hull is a sixth of its box: 16 places miss it with a chance of 5 %
    assert 0.02 < outside.mean() < 0.09
    assert_allclose(targets[~outside].mean(axis=0), 0.25, atol=0.02)
    assert (drawn.some(700, 703)[0] == targets[700:703]).all()
    other = RandomTargets(10, 10, drawn.lower, drawn.upper, drawn.hull)
    assert not (other.some(0, 10)[0] == targets[:10]).any()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x,y\n0.3,0\n", "line 1: z is missing; columns are x, y, z"),
        ("x,y,depth\n0.3,0,0\n", "line 1: z is missing; depth is unknown; columns"),
        ("x,y,z,a\n0.3,0,0,1\n", "line 1: b is missing; columns"),
        ("x,y,z,z\n0.3,0,0,1\n", "z is there twice"),
        ("0.3;0;0.1\n", "not by ';'"),
        ("x;y;z\n0,3;0;0,1\n", "not by ';'"),
        ("0,3 0,1 0,2\n", "with decimal points"),
        ("350 -100 200\n300 100 200\n", "the nearest target is 300 m away: targets are metres"),
    ],
)
def test_a_file_of_another_kind_is_told_what_is_wrong_with_it(
    text: str, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "targets.csv"
    path.write_text(text)
    with pytest.raises(FormatError) as caught:
        read_targets(path, ("a", "b"))
    assert said in str(caught.value)
