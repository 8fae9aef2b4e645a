"""Bags as the ROS 2 reader of the MCAP project sees them."""

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader

from armsyn.errors import FormatError
from armsyn.motion import Motion
from armsyn.motion.formats import Episode, write_episodes, write_motion
from tests.motion.formats.samples import JOINTS, aimed, motion, plan, recording


def messages(path: Path) -> dict[str, list[Any]]:
    """By topic, each with the time it was logged at, s."""
    found = defaultdict(list)
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found[channel.topic].append((message.log_time / 1e9, decoded))
    return found


def stamp(message: Any) -> float:
    since = message.header.stamp
    return (since.sec * 1_000_000_000 + since.nanosec) / 1e9


def test_a_recording_tells_what_was_commanded_from_what_was_measured(tmp_path: Path) -> None:
    episode = recording()
    write_episodes(tmp_path / "a.mcap", episode)
    found = messages(tmp_path / "a.mcap")
    states = [message for _, message in found["/joint_states"]]
    np.testing.assert_array_equal([state.position for state in states], episode.state)
    np.testing.assert_array_equal([state.velocity for state in states], episode.velocity)
    np.testing.assert_allclose([stamp(state) for state in states], episode.motion.time, atol=1e-9)
    assert all(state.name == list(JOINTS) and len(state.effort) == 0 for state in states)
    ((logged, trajectory),) = found["/joint_trajectory"]
    assert (logged, stamp(trajectory)) == (0, 0)
    assert trajectory.joint_names == list(JOINTS)
    points = trajectory.points
    np.testing.assert_array_equal([point.positions for point in points], episode.commanded)
    assert all(len(point.velocities) == 0 for point in points)
    assert {state.header.frame_id for state in states} == {""}
    since = [point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec for point in points]
    np.testing.assert_allclose(since, episode.motion.time, atol=1e-9)
    ((_, said),) = found["/episode"]
    facts = json.loads(said.data)
    assert facts["kind"] == "recorded"
    assert facts["action"] == "the commanded posture"
    assert facts["port"] == "/dev/pts/7"
    assert facts["source"] == "motion 0"


def test_a_plan_says_that_it_is_one(tmp_path: Path) -> None:
    write_episodes(tmp_path / "a.mcap", plan())
    found = messages(tmp_path / "a.mcap")
    facts = json.loads(found["/episode"][0][1].data)
    assert (facts["kind"], facts["task"], facts["seed"]) == ("planned", "reach target 0", "7")
    assert len(found["/joint_trajectory"]) == 1
    assert all(len(message.velocity) == 0 for _, message in found["/joint_states"])
    frames = {message.header.frame_id for _, message in found["/joint_states"]}
    assert frames == {"planned, not measured"}


def test_a_target_is_told_in_numbers(tmp_path: Path) -> None:
    write_episodes(tmp_path / "a.mcap", aimed(2))
    ((_, said),) = messages(tmp_path / "a.mcap")["/episode"]
    assert json.loads(said.data)["target_m"] == [0.3, -0.1, 0.1]


def test_the_points_of_a_plan_have_velocities_and_end_at_rest(tmp_path: Path) -> None:
    """Of a parabola central differences are exact, also at uneven times."""
    time = np.array([0.0, 0.1, 0.25, 0.3, 0.5, 0.6])
    parabola = Motion(time, ("a",), (3 * time**2 - time)[:, None])
    write_episodes(tmp_path / "a.mcap", Episode(parabola, "planned"))
    ((_, trajectory),) = messages(tmp_path / "a.mcap")["/joint_trajectory"]
    speeds = [point.velocities[0] for point in trajectory.points]
    np.testing.assert_allclose(speeds[1:-1], 6 * time[1:-1] - 1, rtol=1e-12)
    assert (speeds[0], speeds[-1]) == (0.0, 0.0)


def test_an_arm_that_was_only_observed_has_no_trajectory(tmp_path: Path) -> None:
    write_episodes(tmp_path / "a.mcap", Episode(motion(), "observed"))
    found = messages(tmp_path / "a.mcap")
    assert set(found) == {"/episode", "/joint_states"}


