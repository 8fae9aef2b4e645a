"""How an arm is told of: whole, damaged, and badly set up."""

import dataclasses
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver import registers as reg
from armsyn.driver.status import ArmStatus, read_status
from armsyn.driver.status_findings import Finding, find
from tests.driver.stepped import SteppedArm, without

WRITES = {0x03, 0x04, 0x05, 0x06, 0x08, 0x10, 0x83, 0x93}


def status_of(stepped: SteppedArm) -> ArmStatus:
    return read_status(stepped.bus, stepped.description, look_around=False)


def findings(stepped: SteppedArm) -> list[Finding]:
    return list(find(status_of(stepped)))


def test_a_sound_arm_has_nothing_to_say(stepped: SteppedArm, human7: ArmDescription) -> None:
    status = status_of(stepped)
    assert find(status) == ()
    np.testing.assert_allclose(status.posture, human7.rest, atol=1e-3)
    np.testing.assert_allclose(status.hand, human7.chain.forward(human7.rest).tip, atol=1e-3)
    assert (status.to_limits > 0).all()
    assert status.fitting_rate is not None
    assert status.fitting_rate > 300
    first = status.servos[0]
    assert (first.voltage, first.temperature, first.current) == (12.0, 25.0, 0.0)
    assert (first.torque, first.firmware, first.return_delay) == (False, 45, 0.0)


@pytest.mark.fault(43)
def test_nothing_is_written(stepped: SteppedArm) -> None:
    status_of(stepped)
    sent = stepped.bus.serial_port.written
    assert sent
    assert not WRITES & {packet[7] for packet in sent}


@pytest.mark.parametrize("name", ["koch", "viperx_300s", "reachy_right"])
def test_arms_of_every_kind_are_sound(name: str) -> None:
    arm = load_arm(name)
    status = status_of(SteppedArm(arm))
    assert [str(f) for f in find(status) if f.level == "problem"] == []
    assert all(servo.angle is not None for servo in status.servos)
    lacking = [f.where for f in find(status) if "no bus watchdog" in f.what]
    assert lacking == (["servo 14, 16, 17"] if name == "reachy_right" else [])


def test_a_missing_servo_is_named_and_the_rest_is_told(stepped: SteppedArm) -> None:
    stepped.damage = without(3)
    status = status_of(stepped)
    assert [str(f) for f in find(status)] == [
        "servo 3 (shoulder_rotation): no reply: check its power and cable; armsyn scan finds"
        " another ID or baud rate"
    ]
    assert np.isnan(status.posture).tolist() == [row == 2 for row in range(7)]
    assert status.hand is None
    assert status.servos[6].voltage == 12.0


def test_an_arm_fits_where_every_servo_is_as_described(stepped: SteppedArm) -> None:
    assert status_of(stepped).fits
    other = msgspec.structs.replace(stepped.description.servo[0], model="xm430-w350")
    status = status_of(stepped)
    first = dataclasses.replace(status.servos[0], described=other)
    assert not dataclasses.replace(status, servos=(first, *status.servos[1:])).fits
    stepped.damage = without(3)
    assert not status_of(stepped).fits


@pytest.mark.fault(14)
def test_nobody_at_this_baud_rate_points_to_the_scan(stepped: SteppedArm) -> None:
    stepped.damage = lambda _: b""
    (finding,) = findings(stepped)
    assert finding.level == "problem"
    assert finding.what == "no reply at 1000000 baud from any servo of human7"
    assert "armsyn scan" in finding.cure


def test_strangers_on_the_bus_are_named(stepped: SteppedArm) -> None:
    status = read_status(stepped.bus, load_arm("openmanipulator_x"))
    assert dict(status.unexpected) == {i: 1120 if i < 5 else 1020 for i in range(1, 8)}
    notes = [f for f in find(status) if f.level == "note"]
    assert [f.where for f in notes] == [f"servo {i}" for i in range(1, 8)]
    assert "--arm" in notes[0].cure


