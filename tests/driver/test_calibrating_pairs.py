"""Dual joints while an arm is calibrated: aligned, turning alike, or refused."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.arm.calibration_file import RANGE_MARGIN, with_calibration
from armsyn.driver.calibrating_pairs import ALIGNED_TICKS, align, misalignments
from armsyn.errors import ServoMismatchError
from tests.driver.set_up_bench import (
    by_rest,
    calibrator_of,
    loose,
    move,
    remounted,
)


@pytest.fixture(scope="module")
def omx() -> ArmDescription:
    return load_arm("openmanipulator_x", calibrated=False)


@pytest.fixture(scope="module")
def widowx() -> ArmDescription:
    return load_arm("widowx_250s", calibrated=False)


def test_aligned_pairs_are_left_alone(tmp_path: Path, widowx: ArmDescription) -> None:
    _, calibrator = calibrator_of(tmp_path, widowx, widowx)
    assert calibrator.mark_rest()
    assert misalignments(calibrator) == ()


@pytest.mark.parametrize("off", [-90, 40])
def test_a_pair_is_aligned_by_the_seconds_homing_offset(
    tmp_path: Path, widowx: ArmDescription, off: int
) -> None:
    lies = {servo.id: servo.rest_tick for servo in widowx.servo}
    bus, calibrator = calibrator_of(tmp_path, widowx, widowx, start=lies | {5: lies[5] + off})
    (found,) = misalignments(calibrator)
    assert (found.shadow.id, found.apart) == (5, pytest.approx(-off, abs=2))
    align(calibrator, found)
    assert bus.value(5, "Homing Offset") == found.change.wanted
    calibrator.follow_anew()
    present = calibrator.follower.ticks
    assert abs(present[5] - present[4]) <= ALIGNED_TICKS
    calibration = by_rest(calibrator)
    by_id = {servo.id: servo for servo in calibration.servo}
    assert by_id[5].homing_offset == found.change.wanted
    assert by_id[5].zero_tick == pytest.approx(by_id[4].zero_tick, abs=2)


def test_a_horn_that_is_far_off_must_be_screwed_on_anew(
    tmp_path: Path, widowx: ArmDescription
) -> None:
    bus, calibrator = loose(tmp_path, widowx, {5: 1500})
    with pytest.raises(ServoMismatchError, match="screw its horn on"):
        misalignments(calibrator)
    assert bus.value(5, "Homing Offset") == 0


@pytest.mark.parametrize(("leader", "shadow"), [(4080, 4110), (4090, 20), (20, 4070), (4093, 2)])
def test_a_pair_with_the_end_of_a_turn_between_must_be_screwed_on_anew(
    tmp_path: Path, widowx: ArmDescription, leader: int, shadow: int
) -> None:
    bus, calibrator = loose(tmp_path, widowx)
    move(bus, calibrator.follower.look, {4: leader, 5: shadow}, 3.0)
    with pytest.raises(ServoMismatchError, match=r"end.* between them.*horn on anew"):
        misalignments(calibrator)
    assert bus.value(5, "Homing Offset") == 0


def test_an_alignment_a_whole_turn_off_is_undone(tmp_path: Path, widowx: ArmDescription) -> None:
    bus, calibrator = loose(tmp_path, widowx)
    move(bus, calibrator.follower.look, {4: 2000, 5: 2040 + 4096}, 4.0)
    (found,) = misalignments(calibrator)
    with pytest.raises(ServoMismatchError, match=r"reads 409\d ticks off.*old offset is back"):
        align(calibrator, found)
    assert bus.value(5, "Homing Offset") == 0


@pytest.mark.parametrize(
    ("way", "said"), [(-1, "other way round"), (0, "horn is loose"), (2, "horn is loose")]
)
def test_pairs_that_do_not_turn_alike_are_refused(
    tmp_path: Path, widowx: ArmDescription, way: int, said: str
) -> None:
    bus, calibrator = loose(tmp_path, widowx)
    assert calibrator.mark_rest()
    began = dict(calibrator.follower.look())
    goals = {2: began[2] + 300, 3: began[3] + way * 300}
    move(bus, calibrator.follower.look, goals, 1.5)
    with pytest.raises(ServoMismatchError, match=said):
        calibrator.mark_direction("shoulder", began)


@pytest.mark.parametrize("direction", [1, -1])
def test_a_pair_is_swept_by_hand_as_one_joint(
    tmp_path: Path, widowx: ArmDescription, direction: int
) -> None:
    zeros = {"zero_tick": 2100, "direction": direction}
    real = remounted(widowx, s2=zeros, s3=zeros)
    bus, calibrator = calibrator_of(tmp_path, real, widowx)
    look = calibrator.follower.look
    assert calibrator.mark_rest()
    rest = dict(calibrator.follower.ticks)
    began = dict(look())
    move(bus, look, {2: rest[2] + direction * 300})
    assert calibrator.mark_direction("shoulder", began) == direction
    calibrator.follower.forget_range()
    ends = (rest[2] + direction * 1200, rest[2] - direction * 100)
    for tick in (*ends, rest[2]):
        move(bus, look, {2: tick}, 1.5)
    assert calibrator.mark_range("shoulder") == pytest.approx(1300 * math.tau / 4096, abs=0.02)
    calibration = calibrator.result("hand", None)
    leader, shadow = (next(s for s in calibration.servo if s.id == i) for i in (2, 3))
    for servo in (leader, shadow):
        assert (servo.direction, servo.zero_tick) == (direction, pytest.approx(2100, abs=4))
        assert servo.range_ticks == pytest.approx(sorted(ends), abs=6)
    shoulder = with_calibration(widowx, calibration).joint[1]
    highest = widowx.joint[1].rest + 1200 * math.tau / 4096 - RANGE_MARGIN
    assert shoulder.upper == pytest.approx(min(widowx.joint[1].upper, highest), abs=0.01)
    assert shoulder.upper < widowx.joint[1].upper


def test_an_alignment_that_does_not_hold_is_undone(tmp_path: Path, widowx: ArmDescription) -> None:
    bus, calibrator = loose(tmp_path, widowx)
    move(bus, calibrator.follower.look, {5: widowx.servo[4].rest_tick + 60})
    (found,) = misalignments(calibrator)
    move(bus, calibrator.follower.look, {5: widowx.servo[4].rest_tick - 60})
    with pytest.raises(ServoMismatchError, match="the old offset is back"):
        align(calibrator, found)
    assert bus.value(5, "Homing Offset") == 0
