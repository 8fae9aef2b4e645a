"""Frames of protocol 2.0: the manual's byte vectors, CRC, stuffing."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_sim.wire.packet import (
    HEADER,
    build_fast_status,
    build_packet,
    build_status,
    crc16,
    stuff,
    unstuff,
)
from firmware_sim.wire.parser import Packet, PacketParser

from .streams import likely

# Instruction and status packets of the e-Manual's page on Protocol 2.0, as printed but for two CRCs
# that their own bytes contradict, corrected here: the page prints 92 F5 for restoring (9E F5), and
# for the fast bulk read (DA 2D) the 20 F2 of the fast sync read above it.
MANUAL_PACKETS = [
    (1, 0x01, "", "FF FF FD 00 01 03 00 01 19 4E"),
    (254, 0x01, "", "FF FF FD 00 FE 03 00 01 31 42"),
    (1, 0x02, "84 00 04 00", "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
    (1, 0x03, "74 00 00 02 00 00", "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89"),
    (1, 0x04, "68 00 C8 00 00 00", "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E"),
    (1, 0x05, "", "FF FF FD 00 01 03 00 05 02 CE"),
    (1, 0x06, "01", "FF FF FD 00 01 04 00 06 01 A1 E6"),
    (1, 0x08, "", "FF FF FD 00 01 03 00 08 2F 4E"),
    (1, 0x10, "01 44 58 4C 22", "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC"),
    (1, 0x20, "01 43 54 52 4C", "FF FF FD 00 01 08 00 20 01 43 54 52 4C 16 F5"),
    (1, 0x20, "02 43 54 52 4C", "FF FF FD 00 01 08 00 20 02 43 54 52 4C 9E F5"),
    (254, 0x82, "84 00 04 00 01 02", "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA"),
    (
        254,
        0x83,
        "74 00 04 00 01 96 00 00 00 02 AA 00 00 00",
        "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
    ),
    (254, 0x8A, "84 00 04 00 03 07 04", "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2"),
    (
        254,
        0x92,
        "01 90 00 02 00 02 92 00 01 00",
        "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05",
    ),
    (
        254,
        0x93,
        "01 20 00 02 00 A0 00 02 1F 00 01 00 50",
        "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68",
    ),
    (
        254,
        0x9A,
        "03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00",
        "FF FF FD 00 FE 12 00 9A 03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00 DA 2D",
    ),
    (1, 0x55, "00 06 04 26", "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"),
    (2, 0x55, "00 06 04 26", "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D"),
    (1, 0x55, "00 A6 00 00 00", "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"),
    (2, 0x55, "00 1F 08 00 00", "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE"),
    (1, 0x55, "00 77 00", "FF FF FD 00 01 06 00 55 00 77 00 C3 69"),
    (2, 0x55, "00 24", "FF FF FD 00 02 05 00 55 00 24 8B A9"),
    (1, 0x55, "00", "FF FF FD 00 01 04 00 55 00 A1 0C"),
]

# Fast answers printed there: LEN, (error, ID, data) of each servo, and each servo's bytes.
MANUAL_FAST_ANSWERS = [
    (
        0x19,
        [(0, 3, "A6 00 00 00"), (0, 7, "1F 08 00 00"), (0, 4, "FF 03 00 00")],
        "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08"
        " 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 D1 9E",
    ),
    (
        0x14,
        [(0, 3, "A6 00 00 00"), (0, 7, "A5 01"), (0, 4, "1F")],
        "FF FF FD 00 FE 14 00 55 00 03 A6 00 00 00 67 A4 00 07 A5 01 24 74 00 04 1F D9 C1",
    ),
]

# Parameters in which the stuffed pattern is likely.
RECIPES = st.binary(max_size=24)
IDS = st.integers(0, 252) | st.just(254)


def bitwise_crc(data: bytes) -> int:
    """CRC by long division of the message by x^16 + x^15 + x^2 + 1, bit by bit."""
    remainder = int.from_bytes(data, "big") << 16
    for bit in range(8 * len(data) + 15, 15, -1):
        if remainder >> bit & 1:
            remainder ^= 0x18005 << (bit - 16)
    return remainder


@pytest.mark.parametrize(("servo_id", "instruction", "params", "frame"), MANUAL_PACKETS)
def test_builds_and_parses_the_manuals_packets(
    servo_id: int, instruction: int, params: str, frame: str
) -> None:
    raw = bytes.fromhex(frame)
    assert build_packet(servo_id, instruction, bytes.fromhex(params)) == raw
    expected = Packet(servo_id, instruction, bytes.fromhex(params), len(raw), raw)
    assert PacketParser().feed(raw) == [expected]


@pytest.mark.parametrize(("length", "parts", "frame"), MANUAL_FAST_ANSWERS)
def test_builds_the_manuals_fast_answers(
    length: int, parts: list[tuple[int, int, str]], frame: str
) -> None:
    raw = [(error, servo_id, bytes.fromhex(data)) for error, servo_id, data in parts]
    assert build_fast_status(length, raw) == bytes.fromhex(frame)
    assert len(bytes.fromhex(frame)) == 8 + sum(len(data) + 4 for _, _, data in raw)


def test_an_unfinished_fast_answer_is_the_beginning_of_the_whole() -> None:
    parts = [(0, i, bytes((i, 0xFF))) for i in range(5)]
    whole = build_fast_status(31, parts)
    for count in range(1, 5):
        assert whole.startswith(build_fast_status(31, parts[:count]))


def test_a_status_packet_begins_with_its_error_field() -> None:
    assert build_status(1, 0) == bytes.fromhex("FF FF FD 00 01 04 00 55 00 A1 0C")


@settings(max_examples=900)
@given(st.binary(max_size=60), st.binary(max_size=20))
def test_crc_is_the_remainder_of_long_division_and_goes_on(first: bytes, rest: bytes) -> None:
    assert crc16(first) == bitwise_crc(first)
    assert crc16(rest, crc16(first)) == bitwise_crc(first + rest)


@settings(max_examples=900)
@given(RECIPES)
def test_stuffing_puts_fd_after_each_pattern_and_comes_off_again(recipe: bytes) -> None:
    params = likely(recipe)
    expected = bytearray()
    for index, byte in enumerate(params):
        expected.append(byte)
        if params[max(0, index - 2) : index + 1] == b"\xff\xff\xfd":
            expected.append(0xFD)
    assert stuff(params) == bytes(expected)
    assert HEADER not in stuff(params)
    assert unstuff(stuff(params)) == params


@settings(max_examples=900)
@given(IDS, st.integers(0, 255), RECIPES)
def test_what_is_built_is_parsed(servo_id: int, instruction: int, recipe: bytes) -> None:
    params = likely(recipe)
    frame = build_packet(servo_id, instruction, params)
    expected = Packet(servo_id, instruction, params, len(frame), frame)
    assert PacketParser().feed(frame) == [expected]


@pytest.mark.parametrize("tail", [b"", b"\xfd", b"\x00", b"\xfd\xfd", b"\xff\xff\xfd"])
def test_the_pattern_survives_at_every_offset(tail: bytes) -> None:
    for offset in range(40):
        params = b"\x01" * offset + b"\xff\xff\xfd" + tail + b"\x02" * (40 - offset)
        (packet,) = PacketParser().feed(build_packet(1, 0x03, params))
        assert isinstance(packet, Packet)
        assert packet.params == params


def test_the_instruction_counts_for_stuffing() -> None:
    """Inspection range: everything from the instruction to the last parameter."""
    frame = build_packet(1, 0xFF, b"\xff\xfd\x00")
    assert frame[7:-2] == b"\xff\xff\xfd\xfd\x00"
