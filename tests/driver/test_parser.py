"""The status parser under any chunking, noise and damage."""

from itertools import pairwise

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from armsyn.driver import protocol
from armsyn.driver.parser import StatusPacket, StatusParser

PATTERN = b"\xff\xff\xfd"
PAYLOADS = st.one_of(
    st.binary(max_size=30),
    st.lists(st.sampled_from([b"\xff", b"\xfd", b"\x00", PATTERN]), max_size=12).map(b"".join),
)
PACKETS = st.builds(
    StatusPacket, st.integers(0, 252), st.sampled_from([0, 7, 0x80, 0x87]), PAYLOADS, st.just(2)
)


def wire(packet: StatusPacket) -> bytes:
    body = bytes([packet.error]) + packet.parameters
    return protocol.packet(packet.servo_id, protocol.STATUS, body)


def chunks(data: bytes, cuts: list[int]) -> list[bytes]:
    edges = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    return [data[a:b] for a, b in pairwise(edges)]


def test_status_of_the_manual() -> None:
    # e-Manual, Protocol 2.0, ping: ID 1, model 1030, firmware 38
    parser = StatusParser()
    packets = parser.feed(bytes.fromhex("FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"))
    assert packets == [StatusPacket(1, 0, b"\x06\x04\x26")]


@given(st.lists(PACKETS, max_size=6), st.lists(st.integers(0, 500), max_size=20))
def test_any_chunking_gives_the_same_packets(packets: list[StatusPacket], cuts: list[int]) -> None:
    parser = StatusParser()
    stream = b"".join(map(wire, packets))
    found = [p for chunk in chunks(stream, cuts) for p in parser.feed(chunk)]
    assert found == packets
    assert parser.pending == 0
    assert parser.counters.garbage_bytes == 0


@pytest.mark.fault(1)
@given(st.lists(st.tuples(st.binary(max_size=12), PACKETS), min_size=1, max_size=5))
def test_noise_between_packets_is_dropped_and_counted(
    noisy: list[tuple[bytes, StatusPacket]],
) -> None:
    # noise that begins a header of its own may swallow what follows; that is another test
    clean = [(noise.replace(b"\xff", b"\x01"), packet) for noise, packet in noisy]
    parser = StatusParser()
    stream = b"".join(noise + wire(packet) for noise, packet in clean)
    assert parser.feed(stream) == [packet for _, packet in clean]
    assert parser.counters.garbage_bytes == sum(len(noise) for noise, _ in clean)


@pytest.mark.fault(3)
@given(PACKETS, st.integers(0, 10_000))
@example(StatusPacket(1, 0, b""), 5 * 8)
def test_one_flipped_bit_never_gives_another_packet(packet: StatusPacket, bit: int) -> None:
    raw = bytearray(wire(packet))
    bit %= 8 * len(raw)
    raw[bit // 8] ^= 1 << bit % 8
    assert StatusParser().feed(bytes(raw)) == []


@pytest.mark.fault(2)
@given(PACKETS, PACKETS, st.integers(1, 40))
def test_a_truncated_packet_does_not_swallow_the_next(
    first: StatusPacket, second: StatusPacket, lost: int
) -> None:
    raw, following = wire(first), wire(second)
    kept = raw[: max(1, len(raw) - lost)]
    # a packet whose lost end reads as the next one's start (FF, FF FF) is whole on the wire
    assume(not (kept + following).startswith(raw))
    parser = StatusParser()
    parser.feed(kept)
    assert parser.feed(following) == [second]


def test_a_lost_end_that_the_next_packet_supplies() -> None:
    first = StatusPacket(65, 7, b"\xff\xfd\x00\xff\xff\xfd")
    raw = wire(first)
    assert raw[-1] == 0xFF
    parser = StatusParser()
    parser.feed(raw[:-1])
    assert parser.feed(wire(StatusPacket(0, 0, b""))) == [first]  # it cannot be told from a loss
    assert parser.feed(wire(StatusPacket(2, 0, b""))) == [StatusPacket(2, 0, b"")]


@pytest.mark.fault(5)
@pytest.mark.parametrize("length", [0, 1, 2, 0x0100, 0xFFFF])
def test_a_length_that_lies(length: int) -> None:
    lying = protocol.HEADER + bytes([1, length & 0xFF, length >> 8, protocol.STATUS, 0])
    good = StatusPacket(2, 0, b"\x01\x02")
    parser = StatusParser(maximum_length=20)
    assert parser.feed(lying + wire(good)) == [good]
    assert parser.counters.bad_length == 1


def test_an_echo_is_no_answer() -> None:
    parser = StatusParser()
    echo = parser.own = protocol.sync_read(126, 10, [1, 2])
    stranger = protocol.ping(3)
    answer = StatusPacket(1, 0, b"\x00" * 10)
    assert parser.feed(echo + stranger + wire(answer)) == [answer]
    assert parser.counters.echoes == 1
    assert parser.counters.foreign == 1


@given(st.integers(1, 10), st.integers(0, 243), st.binary(min_size=1, max_size=30))
def test_a_fast_read_that_came_too_late_is_no_other_master(
    servos: int, first: int, data: bytes
) -> None:
    """e-Manual, Protocol 2.0, fast sync read: one status of ID 254, each servo's part by its ID."""
    body = b"".join(bytes([0, first + k]) + data for k in range(servos))
    late = protocol.packet(254, protocol.STATUS, body)
    parser, answer = StatusParser(), StatusPacket(1, 0, b"\x00" * 10)
    assert parser.feed(late + wire(answer)) == [answer]
    assert parser.counters.foreign == 0
    assert parser.counters.garbage_bytes == len(late)


@pytest.mark.fault(1)
@given(st.binary(max_size=300), st.lists(st.integers(0, 300), max_size=10))
def test_anything_at_all_is_survived(data: bytes, cuts: list[int]) -> None:
    parser = StatusParser(maximum_length=64)
    for chunk in chunks(data, cuts):
        parser.feed(chunk)
    assert parser.pending < 64 + 7
    parser.reset()
    good = StatusPacket(9, 0x80, PATTERN)
    assert parser.feed(wire(good)) == [good]


@pytest.mark.fault(20)
def test_the_alert_bit_keeps_the_data() -> None:
    packet = StatusParser().feed(wire(StatusPacket(4, 0x80, b"\x2a")))[0]
    assert packet.alert
    assert packet.error_number == 0
    assert packet.parameters == b"\x2a"
