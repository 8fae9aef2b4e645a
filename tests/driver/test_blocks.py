"""Blocks that are read in one go: where they lie, how they are decoded, and when they are fast."""

import re
import struct

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription, load_arm
from armsyn.driver import Ending
from armsyn.driver import registers as reg
from armsyn.driver.blocks import HEALTH_BLOCKS, STATE_BLOCKS, Health, state_plans
from armsyn.driver.joints import watched_servos
from armsyn.driver.parser import StatusPacket
from armsyn.driver.path import straight_way
from armsyn.driver.registers import AX, LAYOUTS, MX1, XL320, Layout, X
from armsyn.driver.servos import ServoGroup
from tests.driver.stepped import SteppedArm, without

MX_IDS = (7, 8)
IN_STATE = {
    X: ("Present Current", "Present Velocity", "Present Position"),
    XL320: ("Present Velocity", "Present Position"),
    MX1: ("Present Velocity", "Present Position", "Present Input Voltage", "Present Temperature"),
    AX: ("Present Velocity", "Present Position", "Present Input Voltage", "Present Temperature"),
}
IN_HEALTH = ("Torque Limit", "Moving Speed", "Present Input Voltage", "Present Temperature")


def filled(layout: Layout, address: int, size: int, values: dict[str, int]) -> bytes:
    """Bytes of a block that hold registers, by the layout's own rows."""
    data = bytearray(size)
    for name, value in values.items():
        row = layout[name]
        start = row.address - address
        assert 0 <= start <= size - row.size, name
        data[start : start + row.size] = row.encode(value)
    return bytes(data)


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: str(layout.name))
def test_states_are_decoded_by_the_layouts_rows(layout: Layout) -> None:
    block = STATE_BLOCKS[layout]
    assert layout[block.name].address == block.address
    values = {"Present Velocity": -37, "Present Position": 815}
    if layout is X:
        values["Present Current"] = -44
    if "Present Input Voltage" in IN_STATE[layout]:
        values |= {"Present Input Voltage": 119, "Present Temperature": 41}
    decoded = block.decode(filled(layout, block.address, block.size, values))
    assert decoded[:3] == (values.get("Present Current", 0), -37, 815)
    assert decoded[3:] == ((pytest.approx(11.9), 41.0) if layout in (MX1, AX) else ())


def test_an_mx_counts_below_zero_and_an_ax_does_not() -> None:
    data = struct.pack("<HHHBB", 0xFFFE, 0, 0, 120, 40)
    assert STATE_BLOCKS[MX1].decode(data)[2] == -2
    assert STATE_BLOCKS[AX].decode(data)[2] == 0xFFFE


def health(layout: Layout, values: dict[str, int], error: int = 0) -> Health:
    """All parts of a family's health, out of the same registers."""
    whole = Health(3)
    for block in HEALTH_BLOCKS[layout]:
        assert layout[block.name].address == block.address
        ends = block.address + block.size
        inside = {n: v for n, v in values.items() if block.address <= layout[n].address < ends}
        data = filled(layout, block.address, block.size, inside)
        part = block.decode(3, StatusPacket(1, error, data, 1 if layout in (MX1, AX) else 2))
        for name, value in part._asdict().items():
            if value is not None and not np.isnan(value):
                whole = whole._replace(**{name: value})
    return whole


def test_health_of_the_x_series() -> None:
    values = {"Torque Enable": 1, "Hardware Error Status": 0x24, "Bus Watchdog": -1}
    found = health(X, values | {"Present Input Voltage": 118, "Present Temperature": 52})
    assert (found.row, found.torque_enabled, found.hardware_error) == (3, True, 0x24)
    assert (found.bus_watchdog, found.temperature) == (-1, 52.0)
    assert found.voltage == pytest.approx(11.8)


@pytest.mark.parametrize("layout", [XL320, MX1, AX], ids=lambda layout: str(layout.name))
@pytest.mark.parametrize(
    ("torque", "limit", "holds"), [(1, 1023, True), (1, 0, False), (0, 1023, False)]
)
def test_health_of_older_families(layout: Layout, torque: int, limit: int, holds: bool) -> None:
    values = {"Torque Enable": torque, "Torque Limit": limit, "Moving Speed": 300}
    values |= {"Present Input Voltage": 75, "Present Temperature": 60}
    error = 0
    if layout is XL320:
        values["Hardware Error Status"] = 0x02
    else:
        error = 0x04 | 0x40  # overheating; and an instruction error, which is none of the servo's
    found = health(layout, values, error)
    assert (found.torque_enabled, found.hardware_error) == (holds, 0x04)
    assert (found.moving_speed, found.temperature, found.bus_watchdog) == (300, 60.0, None)
    assert found.voltage == pytest.approx(7.5)


