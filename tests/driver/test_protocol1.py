"""Codec and parser of Protocol 1.0 against the manual, the vendor's SDK, and damage."""

# ruff: noqa: N802 - the names are the SDK's

from itertools import pairwise

import pytest
from dynamixel_sdk import Protocol1PacketHandler
from hypothesis import given
from hypothesis import strategies as st

from armsyn.driver import protocol1
from armsyn.driver.parser import StatusPacket
from armsyn.driver.parser1 import StatusParser1

PAYLOADS = st.one_of(
    st.binary(max_size=30), st.lists(st.sampled_from([b"\xff", b"\x02"]), max_size=9).map(b"".join)
)
PACKETS = st.builds(StatusPacket, st.integers(0, 253), st.integers(0, 127), PAYLOADS, st.just(1))

# e-Manual, Protocol 1.0, examples of the instructions
MANUAL = {
    "ping": (protocol1.ping(1), "FF FF 01 02 01 FB"),
    "read": (protocol1.read(1, 43, 1), "FF FF 01 04 02 2B 01 CC"),
    "write": (protocol1.write(254, 3, b"\x01"), "FF FF FE 04 03 03 01 F6"),
    "sync write": (
        protocol1.sync_write(
            30, 4, [0, 1, 2, 3], bytes.fromhex("10005001 20026003 30007001 20028003")
        ),
        "FF FF FE 18 83 1E 04 00 10 00 50 01 01 20 02 60 03 02 30 00 70 01 03 20 02 80 03 12",
    ),
    "bulk read": (
        protocol1.bulk_read({1: (30, 2), 2: (36, 2)}),
        "FF FF FE 09 92 00 02 01 1E 02 02 24 1D",
    ),
}


def wire(packet: StatusPacket) -> bytes:
    return protocol1.packet(packet.servo_id, packet.error, packet.parameters)


def chunks(data: bytes, cuts: list[int]) -> list[bytes]:
    edges = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    return [data[a:b] for a, b in pairwise(edges)]


@pytest.mark.parametrize("name", MANUAL)
def test_packets_of_the_manual(name: str) -> None:
    built, text = MANUAL[name]
    assert built == bytes.fromhex(text)


class CapturingPort:
    """What the SDK's packet handler needs of a port, to see what it would send."""

    is_using = False

    def clearPort(self) -> None:
        pass

    def writePort(self, data: list[int]) -> int:
        self.sent = bytes(data)
        return len(data)


@given(st.integers(0, 254), st.integers(0, 255), PAYLOADS)
def test_packets_of_the_sdk(identifier: int, instruction: int, payload: bytes) -> None:
    port = CapturingPort()
    raw = [0, 0, identifier, len(payload) + 2, instruction, *payload, 0]
    Protocol1PacketHandler().txPacket(port, raw)
    assert protocol1.packet(identifier, instruction, payload) == port.sent


@pytest.mark.parametrize("identifier", [-1, 255])
def test_ids_no_servo_can_have(identifier: int) -> None:
    with pytest.raises(ValueError, match="ID"):
        protocol1.ping(identifier)


def test_what_does_not_fit() -> None:
    with pytest.raises(ValueError, match="254 parameters do not fit"):
        protocol1.packet(1, protocol1.WRITE, bytes(254))
    with pytest.raises(ValueError, match="3 bytes are not 2 for each of 2"):
        protocol1.sync_write(30, 2, [1, 2], b"abc")


@given(st.lists(PACKETS, max_size=6), st.lists(st.integers(0, 500), max_size=20))
def test_any_chunking_gives_the_same_packets(packets: list[StatusPacket], cuts: list[int]) -> None:
    parser = StatusParser1()
    stream = b"".join(map(wire, packets))
    assert [p for chunk in chunks(stream, cuts) for p in parser.feed(chunk)] == packets
    assert parser.pending == 0
    assert parser.counters.garbage_bytes == 0


