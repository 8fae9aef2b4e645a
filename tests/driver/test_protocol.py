"""The codec against the manual's packets, the vendor's SDK, and itself."""

# ruff: noqa: N802 - the names are the SDK's

import pytest
from dynamixel_sdk import Protocol2PacketHandler
from fastcrc.crc16 import umts as crc16
from hypothesis import given
from hypothesis import strategies as st

from armsyn.driver import protocol

PATTERN = b"\xff\xff\xfd"
AWKWARD = st.lists(st.sampled_from([b"\xff", b"\xfd", b"\x00", PATTERN, b"\x12"]), max_size=40)
PAYLOADS = st.one_of(st.binary(max_size=120), AWKWARD.map(b"".join))


# e-Manual, Protocol 2.0, examples of ping, read and write
MANUAL = {
    "ping": (protocol.ping(1), "FF FF FD 00 01 03 00 01 19 4E"),
    "broadcast ping": (protocol.ping(254), "FF FF FD 00 FE 03 00 01 31 42"),
    "read": (protocol.read(1, 132, 4), "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
    "write": (
        protocol.write(1, 116, (512).to_bytes(4, "little")),
        "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89",
    ),
}


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


def sdk_packet(identifier: int, instruction: int, parameters: bytes) -> bytes:
    port = CapturingPort()
    size = len(parameters) + 3
    raw = [0, 0, 0, 0, identifier, size & 0xFF, size >> 8, instruction, *parameters, 0, 0]
    Protocol2PacketHandler().txPacket(port, raw)
    return port.sent


@given(st.integers(0, 252), st.integers(0, 0x93), PAYLOADS)
def test_packets_of_the_sdk(identifier: int, instruction: int, payload: bytes) -> None:
    payload = payload.replace(PATTERN, b"\xff\xff\xfc")  # the SDK forgets to stuff
    assert protocol.packet(identifier, instruction, payload) == sdk_packet(
        identifier, instruction, payload
    )


@given(st.binary(max_size=200))
def test_crc_of_the_sdk(data: bytes) -> None:
    assert crc16(data) == Protocol2PacketHandler().updateCRC(0, list(data), len(data))


@pytest.mark.fault(4)
@given(PAYLOADS)
def test_unstuffing_undoes_stuffing(payload: bytes) -> None:
    assert protocol.unstuff(protocol.stuff(payload)) == payload


@pytest.mark.fault(4)
@given(PAYLOADS)
def test_no_header_inside_a_packet(payload: bytes) -> None:
    built = protocol.packet(1, protocol.WRITE, payload)
    assert built.rfind(protocol.HEADER, 0, len(built) - 2) == 0
    assert int.from_bytes(built[5:7], "little") == len(built) - 7


@pytest.mark.fault(4)
@pytest.mark.parametrize("offset", range(12))
def test_stuffing_at_every_offset(offset: int) -> None:
    payload = bytes(range(1, offset + 1)) + PATTERN + b"\x07"
    built = protocol.packet(1, protocol.WRITE, payload)
    assert built[8:-2] == payload[:offset] + PATTERN + b"\xfd\x07"


def test_sync_packets_hold_every_servo_in_order() -> None:
    read = protocol.sync_read(132, 4, [3, 1, 2])
    assert read[4:-2] == bytes([254, 10, 0, 0x82, 132, 0, 4, 0, 3, 1, 2])
    write = protocol.sync_write(116, 2, [3, 1], b"abcd")
    assert write[7:-2] == b"\x83\x74\x00\x02\x00\x03ab\x01cd"


@pytest.mark.parametrize("identifier", [-1, 253, 255, 256])
def test_ids_no_servo_can_have(identifier: int) -> None:
    with pytest.raises(ValueError, match="ID"):
        protocol.ping(identifier)


def test_sync_write_of_the_wrong_size() -> None:
    with pytest.raises(ValueError, match="3 bytes are not 2 for each of 2"):
        protocol.sync_write(116, 2, [1, 2], b"abc")