DAMAGES: dict[str, tuple[Callable[[SteppedArm], object], str, str]] = {
    "hardware error": (
        lambda arm: arm.by_id[4].memory.store("Hardware Error Status", 0x24),
        "hardware error: overheating, overload",
        "armsyn reboot",
    ),
    "watchdog expired": (
        lambda arm: arm.by_id[4].memory.store("Bus Watchdog", 255),
        "was stopped by its bus watchdog",
        "armsyn clear",
    ),
    "watchdog armed": (
        lambda arm: arm.by_id[4].memory.store("Bus Watchdog", 15),
        "its bus watchdog is armed (300 ms)",
        "armsyn clear",
    ),
    "mode": (
        lambda arm: arm.by_id[4].memory.store("Operating Mode", 1),
        "operating mode 1",
        "armsyn setup",
    ),
    "homing offset": (
        lambda arm: arm.by_id[4].memory.store("Homing Offset", 2000),
        "a homing offset of 2000, which position mode ignores",
        "within +-1024",
    ),
    "reversed": (
        lambda arm: arm.by_id[4].memory.store("Drive Mode", 1),
        "counts positions the other way round than described",
        "armsyn setup",
    ),
    "torque by goal": (
        lambda arm: arm.by_id[4].memory.store("Drive Mode", 8),
        "switches its torque on by itself",
        "armsyn setup",
    ),
    "follows another": (
        lambda arm: arm.by_id[4].memory.store("Secondary(Shadow) ID", 2),
        "obeys servo 2 as well",
        "armsyn setup",
    ),
    "too hot": (
        lambda arm: arm.by_id[4].memory.store("Temperature Limit", 25),
        "25 degrees C, its limit is 25",
        "armsyn park",
    ),
    "voltage limits": (
        lambda arm: arm.by_id[4].memory.store("Min Voltage Limit", 130),
        "12.0 V, its limits are 13.0 to",
        "12 V",
    ),
    "mute": (
        lambda arm: arm.bus.write(4, reg.X["Status Return Level"], 0),
        "answers a ping but no reads",
        "armsyn setup",
    ),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_each_problem_has_its_cure(stepped: SteppedArm, name: str) -> None:
    damage, what, cure = DAMAGES[name]
    damage(stepped)
    problems = [f for f in findings(stepped) if f.level == "problem"]
    assert len(problems) == 1, problems
    assert problems[0].where == "servo 4 (elbow_flexion)"
    assert problems[0].what.startswith(what)
    assert cure in problems[0].cure


def test_another_model_is_told_of_by_its_own_registers(human7: ArmDescription) -> None:
    wrong = tuple(
        msgspec.structs.replace(s, model="xl430-w250") if s.id == 6 else s for s in human7.servo
    )
    stepped = SteppedArm(msgspec.structs.replace(human7, servo=wrong))
    status = read_status(stepped.bus, human7, look_around=False)
    assert [f.what for f in find(status)] == ["is an xl430-w250, described as xm430-w350"]
    assert status.servos[5].current is None
    assert status.servos[5].load == 0.0


@pytest.mark.fault(16)
def test_return_delays_are_a_note_until_they_cost_the_rate(human7: ArmDescription) -> None:
    slow = findings(SteppedArm(human7, return_delay=250))
    assert [f.level for f in slow] == ["problem"] + ["note"] * 7
    assert slow[0].what.startswith("carries ")
    assert "Return Delay Time 0" in slow[0].cure
    brief = findings(SteppedArm(human7, return_delay=10))
    assert [(f.level, f.what) for f in brief] == [
        ("note", "waits 20 us before it answers, described 0")
    ] * 7


@pytest.mark.fault(15)
def test_a_slow_adapter_is_a_problem_where_it_costs_the_rate(stepped: SteppedArm) -> None:
    stepped.bus.latency = 0.016
    (finding,) = findings(stepped)
    assert finding.level == "problem"
    assert finding.what == "its adapter keeps bytes for 16 ms"
    assert "latency_timer" in finding.cure


def test_a_joint_beyond_its_range_is_named(human7: ArmDescription) -> None:
    elbow = human7.joint[3]
    narrow = msgspec.structs.replace(elbow, lower=elbow.rest - 0.2, upper=elbow.rest - 0.1)
    joints = (*human7.joint[:3], narrow, *human7.joint[4:])
    stepped = SteppedArm(human7)
    found = read_status(
        stepped.bus, msgspec.structs.replace(human7, joint=joints), look_around=False
    )
    (finding,) = find(found)
    assert (finding.level, finding.where) == ("problem", "elbow_flexion")
    assert finding.what == "at 32.2 degrees, 5.7 beyond its limit"
    assert found.to_limits[3] == pytest.approx(-0.1, abs=1e-3)


def test_pairs_that_do_not_hang_together_are_named() -> None:
    stepped = SteppedArm(load_arm("viperx_300s"))
    stepped.by_id[3].memory.store("Secondary(Shadow) ID", 255)
    stepped.by_id[4].memory.store("Torque Enable", 1)
    problems = [str(f) for f in findings(stepped) if f.level == "problem"]
    assert any("does not follow servo 2: its Secondary ID is 255" in p for p in problems)
    assert any("its torque is off, that of servo 4 on the same joint is on" in p for p in problems)
