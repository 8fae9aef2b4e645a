"""A parser of protocol 2.0 that no chunking, noise or lie can confuse."""

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from firmware_sim.wire.packet import HEADER, build_packet
from firmware_sim.wire.parser import DamagedPacket, Packet, PacketParser

from .streams import cook, cut, frame_2, lie, noise

RECIPES = st.binary(max_size=60)
CUTS = st.binary(max_size=6)
RESTART = st.booleans()
PING = build_packet(7, 0x01)
WRITE = build_packet(1, 0x03, b"\x74\x00\x00\x08\x00\x00")


def parsed(stream: bytes, restart: bool = False) -> list[Packet | DamagedPacket]:
    return PacketParser(restart=restart).feed(stream)


@settings(max_examples=1200)
@given(RECIPES, CUTS, RESTART)
def test_any_chunking_gives_the_same_packets(recipe: bytes, cuts: bytes, restart: bool) -> None:
    stream = b"".join(cook(recipe, frame_2, noise, lie))
    whole, pieces, single = (PacketParser(restart=restart) for _ in range(3))
    expected = whole.feed(stream)
    assert [p for chunk in cut(stream, cuts) for p in pieces.feed(chunk)] == expected
    assert [p for byte in stream for p in single.feed(bytes((byte,)))] == expected
    assert whole.counts == pieces.counts == single.counts
    assert whole.pending == pieces.pending == single.pending


@settings(max_examples=600)
@given(RECIPES, st.binary(max_size=9), RESTART)
def test_finds_every_packet_between_garbage(recipe: bytes, garbage: bytes, restart: bool) -> None:
    # Zeros cannot begin a header, so that the garbage cannot swallow what follows it.
    assume(restart or HEADER not in garbage + b"\0\0\0")
    frames = cook(recipe, frame_2)
    stream = b"".join(garbage + b"\0\0\0" + frame for frame in frames)
    found = [packet for packet in parsed(stream, restart) if isinstance(packet, Packet)]
    assert [packet.frame for packet in found] == frames


@settings(max_examples=1200)
@given(st.binary(min_size=1, max_size=20), st.integers(0, 10_000), st.integers(0, 7), RESTART)
def test_a_flipped_bit_outside_the_length_is_never_believed(
    recipe: bytes, place: int, bit: int, restart: bool
) -> None:
    # A CRC of 16 bits finds each single flip in a frame of the same length.
    frame = cook(recipe, frame_2)[0]
    places = [index for index in range(len(frame)) if index not in (5, 6)]
    broken = bytearray(frame)
    broken[places[place % len(places)]] ^= 1 << bit
    assert not [p for p in parsed(bytes(broken), restart) if isinstance(p, Packet)]


def test_a_flipped_bit_of_the_length_is_not_believed_either() -> None:
    """Here the CRC is looked for at another place: it fits there once in 65536 times."""
    frame = build_packet(1, 0x03, bytes(range(100, 140)))
    for place in (5, 6):
        for bit in range(8):
            broken = bytearray(frame)
            broken[place] ^= 1 << bit
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
def test_a_length_that_lies_takes_in_as_much_as_it_says(length: int) -> None:
    """Processing Order of Reception: what follows a header is counted, not looked at."""
    parser = PacketParser()
    lie = HEADER + b"\x01" + length.to_bytes(2, "little") + b"\x03\x74\x00"
    stream = (lie + PING * 500)[: 7 + length]
    assert parser.feed(stream[:-1]) == []
    (damaged,) = parser.feed(stream[-1:])
    assert damaged == DamagedPacket(1, 7 + length, stream)
    assert parser.pending == 0
    assert [p.servo_id for p in parser.feed(PING)] == [7]


@pytest.mark.parametrize("length", [20, 1000, 4096])
def test_a_length_that_lies_is_over_with_the_next_header_where_headers_restart(
    length: int,
) -> None:
    parser = PacketParser(restart=True)
    assert not parser.feed(HEADER + b"\x01" + length.to_bytes(2, "little") + b"\x03\x74\x00")
    assert [p.servo_id for p in parser.feed(PING)] == [7]
    assert parser.counts.cut_short == 1


@pytest.mark.parametrize("missing", range(1, 10))
def test_a_frame_cut_short_swallows_the_beginning_of_the_next(missing: int) -> None:
    parser = PacketParser()
    short = WRITE[:-missing] + PING
    (damaged,) = parser.feed(short + PING)[:1]
    assert isinstance(damaged, DamagedPacket)
    assert damaged.frame == short[: len(WRITE)]
    assert parser.counts.packets == 1  # the second ping: the rest of the first is no header
    assert parser.counts.dropped_bytes == len(short)


@pytest.mark.parametrize("missing", range(1, 10))
def test_a_frame_cut_short_swallows_nothing_where_headers_restart(missing: int) -> None:
    found = parsed(WRITE[:-missing] + PING, restart=True)
    assert [p.frame for p in found if isinstance(p, Packet)] == [PING]


def test_a_silence_after_a_frame_cut_short_saves_the_next() -> None:
    parser = PacketParser()
    assert parser.feed(WRITE[:-3]) == []
    parser.give_up()
    assert [p.frame for p in parser.feed(PING)] == [PING]
    assert parser.counts.gaps == 1


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
    assert parser.feed(bytes(frame)) == [DamagedPacket(9, len(frame), bytes(frame))]
    assert parser.counts.crc_errors == 1
    assert parser.counts.dropped_bytes == len(frame)
    assert parser.counts.packets == 0


def test_a_request_known_by_its_bytes_is_the_same_packet_each_time() -> None:
    """What is remembered is bounded: many other requests do not change what comes out."""
    parser = PacketParser()
    ping = build_packet(3, 0x01)
    for number in range(1000):
        (packet,) = parser.feed(ping)
        assert packet == Packet(3, 0x01, b"", parser.received, ping)
        (other,) = parser.feed(build_packet(1, 0x02, number.to_bytes(4, "little")))
        assert isinstance(other, Packet)
        assert other.params == number.to_bytes(4, "little")
    assert parser.counts.packets == 2000


@given(st.binary(max_size=400), RESTART)
def test_what_waits_is_bounded(stream: bytes, restart: bool) -> None:
    parser = PacketParser(length_cap=64, restart=restart)
    for byte in stream:
        parser.feed(bytes((byte,)))
        assert parser.pending <= 64 + 7


def test_giving_up_drops_an_unfinished_frame() -> None:
    parser = PacketParser()
    parser.feed(build_packet(1, 0x02, b"\x84\x00\x04\x00")[:9])
    parser.give_up()
    assert (parser.pending, parser.counts.gaps, parser.counts.dropped_bytes) == (0, 1, 9)
