"""Servos of a rig file in an arm: sag, fall and overload as a client reads them."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.arm.rig import build_rig
from firmware_sim.assembly import build_simulation
from firmware_sim.errors import PlantError
from firmware_sim.firmware.servo import Servo
from firmware_sim.firmware.world import World
from firmware_sim.rig.file import read_rig
from firmware_sim.rig.settings import Rig

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"
TORQUE, GOAL, POSITION, LOAD, HARDWARE_ERROR = 64, 116, 132, 126, 70
STRETCHED = [1.5, 0.1, 0.0, 0.3, 0.0, 0.0, 0.0]


def value(servo: Servo, address: int, size: int) -> int:
    _, data = servo.read(address, size)
    return int.from_bytes(data, "little", signed=size > 1)


def position(servo: Servo) -> int:
    return value(servo, POSITION, 4)


def raised(arm: ArmDescription, tmp_path: Path) -> Rig:
    """The rig of human7 with its rest posture stretched out forward."""
    joints = [
        msgspec.structs.replace(joint, rest=rest)
        for joint, rest in zip(arm.joint, STRETCHED, strict=True)
    ]
    ticks = arm.calibration.to_ticks(np.array(STRETCHED)).tolist()
    servos = [
        msgspec.structs.replace(servo, rest_tick=tick)
        for servo, tick in zip(arm.servo, ticks, strict=True)
    ]
    arm = msgspec.structs.replace(arm, joint=tuple(joints), servo=tuple(servos))
    path = tmp_path / "human7.rig.toml"
    path.write_text(build_rig(arm))
    return read_rig(path)


@pytest.fixture
def human7(tmp_path: Path) -> World:
    rig = raised(load_arm("human7", CALIBRATION), tmp_path)
    world = build_simulation(rig, mujoco=True).bus.world
    for servo in world.servos:
        servo.write(TORQUE, b"\x01")
    return world


def test_a_raised_arm_sags_and_says_so(human7: World) -> None:
    shoulder = human7.servos[0]
    start = position(shoulder)
    human7.advance(2.0)
    assert start - position(shoulder) == pytest.approx(36, abs=8)  # 3.2 degrees of 4096 a turn
    # 2.8 N m of a stall torque of 10.6 N m at 4.4 A: 1.2 A, in counts of 2.69 mA, upwards
    assert value(shoulder, LOAD, 2) == pytest.approx(432, rel=0.1)
    assert not any(value(servo, HARDWARE_ERROR, 1) for servo in human7.servos)


def test_it_falls_when_its_torque_drops(human7: World) -> None:
    human7.advance(1.0)
    for servo in human7.servos:
        servo.write(TORQUE, b"\x00")
    held = position(human7.servos[0])
    human7.advance(1.2)
    assert position(human7.servos[0]) < held - 100
    human7.advance(8.0)
    assert abs(position(human7.servos[0]) - 2048) < 200
    assert value(human7.servos[0], LOAD, 2) == 0


def test_it_overloads_when_it_is_pushed_and_then_falls(human7: World) -> None:
    human7.advance(1.0)
    shoulder = human7.servos[0]
    shoulder.apply_load(9.0)
    human7.advance(8.0)
    assert value(shoulder, HARDWARE_ERROR, 1) == 0x20
    assert value(shoulder, TORQUE, 1) == 0
    shoulder.apply_load(0.0)
    human7.advance(16.0)
    assert abs(position(shoulder) - 2048) < 400


def test_it_reaches_its_goals(human7: World) -> None:
    for servo, rest in zip(human7.servos, (2129, 2292, 2454, 2414, 2048, 2087, 2032), strict=True):
        servo.write(112, (40).to_bytes(4, "little"))  # profile velocity
        servo.write(GOAL, rest.to_bytes(4, "little"))
    human7.advance(5.0)
    for servo, rest in zip(human7.servos, (2129, 2292, 2454, 2414, 2048, 2087, 2032), strict=True):
        assert abs(position(servo) - rest) < 25


def test_reverse_mode_turns_the_horn_not_the_arm(tmp_path: Path) -> None:
    """A servo in reverse mode with its direction turned, too, holds the same arm as before."""
    arm = load_arm("human7", CALIBRATION)
    plain = raised(arm, tmp_path)
    servo = msgspec.structs.replace(
        arm.servo[0], drive_mode=1, direction=-1, zero_tick=2048, rest_tick=1967
    )
    turned = raised(msgspec.structs.replace(arm, servo=(servo, *arm.servo[1:])), tmp_path)
    found = []
    for rig in (plain, turned):
        world = build_simulation(rig, mujoco=True).bus.world
        world.advance(0.2)
        found.append([position(servo) - 2048 for servo in world.servos])
    assert found[0][0] < 978 - 50  # it falls
    assert found[1][0] == pytest.approx(-found[0][0], abs=2)
    assert found[1][1:] == pytest.approx(found[0][1:], abs=2)


def test_a_gripper_stays_independent(tmp_path: Path) -> None:
    rig = raised(load_arm("human7", CALIBRATION), tmp_path)
    text = (tmp_path / "human7.rig.toml").read_text()
    gripper = '[[servo]]\nid = 20\nmodel = "xl430-w250"\nstart_tick = 1000\n\n'
    (tmp_path / "gripped.toml").write_text(gripper + text)
    rig = read_rig(tmp_path / "gripped.toml")
    world = build_simulation(rig, mujoco=True).bus.world
    world.advance(2.0)
    assert position(world.servos[0]) == 1000
    assert abs(position(world.servos[1]) - 2048) < 400  # the arm hangs


def test_a_rig_without_bodies(tmp_path: Path) -> None:
    rig = raised(load_arm("human7", CALIBRATION), tmp_path)
    with pytest.raises(PlantError, match="needs a rig file"):
        build_simulation(Rig(rig.servos), mujoco=True)
