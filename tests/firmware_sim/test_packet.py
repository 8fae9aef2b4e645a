"""Frames: the manual's byte vectors, stuffing, CRC, and a parser that no chunking can confuse."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.packet import HEADER, build_packet, build_status, crc16, stuff, unstuff
from firmware_sim.parser import DamagedPacket, Packet, PacketParser

# Instruction and status packets printed in the e-Manual's page on Protocol 2.0.
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
    (254, 0x82, "84 00 04 00 01 02", "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA"),
    (
        254,
        0x83,
        "74 00 04 00 01 96 00 00 00 02 AA 00 00 00",
        "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
    ),
    (1, 0x55, "00 06 04 26", "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"),
    (2, 0x55, "00 06 04 26", "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D"),
    (1, 0x55, "00 A6 00 00 00", "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"),
    (2, 0x55, "00 1F 08 00 00", "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE"),
    (1, 0x55, "00", "FF FF FD 00 01 04 00 55 00 A1 0C"),
]

# Parameters in which the stuffed pattern is likely.
PARAMS = st.lists(st.sampled_from([0xFF, 0xFD, 0x00, 0x01, 0x55]) | st.integers(0, 255)).map(bytes)
IDS = st.integers(0, 252) | st.just(254)
FRAMES = st.builds(build_packet, IDS, st.integers(0, 254), PARAMS)
NOISE = st.binary(max_size=12) | st.just(HEADER[:3]) | st.just(HEADER + b"\x01\xff\xff")


def bitwise_crc(data: bytes) -> int:
    """CRC by long division of the message by x^16 + x^15 + x^2 + 1, bit by bit."""
    remainder = int.from_bytes(data, "big") << 16
    for bit in range(8 * len(data) + 15, 15, -1):
        if remainder >> bit & 1:
            remainder ^= 0x18005 << (bit - 16)
    return remainder


def parsed(stream: bytes) -> list[Packet | DamagedPacket]:
    return PacketParser().feed(stream)


@pytest.mark.parametrize(("servo_id", "instruction", "params", "frame"), MANUAL_PACKETS)
def test_builds_and_parses_the_manuals_packets(
    servo_id: int, instruction: int, params: str, frame: str
) -> None:
    assert build_packet(servo_id, instruction, bytes.fromhex(params)) == bytes.fromhex(frame)
    (packet,) = parsed(bytes.fromhex(frame))
    assert packet == Packet(servo_id, instruction, bytes.fromhex(params), len(bytes.fromhex(frame)))


def test_a_status_packet_begins_with_its_error_field() -> None:
    assert build_status(1, 0) == bytes.fromhex("FF FF FD 00 01 04 00 55 00 A1 0C")


@given(st.binary(max_size=60))
def test_crc_is_the_remainder_of_long_division(data: bytes) -> None:
    assert crc16(data) == bitwise_crc(data)


@given(PARAMS)
def test_stuffing_puts_fd_after_each_pattern_and_comes_off_again(params: bytes) -> None:
    expected = bytearray()
    for index, byte in enumerate(params):
        expected.append(byte)
        if params[max(0, index - 2) : index + 1] == b"\xff\xff\xfd":
            expected.append(0xFD)
    assert stuff(params) == bytes(expected)
    assert HEADER not in stuff(params)
    assert unstuff(stuff(params)) == params


@given(IDS, st.integers(0, 254), PARAMS)
def test_what_is_built_is_parsed(servo_id: int, instruction: int, params: bytes) -> None:
    frame = build_packet(servo_id, instruction, params)
    assert parsed(frame) == [Packet(servo_id, instruction, params, len(frame))]


@given(st.lists(FRAMES | NOISE, max_size=8), st.data())
def test_any_chunking_gives_the_same_packets(parts: list[bytes], data: st.DataObject) -> None:
    stream = b"".join(parts)
    whole, pieces = PacketParser(), PacketParser()
    expected = whole.feed(stream)
    found = []
    rest = stream
    while rest:
        size = data.draw(st.integers(1, len(rest)))
        found += pieces.feed(rest[:size])
        rest = rest[size:]
    assert found == expected
    assert pieces.counts == whole.counts
    assert pieces.pending == whole.pending


@given(st.lists(FRAMES, min_size=1, max_size=5), st.lists(st.binary(max_size=9), min_size=5))
def test_finds_every_packet_between_garbage(frames: list[bytes], garbage: list[bytes]) -> None:
    # Zeros cannot begin a header, so that the garbage cannot swallow what follows it.
    separated = [piece + b"\0\0\0" + frame for piece, frame in zip(garbage, frames, strict=False)]
    wanted = [packet for frame in frames for packet in parsed(frame)]
    found = [packet for packet in parsed(b"".join(separated)) if isinstance(packet, Packet)]
    assert [(p.servo_id, p.params) for p in found] == [
        (p.servo_id, p.params) for p in wanted if isinstance(p, Packet)
    ]


@given(FRAMES, st.data())
def test_a_flipped_bit_outside_the_length_is_never_believed(
    frame: bytes, data: st.DataObject
) -> None:
    # A CRC of 16 bits finds each single flip in a frame of the same length.
    places = [index for index in range(len(frame)) if index not in (5, 6)]
    index = data.draw(st.sampled_from(places))
    bit = data.draw(st.integers(0, 7))
    broken = bytearray(frame)
    broken[index] ^= 1 << bit
    assert not [p for p in parsed(bytes(broken)) if isinstance(p, Packet)]


@pytest.mark.parametrize("length", [0, 1, 2, 4097, 0xFFFF])
def test_a_length_that_cannot_be_does_not_hold_up_the_next_packet(length: int) -> None:
    ping = build_packet(1, 0x01)
    parser = PacketParser()
    lie = HEADER + b"\x01" + length.to_bytes(2, "little") + b"\x03\x74\x00"
    assert [p.servo_id for p in parser.feed(lie + ping)] == [1]
    assert parser.counts.bad_heads == 1
    assert parser.pending == 0


@pytest.mark.parametrize("length", [20, 1000, 4096])
def test_a_length_that_lies_does_not_swallow_the_next_packet(length: int) -> None:
    ping = build_packet(7, 0x01)
    parser = PacketParser()
    assert not parser.feed(HEADER + b"\x01" + length.to_bytes(2, "little") + b"\x03\x74\x00")
    assert [p.servo_id for p in parser.feed(ping)] == [7]
    assert parser.counts.cut_short == 1


def test_a_crc_that_looks_like_a_header_is_a_crc() -> None:
    """The last byte of a frame's CRC may complete FF FF FD 00: that is no new frame."""
    for value in range(65_536):
        frame = build_packet(1, 0x03, value.to_bytes(2, "little") + b"\xff\xff")
        if frame.endswith(HEADER):
            assert [type(p) for p in parsed(frame)] == [Packet]
            return
    pytest.fail("no such frame exists among those tried")


def test_a_damaged_packet_is_reported_with_its_id_and_counted() -> None:
    frame = bytearray(build_packet(9, 0x02, b"\x84\x00\x04\x00"))
    frame[8] ^= 0x10
    parser = PacketParser()
    assert parser.feed(bytes(frame)) == [DamagedPacket(9, len(frame))]
    assert parser.counts.crc_errors == 1
    assert parser.counts.dropped_bytes == len(frame)
    assert parser.counts.packets == 0


@given(st.binary(max_size=400))
def test_what_waits_is_bounded(stream: bytes) -> None:
    parser = PacketParser(length_cap=64)
    for byte in stream:
        parser.feed(bytes((byte,)))
        assert parser.pending <= 64 + 7


def test_giving_up_drops_an_unfinished_frame() -> None:
    parser = PacketParser()
    parser.feed(build_packet(1, 0x02, b"\x84\x00\x04\x00")[:9])
    parser.give_up()
    assert (parser.pending, parser.counts.gaps, parser.counts.dropped_bytes) == (0, 1, 9)
