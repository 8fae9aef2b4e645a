"""Looking at an arm writes nothing, whatever state the arm is in."""

from collections.abc import Callable

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver.monitor import ArmMonitor
from armsyn.driver.timing import WATCHDOG_UNITS
from armsyn.errors import (
    ArmFaultError,
    DescriptionError,
    HardwareFaultError,
    ServoMismatchError,
    ServoMissingError,
)
from firmware_sim.firmware.codes import HardwareError
from tests.driver.stepped import SteppedArm, without

READS = {0x01, 0x02, 0x82, 0x8A}
READS_1 = {0x02}
LARGE = (0.6, 0.3, -0.6, 0.9)


def instructions(stepped: SteppedArm) -> tuple[set[int], set[int]]:
    """Instructions sent in protocol 2.0, and in 1.0."""
    sent = stepped.bus.serial_port.written
    two = {packet[7] for packet in sent if packet.startswith(b"\xff\xff\xfd\x00")}
    return two, {packet[4] for packet in sent if not packet.startswith(b"\xff\xff\xfd")}


def look(stepped: SteppedArm) -> ArmMonitor:
    stepped.bus.serial_port.written.clear()
    monitor = ArmMonitor.attach(stepped.bus, stepped.description)
    monitor.read_state()
    for turn in range(monitor.polls):
        monitor.poll(turn)
    return monitor


def fault(stepped: SteppedArm) -> None:
    stepped.at(0.3, lambda: stepped.servos[2].raise_hardware_error(HardwareError.OVERLOAD))
    with pytest.raises(HardwareFaultError):
        stepped.session().run(stepped.way(*LARGE))


def leave_alone(stepped: SteppedArm) -> None:
    del stepped


def expire(stepped: SteppedArm) -> None:
    stepped.at(0.3, lambda: stepped.clock.advance(0.5))
    with pytest.raises(ArmFaultError):
        stepped.session().run(stepped.way(*LARGE))


@pytest.mark.fault(43)
@pytest.mark.parametrize("before", [leave_alone, fault, expire])
def test_nothing_is_written(stepped: SteppedArm, before: Callable[[SteppedArm], None]) -> None:
    before(stepped)
    torque, goals = stepped.torque(), stepped.value("Goal Position")
    watchdogs = stepped.value("Bus Watchdog")
    monitor = look(stepped)
    state = monitor.read_state()
    assert state.position == pytest.approx(stepped.positions(), abs=3e-3)
    assert state.fresh.all()
    assert np.isfinite(state.temperature).all()
    assert state.voltage == pytest.approx(12.0, abs=0.5)
    assert monitor.read_facts()[2].torque_enabled is bool(torque[2])
    assert instructions(stepped) == (READS, set())
    assert (stepped.torque(), stepped.value("Goal Position")) == (torque, goals)
    assert stepped.value("Bus Watchdog") == watchdogs


def test_a_fault_is_seen_and_stays(stepped: SteppedArm) -> None:
    fault(stepped)
    monitor = look(stepped)
    assert monitor.read_state().alert.tolist() == [False, False, True, *[False] * 4]
    health = monitor.poll(2)
    assert health is not None
    assert (health.row, health.hardware_error, health.torque_enabled) == (2, 0x20, False)
    assert health.bus_watchdog == WATCHDOG_UNITS
    assert stepped.torque() == [1, 1, 0, 1, 1, 1, 1]


def test_looking_keeps_armed_watchdogs_from_expiring(stepped: SteppedArm) -> None:
    fault(stepped)
    monitor = look(stepped)
    for _ in range(20):
        stepped.clock.advance(0.1)
        monitor.read_state()
    assert stepped.value("Bus Watchdog") == [WATCHDOG_UNITS] * 7


def test_a_servo_that_is_missing_has_no_angle(stepped: SteppedArm) -> None:
    stepped.servos[3].silenced = True
    monitor = look(stepped)
    assert monitor.missing == (4,)
    position = monitor.read_posture()
    assert np.flatnonzero(np.isnan(position)).tolist() == [3]
    seen = ~np.isnan(position)
    assert position[seen] == pytest.approx(stepped.description.rest[seen], abs=2e-3)
    assert [facts.servo_id for facts in monitor.read_facts()] == [1, 2, 3, 5, 6, 7]


def test_nobody_is_there(stepped: SteppedArm) -> None:
    stepped.damage = lambda _: b""
    with pytest.raises(ServoMissingError, match="armsyn scan"):
        ArmMonitor.attach(stepped.bus, stepped.description)


def test_another_model_is_not_read_as_this_one(human7: ArmDescription) -> None:
    servos = [replace(s, model="xm430-w350") if s.id == 2 else s for s in human7.servo]
    stepped = SteppedArm(replace(human7, servo=tuple(servos)))
    with pytest.raises(ServoMismatchError, match=r"servo 2 .* is an xm430-w350"):
        ArmMonitor.attach(stepped.bus, human7)


def test_an_arm_without_servos(human7: ArmDescription) -> None:
    with pytest.raises(DescriptionError, match="model only"):
        ArmMonitor.open("/nowhere", replace(human7, servo=()))


@pytest.mark.parametrize("name", ["viperx_300s", "reachy_right", "koch"])
def test_shadows_grippers_and_both_protocols(name: str) -> None:
    stepped = SteppedArm(load_arm(name))
    monitor = look(stepped)
    state = monitor.read_state()
    assert state.position == pytest.approx(stepped.description.rest, abs=6e-3)
    assert np.isfinite(state.temperature).all()
    assert set(monitor.group.ids) == {servo.id for servo in stepped.description.servo}
    two, one = instructions(stepped)
    assert two <= READS
    assert one <= READS_1
    assert bool(one) == (name == "reachy_right")


def test_one_lost_reply_is_no_missing_servo(stepped: SteppedArm) -> None:
    monitor = look(stepped)
    stepped.damage = without(5)
    state = monitor.read_state()
    assert not state.fresh[4]
    assert np.isfinite(state.position).all()
