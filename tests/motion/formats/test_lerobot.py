"""LeRobotDataset v3.0 as lerobot lays it out, read back with pyarrow and pandas."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from armsyn.errors import FormatError, InputError
from armsyn.motion import Motion
from armsyn.motion.formats import (
    Episode,
    lerobot_format,
    lerobot_tables,
    write_episodes,
    write_motion,
)
from tests.motion.formats.samples import JOINTS, aimed, contents, motion, plan, recording

INDICES = ("frame_index", "episode_index", "index", "task_index")


class Dataset:
    """A dataset read as lerobot reads it: all data files in the order of their names."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.info = self.json("info")
        files = sorted((folder / "data").glob("*/*.parquet"))
        self.tables = [pq.read_table(file) for file in files]
        self.data = pa.concat_tables(self.tables)
        episodes = sorted((folder / "meta" / "episodes").glob("*/*.parquet"))
        self.episodes = pa.concat_tables([pq.read_table(file) for file in episodes])
        self.tasks = pd.read_parquet(folder / "meta" / "tasks.parquet")

    def json(self, name: str) -> Any:
        return json.loads((self.folder / "meta" / f"{name}.json").read_text("utf-8"))

    def array(self, name: str) -> Any:
        return np.array(self.data[name].to_pylist())


def written(folder: Path, episodes: Any, **options: Any) -> Dataset:
    write_episodes(folder / "d.lerobot", episodes, **options)
    return Dataset(folder / "d.lerobot")


def test_info_names_every_feature_with_its_type(tmp_path: Path) -> None:
    found = written(tmp_path, [recording(number, 20 + number) for number in range(3)])
    names = [f"{joint}.pos" for joint in JOINTS]
    vector = {"dtype": "float32", "shape": [3], "names": names}
    assert found.info == {
        "codebase_version": "v3.0",
        "robot_type": "koch",
        "total_episodes": 3,
        "total_frames": 63,
        "total_tasks": 1,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": 50,
        "splits": {"train": "0:3"},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": None,
        "features": {
            "action": vector,
            "observation.state": vector,
            "timestamp": {"dtype": "float32", "shape": [1], "names": None},
            **{name: {"dtype": "int64", "shape": [1], "names": None} for name in INDICES},
        },
    }
    assert found.data.schema.names == list(found.info["features"])
    for name, feature in found.info["features"].items():
        element = {"float32": pa.float32(), "int64": pa.int64()}[feature["dtype"]]
        size = feature["shape"][0]
        expected = element if size == 1 else pa.list_(element, size)
        assert found.data.schema.field(name).type == expected
    assert all("/" not in name for name in found.info["features"])