@pytest.mark.fault(1)
@given(st.lists(st.tuples(st.binary(max_size=12), PACKETS), min_size=1, max_size=5))
def test_noise_between_packets_is_dropped_and_counted(
    noisy: list[tuple[bytes, StatusPacket]],
) -> None:
    clean = [(noise.replace(b"\xff", b"\x01"), packet) for noise, packet in noisy]
    parser = StatusParser1()
    stream = b"".join(noise + wire(packet) for noise, packet in clean)
    assert parser.feed(stream) == [packet for _, packet in clean]
    assert parser.counters.garbage_bytes == sum(len(noise) for noise, _ in clean)


@given(PACKETS, st.integers(0, 10_000))
def test_one_flipped_bit_never_gives_another_packet(packet: StatusPacket, bit: int) -> None:
    raw = bytearray(wire(packet))
    bit %= 8 * len(raw)
    raw[bit // 8] ^= 1 << bit % 8
    parser = StatusParser1()
    # the checksum is weak: with lengths that nobody asked for, a short end could pass for one
    parser.lengths = {len(packet.parameters) + 2}
    assert parser.feed(bytes(raw)) == []


@pytest.mark.fault(5)
@pytest.mark.parametrize("length", [0, 1, 3, 0xFE, 0xFF])
def test_a_length_that_lies(length: int) -> None:
    good = StatusPacket(2, 0, b"\x01\x02", 1)
    parser = StatusParser1()
    parser.lengths = {2, 4}
    assert parser.feed(protocol1.HEADER + bytes([1, length, 0]) + wire(good)) == [good]
    assert parser.counters.bad_length == 1


@pytest.mark.fault(2)
@given(PACKETS, st.integers(1, 40))
def test_a_truncated_packet_does_not_swallow_the_next(packet: StatusPacket, lost: int) -> None:
    raw = wire(packet)
    kept = raw[: max(1, len(raw) - lost)]
    following = StatusPacket(7, 0, b"\x0a\x0b\x0c", 1)
    parser = StatusParser1()
    parser.lengths = {2, 5}
    parser.feed(kept)
    assert parser.feed(wire(following) + wire(following))[-1] == following


@given(st.binary(max_size=300), st.lists(st.integers(0, 300), max_size=10))
def test_anything_at_all_is_survived(data: bytes, cuts: list[int]) -> None:
    parser = StatusParser1()
    for chunk in chunks(data, cuts):
        parser.feed(chunk)
    assert parser.pending < 4 + 255
    parser.reset()
    good = StatusPacket(9, 0x24, b"\xff\xff", 1)
    assert parser.feed(wire(good)) == [good]


def test_an_echo_is_no_answer() -> None:
    """An echo looks like a status packet: it is known by what was sent."""
    parser = StatusParser1()
    parser.own = protocol1.write(1, 30, b"ab") + protocol1.read(1, 36, 2)
    answer = StatusPacket(1, 0, b"\x24\x02", 1)
    assert parser.feed(parser.own + wire(answer)) == [answer]
    assert parser.counters.echoes == 2


@pytest.mark.parametrize("header", [b"\xff\xff\xff", b"\xff\xff\xff\xff\xff"])
def test_more_header_than_needed(header: bytes) -> None:
    good = StatusPacket(1, 0, b"\x07", 1)
    assert StatusParser1().feed(header + wire(good)[2:]) == [good]


def test_flags_of_the_error_byte() -> None:
    # e-Manual, Protocol 1.0, "Status Packet": 0x24 is overload and overheating
    ill = StatusPacket(1, 0x24, b"\x01", 1)
    assert ill.alert
    assert (ill.hardware_error, ill.error_number) == (0x24, 0)
    assert protocol1.flag_names(ill.error) == "overheating error, overload error"
    refused = StatusPacket(1, 0x09, b"", 1)
    assert (refused.hardware_error, refused.error_number) == (0x01, 0x08)
    assert refused.error_name == "range error"
    assert StatusPacket(1, 0x80, b"", 2).hardware_error is None
    assert protocol1.flag_names(0x80) == "unknown flag 0x80"
