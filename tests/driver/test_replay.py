"""Files that are made ready to be streamed."""

import dataclasses
from pathlib import Path

import msgspec
import numpy as np
import pytest

from armsyn.arm import ArmDescription
from armsyn.arm.shapes import PlaneDescription
from armsyn.driver import Ending, save_recording, straight_way
from armsyn.driver.replay import approach, expect, load_replay, looped, slowed
from armsyn.errors import CollisionError, InputError
from armsyn.motion import Motion
from armsyn.motion.formats import write_motion
from armsyn.safety import check_trajectory
from tests.driver.stepped import SteppedArm


@pytest.fixture
def way(human7: ArmDescription) -> Motion:
    return straight_way(human7.rest, human7.rest + 0.2, human7, 200.0)


def angles_of(motion: Motion) -> np.ndarray:
    assert motion.angles is not None
    return motion.angles


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_a_trajectory_comes_back_as_it_is(
    human7: ArmDescription, way: Motion, tmp_path: Path, suffix: str
) -> None:
    path = tmp_path / f"way{suffix}"
    write_motion(path, way)
    replay = load_replay(path, human7, 200.0)
    assert replay.what == "the file's angles"
    assert angles_of(replay.motion) == pytest.approx(angles_of(way), abs=1e-9)
    check_trajectory(replay.motion, human7, human7.rest)


def test_joints_in_another_order_are_sorted(
    human7: ArmDescription, way: Motion, tmp_path: Path
) -> None:
    turned = Motion(way.time, way.joint_names[::-1], angles_of(way)[:, ::-1])
    write_motion(tmp_path / "way.npz", turned)
    replay = load_replay(tmp_path / "way.npz", human7, 200.0)
    assert angles_of(replay.motion) == pytest.approx(angles_of(way), abs=1e-9)


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_of_a_recording_what_was_wanted_is_streamed(
    stepped: SteppedArm, tmp_path: Path, suffix: str
) -> None:
    session, way = stepped.session(), stepped.way(0.4, 0.0, 0.0, 0.5)
    stepped.at(0.2, lambda: stepped.clock.advance(0.012))  # two ticks are missed
    recording = session.run(way)
    assert recording.missed_ticks
    save_recording(tmp_path / f"run{suffix}", recording, stepped.description)
    replay = load_replay(tmp_path / f"run{suffix}", stepped.description, 200.0)
    assert replay.what == "what was wanted of the arm"
    assert angles_of(replay.motion) == pytest.approx(recording.commanded_rad, abs=1e-9)
    check_trajectory(replay.motion, stepped.description)


def wall_at(distance: float, way: Motion, arm: ArmDescription) -> ArmDescription:
    """The arm before a wall that the way comes as near to."""
    walled = msgspec.structs.replace(
        arm, plane=(PlaneDescription("wall", (2.0, 0.0, 0.0), (-1.0, 0.0, 0.0)),)
    )
    pairs = [row for row, pair in enumerate(walled.solids.names) if "wall" in pair]
    nearest = walled.solids.clearances(angles_of(way))[:, pairs].min() - distance
    wall = PlaneDescription("wall", (2.0 - float(nearest), 0.0, 0.0), (-1.0, 0.0, 0.0))
    return msgspec.structs.replace(arm, plane=(wall,))


def test_what_a_run_came_near_to_may_be_come_near_to_again(
    stepped: SteppedArm, tmp_path: Path
) -> None:
    """Goals between a plan's samples come a little nearer than these, and were judged as goals."""
    out = stepped.way(0.4, 0.0, 0.0, 0.5)
    recording = stepped.session().run(out)
    save_recording(tmp_path / "run.csv", recording, stepped.description)
    write_motion(tmp_path / "way.npz", out)
    back = straight_way(angles_of(out)[-1], stepped.description.rest, stepped.description, 200.0)
    stepped.session().run(back)
    stepped.description = arm = wall_at(0.0048, out, stepped.description)
    plain = load_replay(tmp_path / "way.npz", arm, 200.0)
    with pytest.raises(CollisionError, match=r"4\.8 mm near to wall .* 5\.0 mm must stay"):
        check_trajectory(plain.motion, arm, margin=plain.margin)
    again = load_replay(tmp_path / "run.csv", arm, 200.0)
    check_trajectory(again.motion, arm, margin=again.margin)
    session = stepped.session()
    with pytest.raises(CollisionError):
        session.run(again.motion)
    assert session.run(again.motion, margin=again.margin).ending is Ending.COMPLETED


