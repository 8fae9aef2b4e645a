"""Decoding at one go finds what the parser finds, and fast answers part by part."""

from itertools import pairwise

import pytest
from fastcrc.crc16 import umts as crc16
from hypothesis import given
from hypothesis import strategies as st

from armsyn.driver import protocol
from armsyn.driver.collecting import FastCollector
from armsyn.driver.parser import ParserCounters, StatusPacket, StatusParser
from armsyn.driver.quick import FastDecoding, FastLayout, StatusDecoding, StatusLayout

PATTERN = b"\xff\xff\xfd"
SIZE = 6
DATA = st.one_of(
    st.binary(min_size=SIZE, max_size=SIZE),
    st.sampled_from([PATTERN * 2, b"\x01\xff\xff\xfd\xfd\x00", bytes(SIZE), b"\x00\x01" + PATTERN]),
)
REPLIES = st.lists(
    st.builds(StatusPacket, st.integers(0, 252), st.sampled_from([0, 0x80]), DATA, st.just(2)),
    min_size=1,
    max_size=6,
    unique_by=lambda packet: packet.servo_id,
)
CUTS = st.lists(st.integers(0, 200), max_size=8)


def wire(packets: list[StatusPacket]) -> bytes:
    return b"".join(
        protocol.packet(p.servo_id, protocol.STATUS, bytes([p.error]) + p.parameters)
        for p in packets
    )


def fast_wire(packets: list[StatusPacket], size: int = SIZE) -> bytes:
    """e-Manual, "Fast Sync Read": bit by bit, as the servos do it."""
    length = 1 + len(packets) * (size + 4)
    data = protocol.HEADER + bytes([0xFE, length & 0xFF, length >> 8, 0x55])
    for packet in packets:
        data += bytes([packet.error, packet.servo_id]) + packet.parameters
        data += crc16(data).to_bytes(2, "little")
    return data


def growing(data: bytes, cuts: list[int]) -> list[bytes]:
    return [data[:cut] for cut in sorted({c % (len(data) + 1) for c in cuts})]


@given(REPLIES, CUTS)
def test_what_is_decoded_is_what_the_parser_finds(packets: list[StatusPacket], cuts: list) -> None:
    data = wire(packets)
    decoding = StatusDecoding(StatusLayout({p.servo_id: SIZE for p in packets}))
    for part in growing(data, cuts):
        decoding.look(part)
    found = decoding.result(data)
    stuffed = any(len(p.parameters) != SIZE or PATTERN in p.parameters for p in packets)
    if found is None:
        assert stuffed
    else:
        assert list(found.values()) == packets == StatusParser().feed(data)


@pytest.mark.fault(3)
@given(REPLIES, st.integers(0, 10_000), CUTS)
def test_one_flipped_bit_is_left_to_the_parser(
    packets: list[StatusPacket], bit: int, cuts: list[int]
) -> None:
    raw = bytearray(wire(packets))
    bit %= 8 * len(raw)
    raw[bit // 8] ^= 1 << bit % 8
    decoding = StatusDecoding(StatusLayout({p.servo_id: SIZE for p in packets}))
    for part in growing(bytes(raw), cuts):
        decoding.look(part)
    assert decoding.result(bytes(raw)) is None


@pytest.mark.parametrize("change", [b"", b"\x00"])
def test_too_few_and_too_many_bytes(change: bytes) -> None:
    data = wire([StatusPacket(1, 0, bytes(SIZE))])
    other = data + change if change else data[:-1]
    assert StatusDecoding(StatusLayout({1: SIZE})).result(other) is None


# e-Manual, Protocol 2.0, "Fast Sync Read": 166, 2079 and 1023 of the servos 3, 7 and 4
MANUAL = bytes.fromhex(
    "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA00 04 FF 03 00 00 D1 9E"
)
MANUAL_SIZES = {3: 4, 7: 4, 4: 4}


def test_the_manuals_fast_answer() -> None:
    layout = FastLayout(MANUAL_SIZES)
    assert layout.size == len(MANUAL)
    found = FastDecoding(layout).result(MANUAL)
    assert found is not None
    values = {i: int.from_bytes(p.parameters, "little") for i, p in found.items()}
    assert values == {3: 166, 7: 2079, 4: 1023}


@given(REPLIES.filter(lambda ps: all(len(p.parameters) == SIZE for p in ps)), CUTS)
def test_fast_answers_in_any_chunks(packets: list[StatusPacket], cuts: list[int]) -> None:
    layout = FastLayout({p.servo_id: SIZE for p in packets})
    data = fast_wire(packets)
    decoding = FastDecoding(layout)
    for part in growing(data, cuts):
        decoding.look(part)
    assert list((decoding.result(data) or {}).values()) == packets
    collector = FastCollector(layout, ParserCounters())
    edges = [0, *sorted({c % len(data) for c in cuts}), len(data)]
    collector.feed(b"\x00\xff")  # noise before
    for a, b in pairwise(edges):
        collector.feed(data[a:b])
    assert collector.complete
    assert list(collector.replies.values()) == packets


@given(st.integers(0, len(MANUAL) - 1))
def test_a_silent_servo_ends_the_answer(kept: int) -> None:
    collector = FastCollector(FastLayout(MANUAL_SIZES), ParserCounters())
    collector.feed(MANUAL[:kept])
    collector.finish()
    assert not collector.complete
    assert list(collector.replies) == [3, 7, 4][: max(0, (kept - 8) // 8)]


@given(st.integers(8 * 8, 8 * len(MANUAL) - 1))
def test_one_flipped_bit_of_a_fast_answer(bit: int) -> None:
    """It takes its own servo's part, and the next one's if it is in a CRC; the others stay."""
    raw = bytearray(MANUAL)
    raw[bit // 8] ^= 1 << bit % 8
    counters = ParserCounters()
    collector = FastCollector(FastLayout(MANUAL_SIZES), counters)
    collector.feed(bytes(raw))
    good = FastDecoding(FastLayout(MANUAL_SIZES)).result(MANUAL)
    assert good is not None
    assert collector.replies.items() <= good.items()
    place = (bit // 8 - 8) // 8
    lost = {place, place + 1} if (bit // 8) % 8 >= 6 else {place}
    assert [n for n, i in enumerate(MANUAL_SIZES) if i not in collector.replies] == sorted(
        lost & {0, 1, 2}
    )
    assert counters.bad_crc == 3 - len(collector.replies)


@pytest.mark.fault(20)
def test_each_servos_error_byte_is_kept() -> None:
    packets = [StatusPacket(1, 0x80, bytes(SIZE)), StatusPacket(2, 7, bytes(SIZE))]
    found = FastDecoding(FastLayout({1: SIZE, 2: SIZE})).result(fast_wire(packets))
    assert found is not None
    assert found[1].alert
    assert found[2].error_number == 7
