"""Protocol 2.0: instructions to several servos, fast reads, secondary IDs."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_sim.firmware.codes import StatusError
from firmware_sim.wire.packet import build_packet, crc16
from firmware_sim.wire.protocol2_shares import bulk_reads, bulk_writes, sync_reads, sync_writes

from .wire import Wire, le, servo

SYNC_READ, SYNC_WRITE, FAST_SYNC_READ = 0x82, 0x83, 0x8A
BULK_READ, BULK_WRITE, FAST_BULK_READ = 0x92, 0x93, 0x9A
LED, POSITION = 65, 132
MIDDLE = (0, 8, 0, 0)


def bulk(*shares: tuple[int, int, int]) -> bytes:
    return b"".join(bytes((servo_id,)) + le(address, size) for servo_id, address, size in shares)


def fast(wire: Wire, instruction: int, params: bytes) -> bytes:
    return wire.exchange(build_packet(254, instruction, params))


def split_fast(answer: bytes, *sizes: int) -> list[tuple[int, ...]]:
    """(ID, error, data...) of each part, whose CRC is that of all before it."""
    assert answer[:5] == bytes.fromhex("FF FF FD 00 FE")
    assert answer[7] == 0x55
    parts, start = [], 8
    for size in sizes:
        end = start + 2 + size
        error, servo_id, *data = answer[start:end]
        assert int.from_bytes(answer[end : end + 2], "little") == crc16(answer[:end])
        parts.append((servo_id, error, *data))
        start = end + 2
    assert start == len(answer)
    return parts


def test_bulk_read_answers_each_range_in_the_order_asked_for() -> None:
    wire = Wire("xm430-w350:1", "xl430-w250:2")
    answers = wire.ask(254, BULK_READ, bulk((2, 0, 2), (1, POSITION, 4)))
    assert answers == [(2, 0, 0x24, 0x04), (1, 0, *MIDDLE)]


def test_an_error_of_one_does_not_silence_the_next() -> None:
    wire = Wire("xm430-w350:1", "xm430-w350:2")
    answers = wire.ask(254, BULK_READ, bulk((1, 900, 4), (2, POSITION, 4)))
    assert answers == [(1, StatusError.ACCESS), (2, 0, *MIDDLE)]


@pytest.mark.parametrize("ids", [(1, 9, 2), (1, 1, 2)])
def test_whoever_follows_a_missing_or_repeated_servo_stays_silent(ids: tuple[int, ...]) -> None:
    wire = Wire("xm430-w350:1", "xm430-w350:2")
    shares = bulk(*((servo_id, POSITION, 4) for servo_id in ids))
    assert wire.ask(254, BULK_READ, shares) == [(1, 0, *MIDDLE)]
    assert wire.ask(254, SYNC_READ, le(POSITION, 4) + bytes(ids)) == [(1, 0, *MIDDLE)]


def test_a_servo_that_may_not_answer_breaks_the_chain() -> None:
    quiet = servo("xm430-w350:2")
    wire = Wire("xm430-w350:1", quiet, "xm430-w350:3")
    wire.ask(2, 0x03, le(68) + b"\x00")
    ids = bytes((1, 2, 3))
    assert [a[0] for a in wire.ask(254, SYNC_READ, le(POSITION, 4) + ids)] == [1]
    wire.servos[2].silenced = True
    assert wire.ask(254, SYNC_READ, le(POSITION, 4) + b"\x03\x01") == []


def test_bulk_write_writes_each_servos_own_range() -> None:
    """The manual's example: Max Voltage Limit 160 of ID 1, Temperature Limit 80 of ID 2."""
    wire = Wire("xm430-w350:1", "xm430-w350:2")
    shares = bytes.fromhex("01 20 00 02 00 A0 00 02 1F 00 01 00 50")
    wire.servos[0].write(32, le(150))
    wire.servos[1].write(31, b"\x46")
    assert wire.ask(254, BULK_WRITE, shares) == []
    assert (wire.peek(32, 2, 0), wire.peek(31, 1, 1)) == (160, 80)


def test_bulk_write_takes_only_the_first_share_of_an_id_and_none_cut_off() -> None:
    wire = Wire("xm430-w350:1", "xm430-w350:2")
    shares = bulk((1, 80, 2)) + le(5) + bulk((1, 80, 2)) + le(6) + bulk((2, 80, 2)) + b"\x07"
    wire.ask(254, BULK_WRITE, shares)
    assert [wire.peek(80, 2, index) for index in (0, 1)] == [5, 0]


