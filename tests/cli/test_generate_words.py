"""What `armsyn generate` tells, and what its files say to other programs."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from tests.cli.commands import Outcome

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


def test_a_reach_of_a_chunk_is_read_as_a_motion(call: Call, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert call(*MINJERK, *GRID, "--out", out).status == 0
    file = out / "reaches-000001.npz"
    call("motion", "info", f"{file}#0").refused(2, "no motion '0' in it; there are 2, 3")
    done = call("motion", "convert", f"{file}#3", tmp_path / "one.npz")
    assert done.status == 0, done.err
    with np.load(file) as chunk, np.load(tmp_path / "one.npz") as one:
        np.testing.assert_array_equal(one["angles_rad"], chunk["angles"][chunk["first"][1] :])
        np.testing.assert_allclose(np.diff(one["time_s"]), 0.02, rtol=1e-9)
