"""The health of each servo by one read of registers that lie apart."""

from __future__ import annotations

import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver import Ending
from armsyn.driver.path import straight_way
from tests.driver.stepped import SteppedArm

IDS = tuple(range(1, 8))
POINTERS = (64, 70, 98, 144, 145, 146)
"""Torque Enable, Hardware Error Status, Bus Watchdog, Present Input Voltage, its temperature."""


def reads(stepped: SteppedArm) -> set[tuple[int, int, int]]:
    """ID, address and size of the reads of single servos that were sent."""
    found = set()
    for packet in stepped.bus.serial_port.written:
        for part in packet.split(b"\xff\xff\xfd\x00")[1:]:
            if part[3] == 0x02:
                found.add((part[0], part[4] | part[5] << 8, part[6] | part[7] << 8))
    return found


def pointers(stepped: SteppedArm, servo_id: int) -> tuple[int, ...]:
    memory = stepped.by_id[servo_id].memory
    return tuple(memory.value(f"Indirect Address {n}") for n in range(1, 7))


def moved(stepped: SteppedArm) -> None:
    arm, session = stepped.description, stepped.session()
    stepped.bus.serial_port.written.clear()
    goal = arm.rest.copy()
    goal[0] += 0.3
    way = straight_way(session.read_posture(), goal, arm, 200.0)
    assert session.run(way).ending is Ending.COMPLETED


def test_each_servo_is_asked_once_for_all_there_is(stepped: SteppedArm) -> None:
    moved(stepped)
    assert {pointers(stepped, i) for i in IDS} == {POINTERS}
    assert reads(stepped) >= {(i, 224, 6) for i in IDS}
    assert not {(i, address, size) for i in IDS for address, size in ((98, 1), (144, 3))} & reads(
        stepped
    )


def test_what_comes_that_way_is_what_the_registers_hold(stepped: SteppedArm) -> None:
    session = stepped.session()
    session.run(stepped.way(0.3))
    joints = session._joints
    for turn in range(joints.polls):
        health = joints.poll(turn)
        assert health is not None
        assert health.torque_enabled
        assert (health.hardware_error, health.bus_watchdog) == (0, 0)
        assert health.voltage == pytest.approx(12.0, abs=0.6)
        assert health.temperature == pytest.approx(25.0, abs=10.0)
    assert joints.polls == len(IDS)


def test_a_servo_that_holds_already_is_asked_register_by_register(stepped: SteppedArm) -> None:
    held = stepped.by_id[4]
    present = stepped.session()._joints.group
    present.set("Goal Position", present.read("Present Position", (4,)))
    present.set("Torque Enable", {4: 1})
    before = pointers(stepped, 4)
    moved(stepped)
    assert pointers(stepped, 4) == before != POINTERS
    assert reads(stepped) >= {(4, 64, 7), (4, 98, 1), (4, 144, 3), (3, 224, 6)}
    assert held.memory.value("Torque Enable") == 1
    moved(stepped)  # all hold: those that were pointed are still read that way
    assert reads(stepped) >= {(4, 98, 1), (3, 224, 6)}
    assert (3, 98, 1) not in reads(stepped)


def test_early_x330_have_them_elsewhere() -> None:
    arm: ArmDescription = load_arm("koch")
    early = [servo.id for servo in arm.leaders if "330" in servo.model][-1]
    stepped = SteppedArm(arm, firmware={early: 52})
    moved(stepped)
    assert pointers(stepped, early) == POINTERS
    assert (early, 208, 6) in reads(stepped)
    assert any(address == 224 for _, address, _ in reads(stepped))
