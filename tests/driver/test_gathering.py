"""The health of each servo by one read of registers that lie apart."""

from __future__ import annotations

import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver import Ending
from armsyn.driver.indirect import IndirectBlock
from armsyn.driver.path import straight_way
from armsyn.driver.servos import ServoGroup
from armsyn.driver.transactions import Bus
from armsyn.errors import HardwareFaultError
from tests.driver.stepped import REPLY_HEADER, SteppedArm

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


def test_a_restart_into_torque_is_told_by_the_watchdog(stepped: SteppedArm) -> None:
    """Its indirect data read 0, which is no voltage."""
    servo = stepped.by_id[5]
    servo.memory.store("Startup Configuration", 1)  # torque on at power-on
    stepped.at(0.3, servo.reboot)
    with pytest.raises(HardwareFaultError, match=r"servo 5 .* has lost its bus watchdog: it rest"):
        stepped.session().run(stepped.way(0.3))
    assert servo.memory.value("Torque Enable") == 1


def test_a_restart_is_told_where_its_torque_cannot_be_read(stepped: SteppedArm) -> None:
    def lose(data: bytes) -> bytes:
        """Replies of servo 5 with the 7 bytes from Torque Enable to Hardware Error Status."""
        first, *replies = data.split(REPLY_HEADER)
        kept = (reply for reply in replies if reply[:3] != bytes((5, 7 + 4, 0)))
        return first + b"".join(REPLY_HEADER + reply for reply in kept)

    stepped.at(0.3, stepped.by_id[5].reboot)
    stepped.at(0.3, lambda: setattr(stepped, "damage", lose))
    with pytest.raises(HardwareFaultError, match=r"servo 5 .* has lost its bus watchdog: it rest"):
        stepped.session().run(stepped.way(0.3))


def test_a_servo_that_restarts_before_its_watchdog_is_armed_is_pointed(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    names: list[str] = []
    original = ServoGroup.set

    def restarts(group: ServoGroup, name: str, values: dict[int, int]) -> None:
        if not names:
            stepped.by_id[5].reboot()
            stepped.clock.advance(1.0)
        names.append(name)
        original(group, name, values)

    session = stepped.session()
    monkeypatch.setattr(ServoGroup, "set", restarts)
    assert session.run(stepped.way(0.3)).ending is Ending.COMPLETED
    assert names.index("Bus Watchdog") < names.index("Torque Enable")
    assert pointers(stepped, 5) == POINTERS


def test_addresses_that_another_program_takes_are_left_to_it(stepped: SteppedArm) -> None:
    servo, session = stepped.by_id[5], stepped.session()

    def take() -> None:
        for number in range(1, 7):  # bytes that read 0
            servo.memory.store(f"Indirect Address {number}", 230)
        servo._reader.forget()
        stepped.bus.serial_port.written.clear()

    stepped.at(0.3, take)
    assert session.run(stepped.way(0.6)).ending is Ending.COMPLETED
    sent = stepped.bus.serial_port.written
    assert reads(stepped) >= {(5, 64, 7), (5, 98, 1), (5, 144, 3), (4, 224, 6)}
    assert not {(4, 64, 7), (4, 98, 1)} & reads(stepped)
    asked = sum(b"\xff\xff\xfd\x00\x05\x07\x00\x02\xe0\x00" in packet for packet in sent)
    assert asked == 1  # and never again
    assert session._joints.voltage == pytest.approx([12.0] * 7, abs=0.6)
    assert session._joints.polls == len(IDS) + 2


def damaging(stepped: SteppedArm) -> None:
    """Let noise strike the next packet on its way to the servos."""
    stepped.port.simulation.inject("crc-error:to=servos,count=1")


def test_pointers_that_noise_takes_are_written_again(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = IndirectBlock.point

    def point(block: IndirectBlock, bus: Bus, servo_ids: tuple[int, ...]) -> tuple[int, ...]:
        damaging(stepped)
        return original(block, bus, servo_ids)

    monkeypatch.setattr(IndirectBlock, "point", point)
    moved(stepped)
    assert {pointers(stepped, i) for i in IDS} == {POINTERS}


def test_a_servo_that_takes_no_pointers_is_asked_register_by_register(stepped: SteppedArm) -> None:
    servo = stepped.by_id[4]
    original = servo.write

    def write(at: int, data: bytes) -> object:
        return 0 if at == 168 else original(at, data)

    servo.write = write  # type: ignore[assignment, method-assign]
    moved(stepped)
    assert reads(stepped) >= {(4, 64, 7), (4, 98, 1), (4, 144, 3), (3, 224, 6)}
    assert (4, 224, 6) not in reads(stepped)


@pytest.mark.parametrize("name", ["Profile Velocity", "Bus Watchdog", "Torque Enable"])
def test_what_noise_takes_is_written_again(
    stepped: SteppedArm, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    written: list[str] = []
    original = ServoGroup.write

    def write(group: ServoGroup, register: str, values: dict[int, int]) -> None:
        if register == name and name not in written:
            damaging(stepped)
        written.append(register)
        original(group, register, values)

    session = stepped.session()
    monkeypatch.setattr(ServoGroup, "write", write)
    assert session.run(stepped.way(0.3)).ending is Ending.COMPLETED
    assert written.count(name) == {"Torque Enable": 2}.get(name, 3)  # others are put back, too


def test_a_shadow_keeps_its_own_value_when_its_leader_is_told_again() -> None:
    stepped = SteppedArm(load_arm("viperx_300s"))
    group = stepped.session(50.0)._joints.group
    shadow = next(servo for servo in group.servos if servo.shadow_of is not None)
    leader = stepped.by_id[shadow.shadow_of or 0]
    original, left = leader.write, [1]

    def overhears_once(at: int, data: bytes) -> object:
        return 0 if at == 112 and left and left.pop() else original(at, data)

    leader.write = overhears_once  # type: ignore[assignment, method-assign]
    values = {leader.servo_id: 100, shadow.id: 60}
    group.set("Profile Velocity", values)
    assert group.read("Profile Velocity", values) == values