def test_every_index_agrees_with_every_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 60 episodes in small files, two to a chunk."""
    monkeypatch.setattr(lerobot_format, "FILE_MB", 1)
    monkeypatch.setattr(lerobot_format, "FILES_A_CHUNK", 2)
    monkeypatch.setattr(lerobot_tables, "_MB", 2**15)
    monkeypatch.setattr(lerobot_tables, "EPISODES_AT_ONCE", 20)
    lengths = [5 + number % 40 for number in range(60)]
    found = written(tmp_path, (plan(number, length) for number, length in enumerate(lengths)))
    rows = found.episodes.to_pylist()
    assert [row["episode_index"] for row in rows] == list(range(60))
    assert [row["length"] for row in rows] == lengths
    ends = np.cumsum(lengths).tolist()
    assert [row["dataset_to_index"] for row in rows] == ends
    assert [row["dataset_from_index"] for row in rows] == [0, *ends[:-1]]
    assert found.array("index").tolist() == list(range(sum(lengths)))
    assert found.info["total_frames"] == sum(lengths)
    files = sorted(found.folder.glob("data/*/*.parquet"))
    assert [str(file.relative_to(found.folder)) for file in files][:3] == [
        "data/chunk-000/file-000.parquet",
        "data/chunk-000/file-001.parquet",
        "data/chunk-001/file-000.parquet",
    ]
    assert len(sorted(found.folder.glob("meta/episodes/*/*.parquet"))) > 1
    texts = found.tasks.index.tolist()
    assert found.tasks.index.name == "task"
    assert found.tasks["task_index"].tolist() == [0, 1]
    opened = {file: pq.read_table(file).to_pandas() for file in files}
    for row in rows:
        path = found.info["data_path"].format(
            chunk_index=row["data/chunk_index"], file_index=row["data/file_index"]
        )
        frames = opened[found.folder / path]
        own = frames[frames["episode_index"] == row["episode_index"]]
        first, last = row["dataset_from_index"], row["dataset_to_index"]
        assert own["index"].tolist() == list(range(first, last))
        assert own["frame_index"].tolist() == list(range(row["length"]))
        assert {texts[task] for task in own["task_index"]} == set(row["tasks"])
        at = (np.arange(row["length"]) / 50).astype(np.float32)
        np.testing.assert_array_equal(own["timestamp"], at)
        meta = (
            found.folder
            / "meta/episodes"
            / "chunk-{:03d}/file-{:03d}.parquet".format(
                row["meta/episodes/chunk_index"], row["meta/episodes/file_index"]
            )
        )
        assert row["episode_index"] in pq.read_table(meta)["episode_index"].to_pylist()


def test_a_row_group_is_an_episode(tmp_path: Path) -> None:
    written(tmp_path, [plan(number, 10 + number) for number in range(4)])
    found = pq.ParquetFile(tmp_path / "d.lerobot/data/chunk-000/file-000.parquet")
    groups = [found.read_row_group(group) for group in range(found.num_row_groups)]
    assert [set(group["episode_index"].to_pylist()) for group in groups] == [{0}, {1}, {2}, {3}]


def test_action_is_commanded_and_state_measured_in_degrees(tmp_path: Path) -> None:
    episode = recording()
    found = written(tmp_path, episode)
    degrees = np.rad2deg(episode.state).astype(np.float32)
    np.testing.assert_array_equal(found.array("observation.state"), degrees)
    told = np.rad2deg(np.asarray(episode.commanded)).astype(np.float32)
    np.testing.assert_array_equal(found.array("action"), told)
    origin = found.json("armsyn")
    assert origin["schema"] == "armsyn-lerobot-1"
    assert origin["units"] == dict.fromkeys(JOINTS, "degrees")
    assert origin["episodes_of_kind"] == {"recorded": 1}
    (facts,) = found.episodes["armsyn/facts"].to_pylist()
    assert json.loads(facts) == {"arm": "koch", "port": "/dev/pts/7", "simulated": "yes"}
    assert found.episodes["armsyn/kind"].to_pylist() == ["recorded"]
    assert found.episodes["armsyn/source"].to_pylist() == ["motion 0"]


def test_a_plan_says_that_it_is_one(tmp_path: Path) -> None:
    found = written(tmp_path, [plan(0), Episode(motion(1), "observed", facts={"seed": "8"})])
    action, state = found.array("action"), found.array("observation.state")
    of_plan = found.array("episode_index") == 0
    # What a loop by position sends on seeing a state is the next one; the last is held
    np.testing.assert_array_equal(action[of_plan][:-1], state[of_plan][1:])
    np.testing.assert_array_equal(action[of_plan][-1], state[of_plan][-1])
    assert (action[of_plan][:-1] != state[of_plan][:-1]).any(axis=1).all()
    np.testing.assert_array_equal(action[~of_plan], state[~of_plan])
    said = found.json("armsyn")["action"]
    assert "at the next frame" in said["planned"]
    assert "measured posture" in said["observed"]
    assert found.episodes["armsyn/kind"].to_pylist() == ["planned", "observed"]
    assert found.episodes["armsyn/facts"].to_pylist() == ['{"seed": "7"}', '{"seed": "8"}']
    assert found.tasks.index.tolist() == ["reach target 0", "move the arm"]


def test_targets_are_the_state_of_the_environment(tmp_path: Path) -> None:
    found = written(tmp_path, [aimed(number) for number in range(3)])
    name = "observation.environment_state"
    assert found.info["features"][name] == {
        **{"dtype": "float32", "shape": [3], "names": ["x", "y", "z"]}
    }
    assert found.data.schema.names == list(found.info["features"])
    targets = np.array([aimed(number).target for number in range(3)], np.float32)
    np.testing.assert_array_equal(found.array(name), targets[found.array("episode_index")])
    np.testing.assert_allclose(found.json("stats")[name]["max"], [0.3, -0.1, 0.1], rtol=1e-6)
    assert "stats/observation.environment_state/q50" in found.episodes.column_names
    facts = [json.loads(text) for text in found.episodes["armsyn/facts"].to_pylist()]
    assert facts[2] == {"seed": "7", "target_m": [0.3, -0.1, 0.1]}
    assert found.tasks.index.tolist() == ["reach"]
    with pytest.raises(FormatError, match="motion 0: has no target, unlike the first motion"):
        write_episodes(tmp_path / "e.lerobot", [aimed(), plan()])
    with pytest.raises(FormatError, match="motion 0: has a target, unlike the first motion"):
        write_episodes(tmp_path / "e.lerobot", [plan(), aimed()])
    with pytest.raises(FormatError, match="is not finite"):
        Episode(motion(), target=(0.0, float("nan"), 0.0))


def test_other_units(tmp_path: Path) -> None:
    ranges = {"shoulder_pan": (-2.0, 2.0), "shoulder_lift": (-1.0, 3.0), "elbow_flex": (0.0, 0.5)}
    write_episodes(tmp_path / "r.lerobot", plan(), units="radians")
    write_episodes(tmp_path / "n.lerobot", plan(), units="normalised", ranges=ranges)
    write_episodes(tmp_path / "p.lerobot", plan(), prismatic=["elbow_flex"])
    radians, normalised, metres = (Dataset(tmp_path / f"{name}.lerobot") for name in "rnp")
    state = plan().state
    np.testing.assert_array_equal(radians.array("observation.state"), state.astype(np.float32))
    expected = np.stack(
        [state[:, 0] * 50, (state[:, 1] - 1) * 50, (state[:, 2] - 0.25) * 400], axis=1
    )
    np.testing.assert_allclose(
        normalised.array("observation.state"), expected, rtol=1e-6, atol=1e-4
    )
    assert normalised.json("armsyn")["ranges"] == {k: list(v) for k, v in ranges.items()}
    assert metres.json("armsyn")["units"]["elbow_flex"] == "metres"
    slid = metres.array("observation.state")[:, 2]
    np.testing.assert_array_equal(slid, state[:, 2].astype(np.float32))


def test_statistics_are_those_of_all_frames(tmp_path: Path) -> None:
    found = written(tmp_path, (recording(number, 10 + 7 * number) for number in range(6)))
    stats = found.json("stats")
    assert set(stats) == set(found.info["features"])
    for name in stats:
        values = found.array(name).astype(np.float64).reshape(len(found.data), -1)
        for what, expected in (
            ("min", values.min(axis=0)),
            ("max", values.max(axis=0)),
            ("mean", values.mean(axis=0)),
            ("std", values.std(axis=0)),
            ("count", [len(values)]),
        ):
            np.testing.assert_allclose(stats[name][what], expected, rtol=1e-9, atol=1e-9)
    for row in found.episodes.to_pylist():
        own = found.data.filter(pa.compute.equal(found.data["episode_index"], row["episode_index"]))
        action = np.array(own["action"].to_pylist(), dtype=np.float64)
        np.testing.assert_allclose(row["stats/action/q10"], np.quantile(action, 0.1, axis=0))
        np.testing.assert_allclose(row["stats/action/mean"], action.mean(axis=0))
        assert row["stats/action/count"] == [row["length"]]
    # lerobot puts episodes' quantiles together by their mean, weighted by their frames
    weighted = np.average(
        np.array(found.episodes["stats/action/q90"].to_pylist()),
        axis=0,
        weights=found.episodes["length"].to_pylist(),
    )
    np.testing.assert_allclose(stats["action"]["q90"], weighted)


def test_late_ticks_are_interpolated_and_counted(tmp_path: Path) -> None:
    random = np.random.default_rng(5)
    time = np.arange(100) / 50 + random.uniform(0, 2e-4, 100)
    time[0] = 0.0
    time = np.delete(time, 40)  # a tick that was missed
    late = Motion(time, ("a",), 2 * time[:, None], source="late")
    found = written(tmp_path, [late, Motion(np.arange(9) / 50, ("a",), np.zeros((9, 1)))])
    assert found.info["fps"] == 50
    assert found.json("armsyn")["interpolated_episodes"] == 1
    assert found.episodes["length"].to_pylist() == [100, 9]
    first = found.array("action")[:100, 0]
    np.testing.assert_allclose(first, np.rad2deg(np.arange(100) / 25), rtol=1e-6)


def test_the_rate_that_was_asked_for_counts(tmp_path: Path) -> None:
    time = np.cumsum(np.random.default_rng(6).uniform(0.015, 0.02, 60))
    late = Motion(time, ("a",), np.zeros((60, 1)))
    found = written(tmp_path, Episode(late, rate_hz=60.0))
    assert found.info["fps"] == 60
    assert found.array("timestamp").max() <= late.duration


def test_another_rate_can_be_told(tmp_path: Path) -> None:
    found = written(tmp_path, plan(), fps=25)
    assert (found.info["fps"], found.info["total_frames"]) == (25, 15)
    degrees = np.rad2deg(plan().state[::2]).astype(np.float32)
    np.testing.assert_allclose(found.array("observation.state"), degrees, rtol=1e-6)
    np.testing.assert_allclose(found.array("action")[:-1], degrees[1:], rtol=1e-6)


def test_the_same_episodes_are_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        write_episodes(tmp_path / name / "d.lerobot", [plan(number) for number in range(3)])
    first, second = (contents(tmp_path / name / "d.lerobot") for name in ("one", "other"))
    assert first == second
    assert len(first) == 6


def test_what_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "d.lerobot"
    slow = Motion(np.arange(5) / 0.3, ("a",), np.zeros((5, 1)))
    odd = Motion(np.arange(5) / 7.4, ("a",), np.zeros((5, 1)))
    slashed = Motion(np.arange(5.0), ("a/b",), np.zeros((5, 1)))
    for episodes, options, match in (
        (slow, {}, "0.3 Hz is no whole number"),
        (odd, {}, "7.4 Hz is no whole number"),
        (plan(), {"fps": 0}, "0 frames a second"),
        (plan(), {"fps": 2.5}, "2.5 frames a second"),
        (plan(), {"fps": float("nan")}, "nan frames a second"),
        (slashed, {}, "no '/' in names: rename 'a/b'"),
        (plan(), {"units": "turns"}, "give one of degrees, radians, normalised"),
        (plan(), {"units": "normalised"}, "no range of 'shoulder_pan'"),
        (plan(), {"units": "normalised", "ranges": dict.fromkeys(JOINTS, (1, 1))}, "lower first"),
    ):
        with pytest.raises(FormatError, match=match) as caught:
            write_episodes(out, episodes, **options)
        assert str(caught.value).startswith(f"{out}: ")
    huge = Motion(np.arange(5.0), ("a",), np.full((5, 1), 1e300), source="huge")
    with pytest.raises(FormatError, match="huge: action is too large for single precision"):
        write_episodes(out, huge)
    with pytest.raises(FormatError, match=r"motion 0: 0\.58 s at 1 Hz are not between 2"):
        write_episodes(out, plan(), fps=1)
    assert not list(tmp_path.iterdir())


def test_an_empty_folder_is_filled(tmp_path: Path) -> None:
    (tmp_path / "d.lerobot").mkdir()
    assert written(tmp_path, plan()).info["total_episodes"] == 1
    assert [path.name for path in tmp_path.iterdir()] == ["d.lerobot"]


def test_a_folder_that_is_there_is_kept(tmp_path: Path) -> None:
    out = tmp_path / "d.lerobot"
    out.mkdir()
    write_motion(out, motion())
    before = contents(out)
    for path in (out, tmp_path / "file.lerobot"):
        if path != out:
            path.write_text("mine")
        with pytest.raises(InputError, match="is there already"):
            write_motion(path, motion())
    assert contents(out) == before
    assert (tmp_path / "file.lerobot").read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 2