def test_episodes_follow_each_other_a_second_apart(tmp_path: Path) -> None:
    write_episodes(tmp_path / "a.mcap", (plan(number) for number in range(3)))
    found = messages(tmp_path / "a.mcap")
    starts = [logged for logged, _ in found["/joint_trajectory"]]
    np.testing.assert_allclose(np.diff(starts), motion().duration + 1, atol=1e-9)
    assert [stamp(message) for _, message in found["/joint_trajectory"]] == starts
    for topic in ("/joint_trajectory", "/joint_states"):
        assert all(stamp(message) == logged for logged, message in found[topic])
    assert [json.loads(said.data)["episode"] for _, said in found["/episode"]] == [0, 1, 2]
    assert len(found["/joint_states"]) == 90


def test_uneven_times_are_kept_to_the_nanosecond(tmp_path: Path) -> None:
    time = 5 + np.cumsum([0.0, 0.01, 0.013, 0.004, 2.5])
    uneven = Motion(time, ("a",), np.arange(5.0)[:, None])
    write_motion(tmp_path / "a.mcap", uneven)
    logged = [at for at, _ in messages(tmp_path / "a.mcap")["/joint_states"]]
    np.testing.assert_allclose(logged, time - 5, atol=1e-9)


def test_joints_that_were_told_nothing_stay_where_they_are(tmp_path: Path) -> None:
    episode = recording()
    assert episode.commanded is not None
    commanded = episode.commanded.copy()
    commanded[3, 1] = np.nan
    half = Episode(episode.motion, "recorded", commanded=commanded)
    write_episodes(tmp_path / "a.mcap", half)
    ((_, trajectory),) = messages(tmp_path / "a.mcap")["/joint_trajectory"]
    assert trajectory.points[3].positions[1] == episode.state[3, 1]
    assert trajectory.points[3].positions[0] == commanded[3, 0]


def test_its_own_library_reads_it_and_the_index_is_sound(tmp_path: Path) -> None:
    write_episodes(tmp_path / "a.mcap", (plan(number, 3000) for number in range(3)))
    with Reader(tmp_path / "a.mcap") as bag:
        assert bag.message_count == 3 * (3000 + 2)
        assert sum(1 for _ in bag.messages()) == bag.message_count
    with (tmp_path / "a.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert len(summary.chunk_indexes) > 1
    assert {schema.name for schema in summary.schemas.values()} == {
        "trajectory_msgs/msg/JointTrajectory",
        "sensor_msgs/msg/JointState",
        "std_msgs/msg/String",
    }


def test_the_same_episodes_are_the_same_bytes(tmp_path: Path) -> None:
    for folder in ("one", "other"):
        (tmp_path / folder).mkdir()
        write_episodes(tmp_path / folder / "a.mcap", [plan(0), plan(1)])
    assert (tmp_path / "one" / "a.mcap").read_bytes() == (
        tmp_path / "other" / "a.mcap"
    ).read_bytes()
    write_episodes(tmp_path / "one" / "a.mcap", [plan(0), plan(2)])
    assert (tmp_path / "one" / "a.mcap").read_bytes() != (
        tmp_path / "other" / "a.mcap"
    ).read_bytes()


def test_a_motion_without_angles_is_refused(tmp_path: Path) -> None:
    landmarks = Motion(np.arange(3.0), landmark_names=("hand",), landmarks=np.zeros((3, 1, 3)))
    with pytest.raises(FormatError, match="no joint angles in it, only landmarks"):
        write_motion(tmp_path / "a.mcap", landmarks)
    assert not list(tmp_path.iterdir())


def test_what_stamps_cannot_say_is_refused(tmp_path: Path) -> None:
    ages = Motion(np.array([0.0, 9e8, 1.8e9]), ("a",), np.zeros((3, 1)), source="ages")
    write_motion(tmp_path / "a.mcap", ages)
    assert messages(tmp_path / "a.mcap")["/joint_states"][-1][0] == 1.8e9
    with pytest.raises(
        FormatError, match=r"ages: ends 1\.8e\+09 s after it begins: ROS 2's stamps"
    ):
        write_episodes(tmp_path / "b.mcap", [ages, ages])
    assert [path.name for path in tmp_path.iterdir()] == ["a.mcap"]
