"""What people are told of the frames on a bus."""

import pytest

from firmware_sim.meaning import Heard, Said
from firmware_sim.packet import build_fast_status, build_packet, build_status
from firmware_sim.packet1 import build_packet_1
from firmware_sim.parser import PacketParser
from firmware_sim.parser1 import PacketParser1


@pytest.mark.parametrize(
    ("servo_id", "instruction", "params", "meaning"),
    [
        (1, 0x01, "", "ID 1: ping"),
        (254, 0x01, "", "all: ping"),
        (1, 0x02, "84 00 04 00", "ID 1: read 132, 4 bytes"),
        (1, 0x02, "84", "ID 1: read 84"),
        (1, 0x03, "74 00 00 02 00 00", "ID 1: write 116: 00 02 00 00"),
        (1, 0x04, "41 00 01", "ID 1: reg write 65: 01"),
        (1, 0x06, "FF", "ID 1: factory reset FF"),
        (1, 0x77, "", "ID 1: instruction 77"),
        (254, 0x82, "84 00 04 00 01 02", "all: sync read 132, 4 bytes of 1 2"),
        (254, 0x8A, "84 00 04 00 01 02", "all: fast sync read 132, 4 bytes of 1 2"),
        (254, 0x83, "41 00 01 00 01 00 02 01", "all: sync write 1 at 65: 00; 2 at 65: 01"),
        (
            254,
            0x92,
            "01 90 00 02 00 02 92 00 01 00",
            "all: bulk read 144, 2 bytes of 1; 146, 1 bytes of 2",
        ),
        (254, 0x93, "01 20 00 02 00 A0 00", "all: bulk write 1 at 32: A0 00"),
        (254, 0x82, "", "all: sync read"),
    ],
)
def test_requests_of_protocol_2(servo_id: int, instruction: int, params: str, meaning: str) -> None:
    (packet,) = PacketParser().feed(build_packet(servo_id, instruction, bytes.fromhex(params)))
    assert Heard(0.0, 2, packet).meaning == meaning


@pytest.mark.parametrize(
    ("servo_id", "instruction", "params", "meaning"),
    [
        (1, 0x01, "", "ID 1: ping"),
        (1, 0x02, "2B 01", "ID 1: read 43, 1 bytes"),
        (254, 0x03, "03 01", "all: write 3: 01"),
        (254, 0x83, "1E 01 00 10 01 20", "all: sync write 0 at 30: 10; 1 at 30: 20"),
        (254, 0x92, "00 02 01 1E 02 02 24", "all: bulk read 30, 2 bytes of 1; 36, 2 bytes of 2"),
    ],
)
def test_requests_of_protocol_1(servo_id: int, instruction: int, params: str, meaning: str) -> None:
    (packet,) = PacketParser1().feed(build_packet_1(servo_id, instruction, bytes.fromhex(params)))
    assert Heard(0.0, 1, packet).meaning == meaning


@pytest.mark.parametrize(
    ("protocol", "data", "meaning"),
    [
        (2, build_status(1, 0), "ID 1: status"),
        (2, build_status(1, 0, b"\x1f\x08"), "ID 1: status, 1F 08"),
        (2, build_status(1, 0x87), "ID 1: status, alert, access error"),
        (2, build_status(1, 0x09), "ID 1: status, error 9"),
        (2, build_status(1, 0)[:-1], "unreadable, 10 bytes"),
        (2, build_packet(1, 0x55), "unreadable, 10 bytes"),
        (2, build_fast_status(7, [(0, 3, b"\xa6\0")]), "together: status, 03 A6 00"),
        (1, build_packet_1(1, 0), "ID 1: status"),
        (1, build_packet_1(1, 0x24), "ID 1: status, overheating error, overload error"),
        (
            1,
            build_packet_1(1, 0x4A),
            "ID 1: status, angle limit error, range error, instruction error",
        ),
        (1, b"\xff\xff\x01", "unreadable, 3 bytes"),
    ],
)
def test_answers(protocol: int, data: bytes, meaning: str) -> None:
    assert Said(0.0, protocol, data).meaning == meaning