def test_instructions_to_several_are_for_the_broadcast_id_only() -> None:
    wire = Wire("xm430-w350:1")
    for instruction in (SYNC_READ, SYNC_WRITE, FAST_SYNC_READ, BULK_READ, BULK_WRITE):
        assert wire.ask(1, instruction, le(LED, 1) + b"\x01\x01") == [(1, StatusError.INSTRUCTION)]


def test_a_fast_sync_read_is_one_packet_of_all() -> None:
    wire = Wire("xm430-w350:3", "xm430-w350:4", "xm430-w350:7")
    answer = fast(wire, FAST_SYNC_READ, le(POSITION, 4) + bytes((3, 7, 4)))
    assert split_fast(answer, 4, 4, 4) == [(i, 0, *MIDDLE) for i in (3, 7, 4)]
    assert int.from_bytes(answer[5:7], "little") == len(answer) - 7


def test_a_fast_bulk_read_is_one_packet_of_different_ranges() -> None:
    wire = Wire("xm430-w350:3", "xm430-w350:4")
    answer = fast(wire, FAST_BULK_READ, bulk((4, 0, 2), (3, POSITION, 4)))
    assert split_fast(answer, 2, 4) == [(4, 0, 0xFC, 0x03), (3, 0, *MIDDLE)]


def test_a_fast_answer_is_not_stuffed() -> None:
    wire = Wire("xm430-w350:1")
    wire.servos[0].memory.store("Goal Velocity", -131_073)
    answer = fast(wire, FAST_SYNC_READ, le(104, 4) + b"\x01")
    assert split_fast(answer, 4) == [(1, 0, 0xFF, 0xFF, 0xFD, 0xFF)]


@pytest.mark.parametrize("second", ["missing", "old", "quiet", "repeated"])
def test_a_fast_answer_ends_before_the_first_silent_servo(second: str) -> None:
    settings = servo("xm430-w350:2", firmware=44 if second == "old" else None)
    wire = Wire("xm430-w350:1", settings, "xm430-w350:3")
    if second == "quiet":
        wire.ask(2, 0x03, le(68) + b"\x00")
    ids = {"missing": (1, 9, 3), "repeated": (1, 1, 3)}.get(second, (1, 2, 3))
    answer = fast(wire, FAST_SYNC_READ, le(POSITION, 4) + bytes(ids))
    assert split_fast(answer, 4) == [(1, 0, *MIDDLE)]
    assert int.from_bytes(answer[5:7], "little") == 1 + 3 * 8  # what was to come


@pytest.mark.parametrize("name", ["mx-28:1", "2xl430-w250:1", "xl-320:1"])
def test_models_without_fast_reads_answer_nothing(name: str) -> None:
    wire = Wire(servo(name, protocol=2))
    assert fast(wire, FAST_SYNC_READ, le(0, 2) + b"\x01") == b""


def test_a_fast_read_outside_a_table_is_an_error_and_zeros() -> None:
    wire = Wire("xm430-w350:1", "xm430-w350:2")
    answer = fast(wire, FAST_BULK_READ, bulk((1, 900, 3), (2, POSITION, 4)))
    assert split_fast(answer, 3, 4) == [(1, StatusError.ACCESS, 0, 0, 0), (2, 0, *MIDDLE)]


def test_a_fast_answer_too_long_for_any_length_is_not_begun() -> None:
    wire = Wire("xm430-w350:1")
    assert fast(wire, FAST_SYNC_READ, le(0, 0xFFFF) + b"\x01") == b""
    assert wire.ask(1, 0x01)


def test_only_the_first_servo_of_a_fast_read_waits() -> None:
    delay = {"Return Delay Time": 250}
    wire = Wire(*(servo(f"xm430-w350:{i}", registers=delay) for i in (1, 2, 3)))
    request = build_packet(254, FAST_SYNC_READ, le(POSITION, 4) + b"\x01\x02\x03")
    (answer,) = wire.send(request)
    bits = 10 * (len(request) + len(answer.data))
    assert answer.due == pytest.approx(500e-6 + bits / 1e6)