def plans(stepped: SteppedArm, *, known: bool = True) -> dict[tuple[str, int], tuple[int, ...]]:
    servos = stepped.description.leaders
    firmware = {s.id: stepped.by_id[s.id].model.firmware for s in servos} if known else {}
    group = ServoGroup(stepped.bus, servos, firmware)
    return {(plan.kind, plan.address): plan.ids for plan in state_plans(group)}


def test_new_firmware_is_read_fast(human7: ArmDescription) -> None:
    ids = tuple(range(1, 8))
    assert plans(SteppedArm(human7)) == {("fast", 126): ids}
    assert plans(SteppedArm(human7), known=False) == {("sync", 126): ids}
    assert plans(SteppedArm(human7, firmware={5: 42})) == {("sync", 126): ids}


def test_families_are_read_apart() -> None:
    assert plans(SteppedArm(load_arm("reachy_right"))) == {
        ("sync", 126): (10, 11, 12, 13, 15),  # no MX answers fast reads
        ("single", 36): (14, 16),
    }
    assert plans(SteppedArm(load_arm("koch"))) == {("fast", 126): (1, 2, 3, 4, 5)}


def test_leaders_come_first() -> None:
    arm = load_arm("viperx_300s")
    assert [servo.id for servo in watched_servos(arm)] == [1, 2, 4, 6, 7, 8, 3, 5, 9]


def instructions(stepped: SteppedArm) -> list[int]:
    """What reads states: fast sync read or sync read of 10 bytes from 126."""
    reads = [p for p in stepped.bus.serial_port.written if b"\x7e\x00\x0a\x00" in p]
    return [0x8A if b"\x8a\x7e\x00" in packet else 0x82 for packet in reads]


def test_a_bad_line_is_no_longer_read_fast(stepped: SteppedArm) -> None:
    session = stepped.session()
    count = iter(range(10**6))
    lose = without(2)
    stepped.bus.serial_port.written.clear()
    stepped.damage = lambda data: lose(data) if next(count) % 19 == 0 else data
    recording = session.run(stepped.way(0.6, 0.3, -0.6, 0.9))
    assert recording.ending is Ending.COMPLETED
    used = instructions(stepped)
    assert used[0] == 0x8A
    assert used[-1] == 0x82
    alone = recording.stale[recording.stale.any(axis=1)][-1]
    assert np.flatnonzero(alone).tolist() == [1]  # and takes nobody with it


def test_a_good_line_is_read_fast_throughout(stepped: SteppedArm) -> None:
    session = stepped.session()
    stepped.bus.serial_port.written.clear()
    session.run(stepped.way(0.3))
    assert set(instructions(stepped)) == {0x8A}


def with_two_mx() -> ArmDescription:
    """ViperX-300s with two MX-28 of protocol 1.0 for a wrist."""
    arm = load_arm("viperx_300s")
    mx = {"model": "mx-28", "protocol": 1, "drive_mode": 0}
    servos = (replace(servo, **mx) if servo.id in MX_IDS else servo for servo in arm.servo)
    return replace(arm, servo=tuple(servos))


def bulk_reads(stepped: SteppedArm) -> list[bool]:
    """Whether the states of the MX were read in bulk, cycle by cycle (instructions 0x92, 2)."""
    request = re.compile(rb"\xff\xff(?:\xfe.(\x92)\x00|[\x07\x08]\x04\x02\x24\x08)", re.DOTALL)
    return [
        match[1] is not None
        for packet in stepped.bus.serial_port.written
        for match in request.finditer(packet)
    ]


def test_mx_of_protocol_1_are_read_in_bulk_until_the_line_is_bad() -> None:
    stepped = SteppedArm(with_two_mx())
    session = stepped.session(50.0, accept_no_watchdog=True)
    change = np.zeros(6)
    change[5] = 0.8
    arm = stepped.description
    stepped.bus.serial_port.written.clear()
    out = straight_way(arm.rest, arm.rest + change, arm, 50.0)
    assert session.run(out).ending is Ending.COMPLETED
    np.testing.assert_allclose(stepped.positions(), arm.rest + change, atol=0.02)
    assert all(bulk_reads(stepped))
    count = iter(range(10**6))
    stepped.damage = lambda data: data[:-1] if next(count) % 23 == 0 else data
    back = straight_way(session.read_posture(), arm.rest, arm.slowed(3.0), 50.0)
    assert session.run(back).ending is Ending.COMPLETED
    assert not any(bulk_reads(stepped)[-10:])


def test_temperatures_and_voltages_come_with_the_states(stepped: SteppedArm) -> None:
    session = stepped.session()
    session.run(stepped.way(0.6, 0.3, -0.6, 0.9))
    state = session._joints.read_state()
    assert state.temperature == pytest.approx(25.0, abs=10.0)
    assert state.voltage == pytest.approx(12.0, abs=0.6)
    assert reg.VOLTAGE_UNIT == 0.1
