"""Parquet tables, by pandas and by our own reader."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.errors import FormatError
from armsyn.motion import Motion
from armsyn.motion.formats import (
    Episode,
    parquet_format,
    parquet_read,
    read_file,
    read_motion,
    takes_in,
    write_episodes,
    write_motion,
)
from tests.motion.formats.samples import JOINTS, aimed, motion, plan, recording


def test_pandas_reads_one_table_of_all_episodes(tmp_path: Path) -> None:
    episodes = [recording(number, 10 + number) for number in range(3)]
    write_episodes(tmp_path / "a.parquet", iter(episodes))
    table = pd.read_parquet(tmp_path / "a.parquet")
    assert len(table) == 10 + 11 + 12
    assert table.groupby("episode_index").size().tolist() == [10, 11, 12]
    for number, episode in enumerate(episodes):
        rows = table[table["episode_index"] == number]
        np.testing.assert_array_equal(rows["time_s"], episode.motion.time)
        for column, joint in enumerate(JOINTS):
            np.testing.assert_array_equal(rows[f"{joint}:angle_rad"], episode.state[:, column])
            commanded = np.asarray(episode.commanded)[:, column]
            np.testing.assert_array_equal(rows[f"{joint}:commanded_rad"], commanded)
            velocity = np.asarray(episode.velocity)[:, column]
            np.testing.assert_array_equal(rows[f"{joint}:velocity_rad_s"], velocity)
        landmarks = np.asarray(episode.motion.landmarks)
        found = rows[[f"hand:{axis}_m" for axis in "xyz"]].to_numpy()
        np.testing.assert_array_equal(found, landmarks[:, 1])
        assert set(rows["source"]) == {f"motion {number}"}
        assert set(rows["kind"]) == {"recorded"}
        assert json.loads(rows["facts"].iloc[0])["port"] == "/dev/pts/7"


def test_row_groups_are_written_as_they_fill(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parquet_format, "ROWS_AT_ONCE", 50)
    write_episodes(tmp_path / "a.parquet", (plan(number, 20) for number in range(7)))
    found = pq.ParquetFile(tmp_path / "a.parquet").metadata
    assert [found.row_group(group).num_rows for group in range(found.num_row_groups)] == [
        60,
        60,
        20,
    ]


@given(
    count=st.integers(1, 3),
    frames=st.integers(2, 6),
    joints=st.integers(0, 2),
    landmarks=st.integers(0, 2),
    seed=st.integers(0, 2**32 - 1),
)
def test_motions_read_back_bit_by_bit(
    tmp_path_factory: pytest.TempPathFactory,
    count: int,
    frames: int,
    joints: int,
    landmarks: int,
    seed: int,
) -> None:
    if joints + landmarks == 0:
        joints = 1
    random = np.random.default_rng(seed)
    path = tmp_path_factory.mktemp("round") / "a.parquet"
    motions = []
    for number in range(count):
        places = random.normal(size=(frames, landmarks, 3))
        places[random.random((frames, landmarks)) < 0.2] = np.nan
        motions.append(
            Motion(
                np.cumsum(random.uniform(0.001, 1, frames)),
                tuple(f"j:{joint}" for joint in range(joints)),
                random.normal(size=(frames, joints)) if joints else None,
                tuple(f"m {mark}" for mark in range(landmarks)),
                places if landmarks else None,
                f"made {number}",
            )
        )
    write_episodes(path, motions)
    assert takes_in(path) == tuple(str(number) for number in range(count))
    for number, expected in enumerate(motions):
        found = read_motion(f"{path}#{number}")
        assert found.joint_names == expected.joint_names
        assert found.landmark_names == expected.landmark_names
        assert found.source == expected.source
        np.testing.assert_array_equal(found.time, expected.time)
        for part in ("angles", "landmarks"):
            if getattr(expected, part) is None:
                assert getattr(found, part) is None
            else:
                np.testing.assert_array_equal(getattr(found, part), getattr(expected, part))


def test_the_same_episodes_are_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_episodes(tmp_path / f"{name}.parquet", [plan(0), plan(1)])
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()


def test_episodes_read_back_with_all_that_was_said(tmp_path: Path) -> None:
    episodes = [dataclasses.replace(recording(number), rate_hz=50.0) for number in range(2)]
    write_episodes(tmp_path / "a.parquet", episodes)
    for number, expected in enumerate(episodes):
        found = parquet_read.read_episode(tmp_path / "a.parquet", str(number))
        assert (found.kind, found.task, found.rate_hz) == ("recorded", expected.task, 50.0)
        assert found.facts == expected.facts
        np.testing.assert_array_equal(found.action, expected.action)
        np.testing.assert_array_equal(np.asarray(found.velocity), np.asarray(expected.velocity))
    again = (parquet_read.read_episode(tmp_path / "a.parquet", str(k)) for k in range(2))
    write_episodes(tmp_path / "b.parquet", again)
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()


def test_tables_that_contradict_themselves_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    write_episodes(path, plan())
    table = pd.read_parquet(path)
    for changes, match in (
        ({"kind": "recorded"}, "episode 0: motion 0: what was commanded goes with kind 'recorded'"),
        ({"kind": "dreamt"}, "episode 0: kind 'dreamt', expected one of planned, "),
        ({"facts": "{"}, "episode 0: 'facts' is no JSON"),
        ({"facts": "[1]"}, "episode 0: 'facts' is no JSON object"),
    ):
        table.assign(**changes).to_parquet(path)
        with pytest.raises(FormatError, match=match):
            read_motion(path)
    table.drop(columns=["kind", "task", "source", "facts"]).to_parquet(path)
    assert read_file(path).facts == {"episode": "0", "kind": "motion"}


def test_a_single_motion_needs_no_name(tmp_path: Path) -> None:
    write_episodes(tmp_path / "a.parquet", plan(1))
    reading = read_file(tmp_path / "a.parquet")
    assert reading.facts == {"episode": "0", "kind": "planned", "task": "reach target 1"}
    write_episodes(tmp_path / "b.parquet", [plan(1), plan(2)])
    with pytest.raises(FormatError, match="holds 2 motions: name one, as FILE#TAKE: 0, 1"):
        read_file(tmp_path / "b.parquet")
    with pytest.raises(FormatError, match="no motion '7' in it"):
        read_file(f"{tmp_path / 'b.parquet'}#7")


def test_recordings_and_plans_are_kept_apart(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"episode 1 \(motion 3\) has other columns"):
        write_episodes(tmp_path / "a.parquet", [recording(), plan(3)])
    assert not list(tmp_path.iterdir())


def test_other_and_damaged_tables_are_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    write_motion(path, motion())
    whole = path.read_bytes()
    for cut in (0, 1, 4, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:cut])
        with pytest.raises(FormatError) as caught:
            read_motion(path)
        assert "\n" not in str(caught.value)
        assert str(caught.value).startswith(f"{path}: ")
    other = pd.DataFrame({"episode_index": [0, 0], "time_s": [0.0, 1.0], "a": ["x", "y"]})
    for frame, match in (
        (pd.DataFrame({"a": [1.0]}), "episode_index"),
        (other, "no column 'NAME:angle_rad'"),
        (other.rename(columns={"a": "a:angle_rad"}), "or damaged: could not convert"),
        (pd.DataFrame({"episode_index": [0, 0], "a:angle_rad": [1.0, 2.0]}), "no column 'time_s'"),
        (
            pd.DataFrame(
                {"episode_index": [0, 0], "time_s": [1.0, 0.0], "a:angle_rad": [1.0, 2.0]}
            ),
            "time does not increase",
        ),
        (
            pd.DataFrame({"episode_index": ["b"], "time_s": [1.0], "a:angle_rad": [1.0]}),
            "whole numbers",
        ),
    ):
        frame.to_parquet(path)
        with pytest.raises(FormatError, match=match) as caught:
            read_motion(path)
        assert "\n" not in str(caught.value)
        assert str(caught.value).startswith(f"{path}: ")


def test_marks_of_what_was_filled_in_are_left_out(tmp_path: Path) -> None:
    base = motion()
    filled = np.zeros((base.frames, 2), dtype=np.bool_)
    filled[3] = True
    marked = Motion(
        base.time, base.joint_names, base.angles, base.landmark_names, base.landmarks, "", filled
    )
    write_episodes(tmp_path / "a.parquet", [Episode(marked), Episode(base)])
    assert read_motion(f"{tmp_path / 'a.parquet'}#0").filled is None


def test_a_target_is_read_back(tmp_path: Path) -> None:
    write_episodes(tmp_path / "a.parquet", [aimed(0), aimed(2)])
    facts = json.loads(pd.read_parquet(tmp_path / "a.parquet")["facts"].iloc[-1])
    assert facts == {"seed": "7", "target_m": [0.3, -0.1, 0.1]}
    found = parquet_read.read_episode(tmp_path / "a.parquet", "1")
    assert found.target == (0.3, -0.1, 0.1)
    assert found.facts == {"seed": "7"}


@pytest.mark.parametrize("target", ["[1, 2]", '"here"', "[1, 2, [3]]", "7", "[1, 2, NaN]"])
def test_a_target_that_is_none_is_refused(target: str, tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    write_episodes(path, aimed())
    table = pd.read_parquet(path)
    table["facts"] = f'{{"target_m": {target}}}'
    table.to_parquet(path)
    with pytest.raises(FormatError, match="target"):
        parquet_read.read_episode(path, "0")
