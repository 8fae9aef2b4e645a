"""What lines of a trace say of single frames; what goes over a whole bus is in ``test_trace``."""

import pytest

from firmware_sim.trace.text import Narrator
from firmware_sim.wire.observed import Heard, Said
from firmware_sim.wire.packet import build_fast_status, build_packet, build_status
from firmware_sim.wire.packet1 import build_packet_1
from firmware_sim.wire.parser import PacketParser
from firmware_sim.wire.parser1 import PacketParser1

from .wire import Wire


@pytest.fixture
def narrator() -> Narrator:
    return Narrator(Wire("xm430-w350:1", "mx-28:2").servos, start=0.0)


def words(line: str) -> str:
    """Whom a line is about, and what it says, without time, direction, protocol and bytes."""
    return " ".join(line.partition("|")[0].split()[3:])


@pytest.mark.parametrize(
    ("servo_id", "instruction", "params", "said"),
    [
        (1, 0x01, "", "ID 1 ping"),
        (254, 0x01, "", "all ping"),
        (1, 0x02, "84 00 04 00", "ID 1 read Present Position [132..135]"),
        (9, 0x02, "84 00 04 00", "ID 9 read no register [132..135]"),
        (1, 0x02, "84", "ID 1 read 84"),
        (1, 0x03, "74 00 00 02 00 00", "ID 1 write Goal Position = 512 tick"),
        (1, 0x04, "41 00 01", "ID 1 reg write LED = 1"),
        (1, 0x06, "FF", "ID 1 factory reset FF"),
        (1, 0x77, "", "ID 1 instruction 77"),
        (254, 0x82, "84 00 04 00 01 09", "all sync read 1: Present Position [132..135]; 9: no"),
        (254, 0x8A, "41 00 01 00 01", "all fast sync read LED [65..65] of 1"),
        (254, 0x83, "41 00 01 00 01 00 09 01", "all sync write 1: LED = 0; 9: 01"),
        (254, 0x92, "01 41 00 01 00 09 92 00 01 00", "all bulk read 1: LED [65..65]; 9: no"),
        (254, 0x93, "01 41 00 01 00 01", "all bulk write 1: LED = 1"),
        (254, 0x82, "", "all sync read"),
    ],
)
def test_requests_of_protocol_2(
    narrator: Narrator, servo_id: int, instruction: int, params: str, said: str
) -> None:
    (packet,) = PacketParser().feed(build_packet(servo_id, instruction, bytes.fromhex(params)))
    assert words(narrator.heard(Heard(0.0, 2, packet))).startswith(said)


@pytest.mark.parametrize(
    ("servo_id", "instruction", "params", "said"),
    [
        (2, 0x01, "", "ID 2 ping"),
        (2, 0x02, "2B 01", "ID 2 read Present Temperature [43..43]"),
        (2, 0x03, "19 01", "ID 2 write LED = 1"),
        (254, 0x83, "19 01 02 01 09 20", "all sync write 2: LED = 1; 9: 20"),
        (254, 0x92, "00 01 02 19 02 09 24", "all bulk read 2: LED [25..25]; 9: no register"),
        (254, 0x83, "", "all sync write"),
    ],
)
def test_requests_of_protocol_1(
    narrator: Narrator, servo_id: int, instruction: int, params: str, said: str
) -> None:
    (packet,) = PacketParser1().feed(build_packet_1(servo_id, instruction, bytes.fromhex(params)))
    assert words(narrator.heard(Heard(0.0, 1, packet))).startswith(said)


@pytest.mark.parametrize(
    ("protocol", "data", "said"),
    [
        (2, build_status(1, 0), "ID 1 status"),
        (2, build_status(1, 0, b"\x1f\x08"), "ID 1 status 1F 08"),
        (2, build_status(1, 0x87), "ID 1 status ALERT, ERROR access"),
        (2, build_status(1, 0x09), "ID 1 status ERROR number 9"),
        (2, build_status(1, 0)[:-1], "? COLLISION servos that talk at once"),
        (2, build_packet(1, 0x55), "ID 1 no status"),
        (2, build_fast_status(7, [(0, 3, b"\xa6\0")]), "all status"),
        (1, build_packet_1(1, 0), "ID 1 status"),
        (1, build_packet_1(1, 0x24), "ID 1 status ERROR overheating, ERROR overload"),
        (1, build_packet_1(1, 0x4A), "ID 1 status ERROR angle limit, ERROR range, ERROR instr"),
        (1, b"\xff\xff\x01", "? COLLISION servos that talk at once"),
    ],
)
def test_answers(narrator: Narrator, protocol: int, data: bytes, said: str) -> None:
    assert words(narrator.said(Said(0.0, protocol, data))).startswith(said)