def test_what_was_measured_is_smoothed_until_it_can_be_streamed(
    stepped: SteppedArm, tmp_path: Path
) -> None:
    recording = stepped.session().run(stepped.way(0.3, 0.0, 0.0, 0.4))
    observed = np.full_like(recording.commanded_rad, np.nan)  # as `armsyn record` leaves it
    recording = dataclasses.replace(recording, commanded_rad=observed)
    save_recording(tmp_path / "run.csv", recording, stepped.description)
    replay = load_replay(tmp_path / "run.csv", stepped.description, 200.0)
    assert "smoothed" in replay.what
    check_trajectory(slowed(replay.motion, 1.5, 200.0), stepped.description)
    assert angles_of(replay.motion)[-1] == pytest.approx(recording.measured_rad[-1], abs=0.005)


def test_other_joints_or_none_are_refused(
    human7: ArmDescription, way: Motion, tmp_path: Path
) -> None:
    write_motion(tmp_path / "other.npz", Motion(way.time, ("a",), angles_of(way)[:, :1]))
    with pytest.raises(InputError, match="joints are"):
        load_replay(tmp_path / "other.npz", human7, 200.0)
    hand = Motion(way.time, landmark_names=("hand",), landmarks=np.zeros((way.frames, 1, 3)))
    write_motion(tmp_path / "hand.npz", hand)
    with pytest.raises(InputError, match="landmark positions only"):
        load_replay(tmp_path / "hand.npz", human7, 200.0)


def test_twice_the_time_is_half_of_the_speed(human7: ArmDescription, way: Motion) -> None:
    slow, fast = expect(slowed(way, 2.0, 200.0), human7), expect(way, human7)
    assert slow.duration == pytest.approx(2.0 * fast.duration, abs=0.01)
    assert slow.speed == pytest.approx(0.5 * fast.speed, rel=0.01)
    assert slow.acceleration == pytest.approx(0.25 * fast.acceleration, rel=0.05)
    assert slow.highest == pytest.approx(fast.highest)


@pytest.mark.parametrize("factor", [0.0, -1.0, float("nan"), float("inf")])
def test_no_time_is_refused(way: Motion, factor: float) -> None:
    with pytest.raises(InputError, match="times its time"):
        slowed(way, factor, 200.0)


def test_more_time_than_there_is_is_refused(way: Motion) -> None:
    with pytest.raises(InputError, match="times slower is too long"):
        slowed(way, 1e308, 200.0)


def test_a_loop_goes_back_by_itself(human7: ArmDescription, way: Motion) -> None:
    three = looped(way, 3, human7, 200.0)
    check_trajectory(three, human7, human7.rest)
    ends = np.abs(angles_of(three) - angles_of(way)[-1]).max(axis=1) < 1e-9
    assert np.count_nonzero(ends) == 3
    assert looped(way, 1, human7, 200.0).frames == way.frames


def test_a_closed_loop_has_no_ways_back(human7: ArmDescription, way: Motion) -> None:
    angles = np.concatenate([angles_of(way), angles_of(way)[-2::-1]])
    closed = Motion(np.arange(len(angles)) / 200.0, way.joint_names, angles)
    assert looped(closed, 2, human7, 200.0).frames == 2 * closed.frames - 1


def test_an_arm_elsewhere_is_brought_to_the_start(human7: ArmDescription, way: Motion) -> None:
    there = approach(human7.rest - 0.1, way, human7, 200.0)
    assert there is not None
    check_trajectory(there, human7, human7.rest - 0.1)
    assert angles_of(there)[-1] == pytest.approx(angles_of(way)[0])
    assert approach(human7.rest + 0.01, way, human7, 200.0) is None
