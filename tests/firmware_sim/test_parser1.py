"""A parser of protocol 1.0, alone and beside that of protocol 2.0."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_sim.wire.ears import Arrival, Ears
from firmware_sim.wire.packet import HEADER, build_packet
from firmware_sim.wire.packet1 import build_packet_1
from firmware_sim.wire.parser import DamagedPacket, Packet
from firmware_sim.wire.parser1 import PacketParser1

from .streams import cook, cut, frame_1, frame_2, lie, noise

RECIPES = st.binary(max_size=60)
CUTS = st.binary(max_size=6)
PING = build_packet_1(1, 0x01)
PING_2 = build_packet(1, 0x01)


def hear(chunks: list[bytes]) -> list[tuple[int, Packet | DamagedPacket]]:
    ears = Ears()
    return [(a.protocol, a.packet) for chunk in chunks for a in ears.feed(chunk, both=True)]


@settings(max_examples=900)
@given(RECIPES, CUTS)
def test_any_chunking_gives_the_same_packets(recipe: bytes, cuts: bytes) -> None:
    stream = b"".join(cook(recipe, frame_1, noise, lie))
    whole, pieces = PacketParser1(), PacketParser1()
    expected = whole.feed(stream)
    assert [p for chunk in cut(stream, cuts) for p in pieces.feed(chunk)] == expected
    assert whole.counts == pieces.counts
    assert whole.pending == pieces.pending <= 258


@settings(max_examples=900)
@given(st.binary(min_size=1, max_size=20), st.integers(0, 10_000), st.integers(0, 7))
def test_a_frame_with_one_flipped_bit_is_never_believed(
    recipe: bytes, place: int, bit: int
) -> None:
    frame = cook(recipe, frame_1)[0]
    broken = bytearray(frame)
    broken[place % len(frame)] ^= 1 << bit
    found = PacketParser1().feed(bytes(broken))
    assert not [p for p in found if isinstance(p, Packet) and p.frame == bytes(broken)]


@settings(max_examples=600)
@given(RECIPES)
def test_finds_every_packet_of_a_clean_stream(recipe: bytes) -> None:
    frames = cook(recipe, frame_1)
    assert [p.frame for p in PacketParser1().feed(b"".join(frames))] == frames


@pytest.mark.parametrize("length", [0, 1])
def test_a_length_that_cannot_be_does_not_hold_up_the_next_packet(length: int) -> None:
    parser = PacketParser1()
    assert [p.servo_id for p in parser.feed(b"\xff\xff\x05" + bytes((length,)) + PING)] == [1]
    assert parser.counts.bad_heads == 1


def test_a_length_that_lies_gives_back_what_it_took_in() -> None:
    parser = PacketParser1()
    lie = b"\xff\xff\x05\x0a\x03"
    assert not parser.feed(lie + PING)
    damaged, ping = parser.feed(b"\0\0\0")
    assert isinstance(damaged, DamagedPacket)
    assert isinstance(ping, Packet)
    assert ping.frame == PING


def test_more_bytes_ff_than_a_header_has_are_no_id() -> None:
    assert [p.frame for p in PacketParser1().feed(b"\xff" * 9 + PING[2:])] == [PING]


def test_the_header_of_protocol_2_is_passed_over() -> None:
    parser = PacketParser1()
    assert [p.frame for p in parser.feed(HEADER + PING)] == [PING]
    assert parser.counts.bad_heads == 1


@settings(max_examples=900)
@given(RECIPES, CUTS)
def test_a_mixed_stream_gives_the_same_packets_in_any_chunks(recipe: bytes, cuts: bytes) -> None:
    stream = b"".join(cook(recipe, frame_1, frame_2, noise, lie))
    assert hear(cut(stream, cuts)) == hear([stream])


@settings(max_examples=600)
@given(RECIPES, CUTS)
def test_no_frame_of_protocol_2_eats_a_request_of_protocol_1(recipe: bytes, cuts: bytes) -> None:
    """Whatever looks like a header in its parameters ends with the frame itself."""
    frames = cook(recipe, frame_2)
    stream = b"".join(frame + PING for frame in frames)
    found = [p for protocol, p in hear(cut(stream, cuts)) if protocol == 1]
    ends = [p.end for p in found if p.frame == PING]
    places, end = [], 0
    for frame in frames:
        end += len(frame) + len(PING)
        places.append(end)
    assert set(places) <= set(ends)


@settings(max_examples=600)
@given(RECIPES, CUTS)
def test_no_frame_of_protocol_1_eats_a_request_of_protocol_2(recipe: bytes, cuts: bytes) -> None:
    """But for one that holds a whole header of protocol 2.0, which no servo can know."""
    frames = [frame for frame in cook(recipe, frame_1) if HEADER not in frame]
    stream = b"".join(frame + PING_2 for frame in frames)
    found = [p.frame for protocol, p in hear(cut(stream, cuts)) if protocol == 2]
    assert found.count(PING_2) == len(frames)


def test_each_parser_takes_its_own_frames_in_order() -> None:
    stream = PING + PING_2 + PING + PING + PING_2
    assert Ears().feed(stream, both=True) == [
        Arrival(1, Packet(1, 1, b"", 6, PING), 6),
        Arrival(2, Packet(1, 1, b"", 16, PING_2), 16),
        Arrival(1, Packet(1, 1, b"", 22, PING), 22),
        Arrival(1, Packet(1, 1, b"", 28, PING), 28),
        Arrival(2, Packet(1, 1, b"", 38, PING_2), 38),
    ]
