"""What `armsyn generate` tells, and what its files say to other programs."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from armsyn.arm import load_arm
from armsyn.planning import planner_for
from tests.cli.commands import Outcome

pytestmark = pytest.mark.usefixtures("compiled")

Call = Callable[..., Outcome]
MINJERK = ("generate", "--arm", "human7", "--plan", "minjerk", "--rate", 50)
GRID = ("--grid", "0.3:0.35:2", "-0.1", "-0.2:-0.15:2", "--chunk", 2)
PLACES = [[x, -0.1, z] for x in (0.3, 0.35) for z in (-0.2, -0.15)]


def test_a_dataset_has_its_targets_in_numbers_and_one_task(call: Call, tmp_path: Path) -> None:
    for name, more in (("plain", ()), ("told", ("--task", "touch it"))):
        done = call(*MINJERK, *GRID, "--format", "lerobot", "--out", tmp_path / name, *more)
        assert done.status == 0, done.err
        folder = tmp_path / name / "dataset.lerobot"
        table = pq.read_table(next(folder.glob("data/*/*.parquet")))
        episode = np.array(table["episode_index"])
        target = np.array(table["observation.environment_state"].to_pylist())
        np.testing.assert_allclose(target, np.array(PLACES)[episode], rtol=1e-6)
        tasks = pq.read_table(folder / "meta" / "tasks.parquet")["task"].to_pylist()
        assert tasks == ["touch it" if more else "reach to the target"]
        rows = (tmp_path / name / "reaches.csv").read_text().splitlines()[1:]
        assert [list(map(float, row.split(",")[1:4])) for row in rows] == PLACES


def test_a_table_has_its_targets_in_its_facts(call: Call, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert call(*MINJERK, *GRID, "--format", "parquet", "--out", out).status == 0
    table = pq.read_table(out / "reaches-000001.parquet")
    assert [json.loads(text)["target_m"] for text in table["facts"].unique().to_pylist()] == (
        PLACES[2:]
    )
    facts = map(json.loads, table["facts"].unique().to_pylist())
    assert [fact["reach"] for fact in facts] == ["2", "3"]
    assert table["task"].unique().to_pylist() == ["reach to the target"]


def test_what_is_all_there_is_told_so_and_left_alone(call: Call, tmp_path: Path) -> None:
    asked = (*MINJERK, *GRID, "--out", tmp_path / "out")
    first = call(*asked, "--json")
    before = {path: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    done = call(*asked, "--resume")
    assert done.status == 0, done.err
    assert "all there" in done.out
    assert call(*asked, "--resume", "--json").document == first.document
    assert {path: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before
    (tmp_path / "out" / "reaches-000001.npz").unlink()
    call(*asked, "--resume").refused(2, "reaches-000001.npz is missing")


def test_an_arm_without_an_atlas_is_told_what_to_do(call: Call, tmp_path: Path) -> None:
    asked = ("generate", "--arm", "reachy_right", *GRID, "--out", tmp_path / "out")
    done = call(*asked)
    done.refused(2, "armsyn learn --arm reachy_right --atlas, or use --plan minjerk")
    assert "did you mean" not in done.err
    call(*asked, "--plan", "minjerk", "--variability").refused(2, "leave out --variability")


def test_minimum_jerk_has_the_captured_workspace_where_an_atlas_knows_it(
    call: Call, calibration: Path, tmp_path: Path
) -> None:
    asked = (*MINJERK, "--calibration", calibration)
    random = ("--random", 20, "--seed", 1)
    for plan in ("minjerk", "latent"):
        done = call(*asked, *random, "--plan", plan, "--out", tmp_path / plan, "--json")
        assert done.status == 0, done.err
        assert done.document["outside_captured_workspace"] == 0
    one, other = (
        {row["index"]: [row[axis] for axis in ("x_m", "y_m", "z_m")] for row in rows_of(out)}
        for out in (tmp_path / "minjerk", tmp_path / "latent")
    )
    both = one.keys() & other.keys()
    assert len(both) > 10
    assert all(one[index] == other[index] for index in both)

    places, arm = ("--grid", "0.3", "-0.3:0.4:2", "0.0"), load_arm("human7", calibration)
    planner = planner_for(arm, "minjerk", calibration)
    wanted = [planner.plan(arm.rest, [0.3, y, 0.0]).outside_m for y in (-0.3, 0.4)]
    done = call(*asked, *places, "--out", tmp_path / "known", "--json")
    assert done.document["outside_captured_workspace"] == np.count_nonzero(wanted) == 1
    assert [float(row["outside_m"]) for row in rows_of(tmp_path / "known")] == wanted
    manifest = json.loads((tmp_path / "known" / "manifest.json").read_text())
    assert len(manifest["inputs"]["atlas_sha256"]) == 64

    (calibration / "human7.atlas.json").unlink()
    call(*asked, *random, "--out", tmp_path / "none").refused(2, "of human7 is known: give --box")
    done = call(*asked, *places, "--out", tmp_path / "unknown", "--json")
    assert done.document["outside_captured_workspace"] is None
    assert [row["outside_m"] for row in rows_of(tmp_path / "unknown")] == ["", ""]
    manifest = json.loads((tmp_path / "unknown" / "manifest.json").read_text())
    assert manifest["outside_captured_workspace"] is None
    assert "atlas_sha256" not in manifest["inputs"]


@pytest.mark.parametrize("kind", ["npz", "csv", "parquet"])
def test_a_reach_of_a_chunk_is_read_as_a_motion(kind: str, call: Call, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert call(*MINJERK, *GRID, "--format", kind, "--out", out).status == 0
    assert call(*MINJERK, *GRID, "--out", tmp_path / "npz").status == 0
    file = out / f"reaches-000001.{kind}"
    if kind != "parquet":  # whose episodes are counted in each file
        call("motion", "info", f"{file}#0").refused(2, "no motion '0' in it; there are 2, 3")
    call("score", file, file).refused(2, "holds 2 motions: name one, as FILE#TAKE")
    name = "1" if kind == "parquet" else "3"
    done = call("motion", "convert", f"{file}#{name}", tmp_path / "one.npz")
    assert done.status == 0, done.err
    with (
        np.load(tmp_path / "npz" / "reaches-000001.npz") as chunk,
        np.load(tmp_path / "one.npz") as one,
    ):
        wanted = chunk["angles"][chunk["first"][1] :]
        np.testing.assert_allclose(one["angles_rad"], wanted, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(np.diff(one["time_s"]), 0.02, rtol=1e-7)
        if kind != "csv":  # which has the joints' angles alone
            arm = load_arm("human7", calibrated=False)
            places = arm.chain.positions(wanted)[:, list(arm.landmark_frames)]
            np.testing.assert_allclose(one["landmarks_m"], places, rtol=0.0, atol=1e-12)
    assert call("motion", "info", file).status == 0


def test_a_table_of_one_motion_has_no_reaches_to_name(call: Call, tmp_path: Path) -> None:
    file = tmp_path / "one.csv"
    file.write_text("time_s,elbow:angle_rad\n0,0\n0.1,0.1\n0.2,0.2\n")
    assert call("motion", "info", file).status == 0
    call("motion", "info", f"{file}#1").refused(2, "one motion without a name: leave out #1")
    cut = tmp_path / "cut.csv"
    cut.write_text("reach,time_s,elbow:angle_rad\n0,0,0\n0,0.1,0.1")
    call("motion", "info", f"{cut}#0").refused(2, "the last line has no end: the file was cut")


def rows_of(out: Path) -> list[dict[str, str]]:
    with (out / "reaches.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_hands_are_turned_as_options_or_columns_say(call: Call, tmp_path: Path) -> None:
    targets = tmp_path / "targets.csv"
    targets.write_text("x,y,z,px,py,pz\n0.35,-0.1,-0.15,0.5,0.5,-1\n0.35,-0.1,-0.15,0,1,0\n")
    asked = (*MINJERK, "--out")
    done = call(*asked, tmp_path / "listed", "--targets", targets, "--orientation-tolerance", 5)
    assert done.status == 0, done.err
    place = ("--grid", "0.35", "-0.1", "-0.15", "--pointing", "0.5", "0.5", "-1")
    assert call(*asked, tmp_path / "one", *place, "--orientation-tolerance", 5).status == 0
    listed, one = rows_of(tmp_path / "listed"), rows_of(tmp_path / "one")
    assert {**one[0], "file": ""} == {**listed[0], "file": ""}
    assert all(0.0 <= float(row["orientation_error_rad"]) <= np.radians(5.0) for row in listed)
    manifest = json.loads((tmp_path / "one" / "manifest.json").read_text())
    direction = np.array([0.5, 0.5, -1.0]) / np.sqrt(1.5)
    np.testing.assert_allclose(manifest["inputs"]["orientation"]["pointing"], direction)


def test_reaches_start_where_they_are_told_to(call: Call, tmp_path: Path) -> None:
    posture = [0.3, 0.1, 0.0, 1.2, 0.0, 0.0, 0.0]
    asked = (*MINJERK, "--grid", "0.35", "-0.1", "-0.15")
    said = ",".join(map(str, posture))
    assert call(*asked, "--start", said, "--out", tmp_path / "first").status == 0
    first = tmp_path / "first" / "reaches-000000.npz"
    assert (
        call(*asked[:-3], "0.3", "0", "-0.2", "--start", first, "--out", tmp_path / "on").status
        == 0
    )
    with np.load(first) as one, np.load(tmp_path / "on" / "reaches-000000.npz") as other:
        np.testing.assert_array_equal(one["angles"][0], posture)
        np.testing.assert_array_equal(other["angles"][0], one["angles"][-1])


def test_a_line_that_asks_for_a_start_outside_a_range_is_refused(
    call: Call, tmp_path: Path
) -> None:
    joints = load_arm("human7", calibrated=False).joint_names
    targets = tmp_path / "targets.csv"
    targets.write_text(
        f"x,y,z,{','.join(joints)}\n0.35,-0.1,-0.15,0,0,0,1,0,0,0\n0.35,-0.1,-0.15,9,0,0,1,0,0,0\n"
    )
    out = tmp_path / "out"
    assert call(*MINJERK, "--targets", targets, "--out", out).status == 0
    with (out / "refusals.csv").open(newline="") as file:
        refused = list(csv.DictReader(file))
    assert [(row["index"], row["kind"]) for row in refused] == [("1", "limit")]
    assert "shoulder_flexion is to start at 9.000 rad, outside its range" in refused[0]["reason"]
    assert "by hand" not in refused[0]["reason"]


def test_reaches_are_slower_when_they_are_told_to_be(call: Call, tmp_path: Path) -> None:
    for factor in (1, 4):
        out = tmp_path / str(factor)
        assert call(*MINJERK, *GRID, "--slower", factor, "--out", out).status == 0
    took = [[float(row["duration_s"]) for row in rows_of(tmp_path / name)] for name in "14"]
    limits = load_arm("human7", calibrated=False).max_velocity / 4.0
    with np.load(tmp_path / "4" / "reaches-000000.npz") as chunk:
        path = chunk["angles"][: chunk["first"][1]]
    assert (np.abs(np.diff(path, axis=0)) * 50.0 <= limits * (1.0 + 1e-6)).all()
    assert np.mean(took[1]) > 1.5 * np.mean(took[0])


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--start", "none.npz"), "--start 'none.npz' is no file, and not the 7 numbers"),
        (("--start", "1,2"), "--start: 2 numbers, expected 7 (rad or m) of shoulder_flexion"),
        (("--slower", "1e6"), "a chunk would have some 6e+08 frames in memory"),
        (("--workers", "100000"), "workers must be between 1 and"),
        (
            ("--start", "9,0,0,0,0,0,0"),
            "--start: shoulder_flexion is to start at 9.000 rad, outside its range -1.1 to 3\n",
        ),
        (("--slower", "0.5"), "--slower must be at least 1"),
        (("--slower", "nan"), "--slower must be at least 1"),
        (("--name", "left"), "human7.left.calibration.json"),
        (("--orientation-tolerance", "3"), "needs --pointing, --orientation, or columns"),
        (("--pointing", "0", "0", "0"), "--pointing: a direction is 3 finite numbers, not all 0"),
        (("--orientation", "0", "nan", "0"), "--orientation must be three finite angles"),
    ],
)
def test_what_cannot_be_meant_is_refused(
    more: tuple[str, ...], said: str, call: Call, tmp_path: Path
) -> None:
    call(*MINJERK, *GRID, *more, "--out", tmp_path / "out").refused(2, said)
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_none_is_told(call: Call) -> None:
    call(*MINJERK, *GRID, "--out", "/dev/null").refused(2, "/dev/null: cannot look into it")