def test_253_servos_answer_one_fast_sync_read() -> None:
    """The bytes of the wire at 4 Mbaud, of which the benchmark keeps 100 a second: 5.7 ms."""
    wire = Wire(*(f"xm430-w350:{i}" for i in range(253)))
    request = build_packet(254, FAST_SYNC_READ, le(POSITION, 4) + bytes(range(253)))
    (answer,) = wire.send(request)
    assert len(answer.data) == 8 + 253 * 8
    parts = split_fast(answer.data, *[4] * 253)
    assert parts == [(i, 0, *MIDDLE) for i in range(253)]


def test_a_secondary_id_is_obeyed_silently_as_in_the_manual() -> None:
    """e-Manual, X-series pages, "Secondary ID(12) Example", with three servos."""
    shadow = {"Secondary(Shadow) ID": 3}
    wire = Wire(*(servo(f"xm430-w350:{i}", registers=shadow) for i in (1, 2, 3)))
    assert wire.ask(1, 0x03, le(LED) + b"\x01") == [(1, 0)]
    assert [wire.peek(LED, 1, i) for i in range(3)] == [1, 0, 0]
    assert wire.ask(3, 0x03, le(LED) + b"\x01") == [(3, 0)]
    assert [wire.peek(LED, 1, i) for i in range(3)] == [1, 1, 1]
    for one in (1, 2, 3):
        assert wire.ask(one, 0x03, le(12) + b"\x64") == [(one, 0)]
    assert wire.ask(100, 0x03, le(LED) + b"\x00") == []
    assert [wire.peek(LED, 1, i) for i in range(3)] == [0, 0, 0]


def test_a_secondary_id_reaches_ram_only_and_answers_nothing() -> None:
    wire = Wire(servo("xm430-w350:1", registers={"Secondary(Shadow) ID": 100}))
    assert wire.ask(100, 0x03, le(9) + b"\x07") == []
    assert wire.peek(9) == 0
    assert wire.ask(100, 0x01) == []
    assert wire.ask(100, 0x02, le(LED, 1)) == []
    assert wire.ask(100, 0x08) == []
    assert wire.ask(1, 0x01)


def test_writes_to_several_reach_secondary_ids() -> None:
    shadow = {"Secondary(Shadow) ID": 100}
    wire = Wire(*(servo(f"xm430-w350:{i}", registers=shadow) for i in (1, 2)))
    wire.ask(254, SYNC_WRITE, le(LED, 1) + b"\x64\x01")
    assert [wire.peek(LED, 1, i) for i in (0, 1)] == [1, 1]
    wire.ask(254, BULK_WRITE, bulk((100, LED, 1)) + b"\x00")
    assert [wire.peek(LED, 1, i) for i in (0, 1)] == [0, 0]
    wire.ask(254, SYNC_WRITE, le(9, 1) + b"\x64\x07")
    assert [wire.peek(9, 1, i) for i in (0, 1)] == [0, 0]


def test_a_write_registered_through_a_secondary_id_waits_for_the_action() -> None:
    wire = Wire(servo("xm430-w350:1", registers={"Secondary(Shadow) ID": 100}))
    assert wire.ask(100, 0x04, le(LED) + b"\x01") == []
    assert (wire.peek(69), wire.peek(LED)) == (1, 0)
    assert wire.ask(100, 0x05) == []
    assert (wire.peek(69), wire.peek(LED)) == (0, 1)


@settings(max_examples=500)
@given(st.binary(max_size=40))
def test_shares_are_whole_whatever_the_parameters(params: bytes) -> None:
    for share in (*sync_writes(params), *bulk_writes(params)):
        assert share.data
        assert bytes((share.servo_id,)) in params
        assert share.data in params
    assert len(bulk_reads(params)) == len(params) // 5
    assert len(sync_reads(params)) == max(0, len(params) - 4)


@settings(max_examples=300)
@given(
    st.sampled_from((SYNC_READ, SYNC_WRITE, FAST_SYNC_READ, BULK_READ, BULK_WRITE, FAST_BULK_READ)),
    st.binary(max_size=30),
)
def test_no_parameters_whatever_end_a_bus(instruction: int, params: bytes) -> None:
    wire = _SHARED
    wire.exchange(build_packet(254, instruction, params))
    assert all(one.status_return_level in (0, 1, 2) for one in wire.servos)


_SHARED = Wire("xm430-w350:0", "xl330-m288:1", "xl-320:2")
