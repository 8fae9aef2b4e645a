"""Frames of protocol 1.0: the manual's byte vectors and the checksum."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_sim.wire.packet1 import build_packet_1, checksum
from firmware_sim.wire.parser import Packet
from firmware_sim.wire.parser1 import PacketParser1

# Instruction and status packets printed in the e-Manual's page on Protocol 1.0.
MANUAL_PACKETS = [
    (1, 0x03, "0C 64 AA", "FF FF 01 05 03 0C 64 AA DC"),
    (1, 0x24, "", "FF FF 01 02 24 D8"),
    (1, 0x01, "", "FF FF 01 02 01 FB"),
    (1, 0x00, "", "FF FF 01 02 00 FC"),
    (1, 0x02, "2B 01", "FF FF 01 04 02 2B 01 CC"),
    (1, 0x00, "20", "FF FF 01 03 00 20 DB"),
    (254, 0x03, "03 01", "FF FF FE 04 03 03 01 F6"),
    (1, 0x04, "1E F4 01", "FF FF 01 05 04 1E F4 01 E2"),
    (254, 0x05, "", "FF FF FE 02 05 FA"),
    (0, 0x06, "", "FF FF 00 02 06 F7"),
    (0, 0x00, "", "FF FF 00 02 00 FD"),
    (1, 0x08, "", "FF FF 01 02 08 F4"),
    (
        254,
        0x83,
        "1E 04 00 10 00 50 01 01 20 02 60 03",
        "FF FF FE 0E 83 1E 04 00 10 00 50 01 01 20 02 60 03 67",
    ),
    (254, 0x92, "00 02 01 1E 02 02 24", "FF FF FE 09 92 00 02 01 1E 02 02 24 1D"),
    (1, 0x00, "00 80", "FF FF 01 04 00 00 80 7A"),
    (2, 0x00, "00 80", "FF FF 02 04 00 00 80 79"),
]


@pytest.mark.parametrize(("servo_id", "instruction", "params", "frame"), MANUAL_PACKETS)
def test_builds_and_parses_the_manuals_packets(
    servo_id: int, instruction: int, params: str, frame: str
) -> None:
    raw = bytes.fromhex(frame)
    assert build_packet_1(servo_id, instruction, bytes.fromhex(params)) == raw
    expected = Packet(servo_id, instruction, bytes.fromhex(params), len(raw), raw)
    assert PacketParser1().feed(raw) == [expected]


@settings(max_examples=600)
@given(st.binary(max_size=255), st.data())
def test_the_checksum_finds_each_single_flipped_bit(body: bytes, data: st.DataObject) -> None:
    assert (sum(body) + checksum(body)) & 0xFF == 0xFF
    if body:
        broken = bytearray(body)
        broken[data.draw(st.integers(0, len(body) - 1))] ^= 1 << data.draw(st.integers(0, 7))
        assert checksum(broken) != checksum(body)


@settings(max_examples=600)
@given(st.integers(0, 254), st.integers(0, 255), st.binary(max_size=253))
def test_what_is_built_is_parsed(servo_id: int, instruction: int, params: bytes) -> None:
    frame = build_packet_1(servo_id, instruction, params)
    expected = Packet(servo_id, instruction, params, len(frame), frame)
    assert PacketParser1().feed(frame) == [expected]
