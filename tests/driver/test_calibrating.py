"""Calibrating a limp arm that a (simulated) hand moves: zero, direction, range, pairs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.arm.calibration_file import angle_of, with_calibration
from armsyn.driver.calibrating import LEAST_MOVE, ArmCalibrator
from armsyn.errors import ArmFaultError, ServoMismatchError, TorqueOnError
from tests.driver.set_up_bench import (
    arm_bench,
    by_rest,
    calibrator_of,
    move,
    remounted,
)


@pytest.fixture(scope="module")
def omx() -> ArmDescription:
    return load_arm("openmanipulator_x", calibrated=False)


@pytest.fixture(scope="module")
def widowx() -> ArmDescription:
    return load_arm("widowx_250s", calibrated=False)


def test_zero_comes_from_the_rest_posture(tmp_path: Path, omx: ArmDescription) -> None:
    real = remounted(omx, s11={"zero_tick": 2200}, s13={"zero_tick": 1900})
    _, calibrator = calibrator_of(tmp_path, real, omx)
    calibration = by_rest(calibrator)
    assert [s.zero_tick for s in calibration.servo] == [s.zero_tick for s in real.servo]
    found = with_calibration(omx, calibration)
    assert [s.rest_tick for s in found.servo] == [s.rest_tick for s in real.servo]
    assert all(servo.range_ticks is None for servo in calibration.servo)


def test_servo_facts_are_kept(tmp_path: Path, omx: ArmDescription) -> None:
    registers = {12: {"Drive Mode": 4, "Homing Offset": -20}}
    _, calibrator = calibrator_of(tmp_path, omx, omx, registers=registers)
    servo = by_rest(calibrator).servo[1]
    assert (servo.id, servo.model, servo.model_number, servo.firmware) == (
        12,
        "xm430-w350",
        1020,
        45,
    )
    assert (servo.drive_mode, servo.homing_offset, servo.operating_mode) == (4, -20, 3)


def test_an_arm_that_moves_is_not_taken(tmp_path: Path, omx: ArmDescription) -> None:
    bus, calibrator = calibrator_of(tmp_path, omx, omx)
    bus.port.simulation.inject("hand:id=12,to=1800,speed=1,for=3")
    bus.wait(0.2)
    assert not calibrator.mark_rest()
    bus.wait(3.0)
    assert calibrator.mark_rest()


def test_nothing_is_written(tmp_path: Path, omx: ArmDescription) -> None:
    bus, calibrator = calibrator_of(tmp_path, omx, omx)
    writes: list[int] = []
    for servo in bus.port.bus.servos:
        original = servo.write
        servo.write = lambda at, data, o=original, **k: (writes.append(at), o(at, data, **k))[1]  # type: ignore[assignment, method-assign, misc]
    by_rest(calibrator)
    move(bus, calibrator.follower.look, {11: 2500})
    assert not writes


@pytest.mark.parametrize("direction", [1, -1])
def test_directions_and_ranges_by_hand(tmp_path: Path, omx: ArmDescription, direction: int) -> None:
    real = remounted(omx, s12={"direction": direction, "zero_tick": 2100})
    bus, calibrator = calibrator_of(tmp_path, real, omx)
    assert calibrator.mark_rest()
    rest = dict(calibrator.follower.ticks)
    lower, upper = omx.joint[1].lower, omx.joint[1].upper
    ends = [round(2100 + direction * angle / (math.tau / 4096)) for angle in (lower, upper)]
    began = dict(calibrator.follower.look())
    move(bus, calibrator.follower.look, {12: rest[12] + direction * 300})
    assert calibrator.mark_direction("joint2", began) == direction
    calibrator.follower.forget_range()
    for tick in ends:
        move(bus, calibrator.follower.look, {12: tick}, 1.5)
    calibrator.mark_range("joint2")
    move(bus, calibrator.follower.look, {12: rest[12]}, 1.5)
    away = calibrator.away_from_rest()
    assert away is not None
    assert max(map(abs, away.values())) < 0.01
    calibration = calibrator.result("hand", None)
    servo = calibration.servo[1]
    assert (servo.direction, servo.zero_tick) == (direction, 2100)
    assert servo.range_ticks is not None
    found = sorted(angle_of(servo, tick) for tick in servo.range_ticks)
    assert found == pytest.approx([lower, upper], abs=0.01)


def test_a_joint_that_hardly_moved_shows_nothing(tmp_path: Path, omx: ArmDescription) -> None:
    bus, calibrator = calibrator_of(tmp_path, omx, omx)
    assert calibrator.mark_rest()
    began = dict(calibrator.follower.look())
    move(bus, calibrator.follower.look, {11: 2048 + 80})
    assert calibrator.mark_direction("joint1", began) == 0
    assert 0 < calibrator.mark_range("joint1") < LEAST_MOVE
    assert calibrator.result("hand", None).servo[0].range_ticks is None


@pytest.mark.parametrize("zero", [3300, 4000, 100, 700])
def test_a_range_across_the_end_of_the_turn_is_followed(
    tmp_path: Path, omx: ArmDescription, zero: int
) -> None:
    real = remounted(omx, s11={"zero_tick": zero})
    bus, calibrator = calibrator_of(tmp_path, real, omx)
    assert calibrator.mark_rest()
    calibrator.follower.forget_range()
    for tick in (zero + 1000, zero - 1000, zero):
        move(bus, calibrator.follower.look, {11: tick}, 1.5)
    assert calibrator.mark_range("joint1") == pytest.approx(2000 * math.tau / 4096, abs=0.02)
    servo = calibrator.result("hand", None).servo[0]
    assert servo.zero_tick == zero
    assert servo.range_ticks == pytest.approx((zero - 1000, zero + 1000), abs=6)


class Folding:
    """A servo that shows one turn only, whatever it has turned."""

    def __init__(self, calibrator: ArmCalibrator) -> None:
        self._read = calibrator.group.read

    def __call__(self, name: str, ids: Any = None) -> dict[int, int]:
        values = self._read(name, ids)
        return {i: v % 4096 for i, v in values.items()} if name == "Present Position" else values


@pytest.mark.parametrize("zero", [4000, 100])
def test_servos_that_fold_while_they_are_turned_are_unfolded(
    tmp_path: Path, omx: ArmDescription, zero: int
) -> None:
    real = remounted(omx, s11={"zero_tick": zero})
    bus, calibrator = calibrator_of(tmp_path, real, omx)
    calibrator.group.read = Folding(calibrator)  # type: ignore[method-assign]
    assert calibrator.mark_rest()
    for tick in (zero + 1500, zero - 1500):
        move(bus, calibrator.follower.look, {11: tick}, 2.0)
    calibrator.mark_range("joint1")
    servo = calibrator.result("hand", None).servo[0]
    assert servo.range_ticks == pytest.approx((zero - 1500, zero + 1500), abs=6)


def test_an_arm_that_was_turned_round_before_is_taken_in_its_first_turn(
    tmp_path: Path, omx: ArmDescription
) -> None:
    bus, calibrator = calibrator_of(tmp_path, omx, omx)
    move(bus, calibrator.follower.look, {11: 2048 + 4096}, 3.0)
    assert calibrator.follower.ticks[11] == pytest.approx(2048 + 4096, abs=4)
    assert by_rest(calibrator).servo[0].zero_tick == pytest.approx(2048, abs=4)


@pytest.mark.parametrize("turned", [0, 4096])
@pytest.mark.parametrize(("offset", "tick"), [(300, 4000), (-300, 100), (300, 1000), (-300, 3000)])
def test_the_encoders_turn_is_what_a_servo_folds_to_whatever_its_homing_offset(
    tmp_path: Path, omx: ArmDescription, offset: int, tick: int, turned: int
) -> None:
    registers = {11: {"Homing Offset": offset}}
    bus, calibrator = calibrator_of(tmp_path, omx, omx, registers=registers)
    move(bus, calibrator.follower.look, {11: tick + offset + turned}, 4.0)
    servo = by_rest(calibrator).servo[0]
    calibrator.group.set("Torque Enable", {11: 1})
    present = calibrator.group.read("Present Position", (11,))[11]  # on its way to its old goal
    assert servo.zero_tick == pytest.approx(present, abs=60)
    assert servo.zero_tick == pytest.approx(tick + offset, abs=6)


@pytest.mark.parametrize(("offset", "tick"), [(300, 4000), (-300, 100)])
def test_a_homing_offset_is_no_turn(
    tmp_path: Path, omx: ArmDescription, offset: int, tick: int
) -> None:
    registers = {11: {"Homing Offset": offset, "Operating Mode": 4}}
    bus, calibrator = calibrator_of(tmp_path, omx, omx, registers=registers)
    move(bus, calibrator.follower.look, {11: tick + offset}, 3.0)
    assert by_rest(calibrator).servo[0].zero_tick == pytest.approx(tick + offset, abs=4)
    whole = 4096 if offset < 0 else -4096
    move(bus, calibrator.follower.look, {11: tick + offset + whole}, 3.0)
    with pytest.raises(ServoMismatchError, match="more than a turn"):
        calibrator.mark_rest()


def test_turned_far_while_nobody_looked_is_refused(tmp_path: Path, omx: ArmDescription) -> None:
    bus, calibrator = calibrator_of(tmp_path, omx, omx)
    bus.port.simulation.inject("hand:id=11,to=600,speed=8,for=2")
    bus.wait(2.0)
    with pytest.raises(ArmFaultError, match=r"servo 11 \(joint1\) was not read for"):
        calibrator.follower.look()


def test_single_answers_may_be_lost(tmp_path: Path, omx: ArmDescription) -> None:
    bus, calibrator = calibrator_of(tmp_path, omx, omx)
    bus.port.simulation.inject("lost-replies:id=12,count=3")
    calibrator.follower.look()
    calibrator.follower.look()
    assert by_rest(calibrator).servo[1].zero_tick == 2048


@pytest.mark.fault(22)
def test_torque_is_refused_and_never_dropped(tmp_path: Path, omx: ArmDescription) -> None:
    bus = arm_bench(tmp_path, omx.servo)
    bus.port.bus.servos[2].write(64, b"\1")
    with pytest.raises(TorqueOnError, match=r"servo 13 \(joint3\).*armsyn release"):
        ArmCalibrator(bus, omx)
    assert bus.value(13, "Torque Enable") == 1


@pytest.mark.parametrize(
    ("registers", "said"),
    [
        ({"Operating Mode": 1}, "operating mode 1"),
        ({"Drive Mode": 1}, "other way round"),
        ({"Homing Offset": 2000}, "homing offset of 2000"),
    ],
)
def test_servos_that_are_not_set_up_are_sent_to_setup(
    tmp_path: Path, omx: ArmDescription, registers: dict[str, int], said: str
) -> None:
    bus = arm_bench(tmp_path, omx.servo, {12: registers})
    with pytest.raises(ServoMismatchError, match=f"{said}.*armsyn setup"):
        ArmCalibrator(bus, omx)


def test_protocol_1_and_coarse_encoders(tmp_path: Path) -> None:
    arm = load_arm("reachy_right", calibrated=False)
    bus, calibrator = calibrator_of(tmp_path, arm, arm)
    assert calibrator.mark_rest()
    rest = dict(calibrator.follower.ticks)
    began = dict(calibrator.follower.look())
    leader = calibrator.servos_of("forearm_yaw")[0]
    assert leader.protocol == 1
    move(bus, calibrator.follower.look, {leader.id: rest[leader.id] - 150})
    assert calibrator.mark_direction("forearm_yaw", began) == -1
    zeros = [servo.zero_tick for servo in calibrator.result("hand", None).servo]
    assert zeros == pytest.approx([servo.zero_tick for servo in arm.servo], abs=1)
