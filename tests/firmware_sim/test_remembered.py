"""What is remembered to be fast changes nothing: with it and without, the same bytes leave."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_sim.wire import packet
from firmware_sim.wire.bus import Transmission
from firmware_sim.wire.packet import build_packet, build_status, crc16
from firmware_sim.wire.packet1 import build_packet_1
from firmware_sim.wire.protocol2_shares import bulk_reads, sync_reads

from .wire import RATE, Wire, servo

SERVOS = ("xm430-w350:1", "xm430-w350:2", "xl430-w250:3", "xl-320:4")
PLACES = ((132, 4), (126, 10), (116, 4), (224, 4), (7, 1), (0, 12), (36, 4), (600, 2), (210, 4))
REGISTERS = (
    (7, 1, (1, 2, 3, 4, 9)),  # ID
    (8, 1, (1, 3)),  # Baud Rate
    (12, 1, (2, 9, 255)),  # Secondary ID
    (13, 1, (1, 2)),  # Protocol Type
    (9, 1, (0, 5)),  # Return Delay Time
    (68, 1, (0, 1, 2)),  # Status Return Level
    (60, 1, (0, 1, 2, 3)),  # Startup Configuration
    (11, 1, (1, 3, 4, 16)),  # Operating Mode
    (10, 1, (0, 1, 4)),  # Drive Mode
    (52, 4, (0, 1000)),  # Min Position Limit
    (98, 1, (0, 1)),  # Bus Watchdog
    (168, 2, (117, 133, 224)),  # Indirect Address 1
    (170, 2, (117, 226)),  # Indirect Address 2
    (64, 1, (0, 1)),  # Torque Enable
    (112, 4, (0, 50)),  # Profile Velocity
    (116, 4, (500, 2048, 3000)),  # Goal Position
    (224, 1, (0, 7)),  # Indirect Data 1
    (3, 1, (2, 7)),  # the XL-320's ID
)
LISTS = (b"\x01\x02\x03\x04", b"\x02\x01", b"\x01\x01\x09", b"\x09\x02\x03")
OTHERS = (
    (0x01, b""), (0x05, b""), (0x06, b"\x01"), (0x06, b"\x02"), (0x08, b""),
    (0x10, b"\x01\x44\x58\x4c\x22"), (0x20, b"\x01CTRL"), (0x20, b"\x02CTRL"),
)  # fmt: skip

Step = tuple[str, Any]


def number(value: int, size: int = 2) -> bytes:
    return value.to_bytes(size, "little")


@st.composite
def reads(draw: st.DrawFn) -> Step:
    address, size = draw(st.sampled_from(PLACES))
    ids, place = draw(st.sampled_from(LISTS)), number(address) + number(size)
    frames = (
        build_packet(ids[0], 0x02, place),
        build_packet_1(ids[0], 0x02, bytes((address & 0xFF, size))),
        build_packet(254, 0x82, place + ids),
        build_packet(254, 0x8A, place + ids),
        build_packet(254, 0x92, b"".join(bytes((i,)) + place for i in ids)),
        build_packet(254, 0x9A, b"".join(bytes((i,)) + place for i in ids)),
    )
    return "send", draw(st.sampled_from(frames))


@st.composite
def writes(draw: st.DrawFn) -> Step:
    address, size, values = draw(st.sampled_from(REGISTERS))
    value, ids = number(draw(st.sampled_from(values)), size), draw(st.sampled_from(LISTS))
    place = number(address) + number(size)
    frames = (
        build_packet(ids[0], 0x03, number(address) + value),
        build_packet(ids[0], 0x04, number(address) + value),
        build_packet_1(ids[0], 0x03, bytes((address,)) + value),
        build_packet(254, 0x83, place + b"".join(bytes((i,)) + value for i in ids)),
        build_packet(254, 0x93, b"".join(bytes((i,)) + place + value for i in ids)),
    )
    return "send", draw(st.sampled_from(frames))


@st.composite
def together(draw: st.DrawFn) -> Step:
    first, second = draw(writes()), draw(reads())
    return "send", first[1] + second[1]


def others() -> st.SearchStrategy[Step]:
    return st.builds(
        lambda servo_id, other: ("send", build_packet(servo_id, *other)),
        st.sampled_from((1, 2, 4, 9, 254)),
        st.sampled_from(OTHERS),
    )


REQUESTS = st.one_of(reads(), reads(), writes(), together())
CHANGES = st.one_of(
    writes(),
    others(),
    st.sampled_from((("wait", 0.01), ("rate", 57_600), ("rate", RATE), ("own id", 2))),
)


@st.composite
def repetitions(draw: st.DrawFn) -> list[Step]:
    """A request, what may make a stale answer of it, and the same again."""
    request = draw(REQUESTS)
    return [request, draw(CHANGES), ("wait", draw(st.sampled_from((0.0, 0.11)))), request]


def forget(wire: Wire) -> None:
    """Forget all that is remembered for speed, on the bus and in the servos."""
    sync_reads.cache_clear()
    bulk_reads.cache_clear()
    packet._status_head.cache_clear()
    wire.bus._listeners_key = (0.0, -1)
    wire.bus.ears.parser._known.clear()
    for each in wire.servos:
        each.model.table._spans.clear()
        each._reader.forget()
        rules = getattr(each.firmware, "_rules", None) or each.firmware._checker
        rules.forget()


def play(
    steps: list[Step], before: Callable[[Wire], None]
) -> tuple[list[Transmission], list[bytes]]:
    """Return what leaves, and what the registers hold in the end."""
    wire = Wire(*(servo(name) for name in SERVOS))
    sent: list[Transmission] = []
    for what, value in steps:
        before(wire)
        if what == "send":
            sent += wire.send(value)
        elif what == "wait":
            wire.now += value
            wire.world.advance(wire.now)
        elif what == "rate":
            wire.rate = value
        else:  # as a fault does it, behind the firmware's back
            wire.servos[0].memory.store("ID", value)
            wire.servos[0].take_identity()
    return sent, [bytes(each.memory.data) for each in wire.servos]


@settings(max_examples=300, deadline=None)
@given(st.lists(repetitions(), min_size=1, max_size=4))
def test_nothing_remembered_changes_what_servos_do(parts: list[list[Step]]) -> None:
    steps = [step for part in parts for step in part]
    assert play(steps, lambda _wire: None) == play(steps, forget)


@pytest.mark.parametrize(
    ("address", "value"), [(7, 5), (8, 1), (13, 1)], ids=["ID", "rate", "protocol"]
)
def test_a_change_of_identity_counts_for_the_next_equal_request(address: int, value: int) -> None:
    wire = Wire(servo("mx-28:1", protocol=2), "mx-28:7")
    request = build_packet(254, 0x82, number(132) + number(4) + b"\x01")
    assert len(wire.send(request)) == 1
    wire.send(build_packet(1, 0x03, number(address) + bytes((value,))))
    assert wire.send(request) == []


def test_an_indirect_address_counts_for_the_next_equal_requests_until_a_boot() -> None:
    wire = Wire("xm430-w350:1")

    def look() -> tuple[int, int]:
        """Through Indirect Data 1, and at the LED; each after writing 0 to the datum."""
        wire.ask(1, 0x03, number(224) + b"\x00")
        ((_, _, datum),) = wire.ask(1, 0x02, number(224) + number(1))
        return datum, wire.peek(65)

    def switch_on() -> None:
        wire.ask(1, 0x03, number(65) + b"\x01")

    switch_on()
    assert look() == (0, 1)
    wire.ask(1, 0x03, number(168) + number(65))
    assert look() == (0, 0)
    switch_on()
    assert wire.ask(1, 0x02, number(224) + number(1)) == [(1, 0, 1)]
    wire.ask(1, 0x08)
    wire.now += 0.11
    switch_on()
    assert wire.ask(1, 0x02, number(224) + number(1)) == [(1, 0, 0)]
    assert look() == (0, 1)


@settings(max_examples=300)
@given(st.integers(0, 252), st.integers(0, 255), st.binary(max_size=80))
def test_a_status_packet_is_built_as_any_other(servo_id: int, error: int, data: bytes) -> None:
    frame = build_status(servo_id, error, data)
    assert frame == build_packet(servo_id, 0x55, bytes((error,)) + data)
    assert crc16(frame[:-2]) == frame[-2] | frame[-1] << 8


def test_no_flood_of_different_requests_makes_what_is_remembered_grow() -> None:
    wire = Wire(*SERVOS[:2])
    for turn in range(2_000):
        address, size = turn % 600, 1 + turn % 40
        wire.send(build_packet(254, 0x82, number(address) + number(size) + b"\x01\x02"))
        wire.send(build_packet(254, 0x83, number(address) + b"\x01\x00\x01\x00\x02\x00"))
    assert sync_reads.cache_info().currsize <= 64
    assert packet._status_head.cache_info().currsize <= 4096
    assert len(wire.bus.ears.parser._known) <= 256
    for each in wire.servos:
        assert len(each._reader._plans) <= 256
        assert len(each.model.table._spans) <= 512
