"""Protocol 1.0 on servos that speak it from the factory, and on those that were set to it."""

import pytest

from firmware_sim.firmware.codes import HardwareError
from firmware_sim.firmware.servo import BOOT_TIME
from firmware_sim.wire.packet import build_packet
from firmware_sim.wire.packet1 import build_packet_1

from .wire import Wire, le, servo

RANGE, CHECKSUM, INSTRUCTION = 0x08, 0x10, 0x40
SPEAKS_1 = {"Protocol Type": 1}


def x_wire(**registers: int) -> Wire:
    names = {name.replace("_", " "): value for name, value in registers.items()}
    return Wire(servo("xm430-w350:1", registers=SPEAKS_1 | names))


def test_an_x_series_servo_set_to_protocol_1_answers_with_its_own_table() -> None:
    wire = x_wire()
    assert wire.ask_1(1, 0x01) == [(1, 0)]
    assert wire.ask_1(1, 0x02, 0, 2) == [(1, 0, 0xFC, 0x03)]
    assert wire.ask_1(1, 0x03, 65, 1) == [(1, 0)]
    assert wire.ask_1(1, 0x02, 65, 1) == [(1, 0, 1)]
    assert wire.ask(1, 0x01) == []


def test_protocol_type_counts_from_the_next_packet_on() -> None:
    wire = Wire("xm430-w350:1")
    assert wire.ask(1, 0x03, le(13) + b"\x01") == [(1, 0)]
    assert (wire.ask(1, 0x01), wire.ask_1(1, 0x01)) == ([], [(1, 0)])
    assert wire.ask_1(1, 0x03, 13, 2) == [(1, 0)]
    assert (wire.ask(1, 0x01)[0][0], wire.ask_1(1, 0x01)) == (1, [])


@pytest.mark.parametrize(
    ("instruction", "params", "bits"),
    [
        (0x77, (), INSTRUCTION),
        (0x05, (), INSTRUCTION),
        (0x02, (0,), INSTRUCTION),
        (0x02, (0, 2, 0), INSTRUCTION),
        (0x03, (65,), INSTRUCTION),
        (0x03, (), INSTRUCTION),
        (0x83, (65, 1, 1, 1), INSTRUCTION),
        (0x02, (0, 254), RANGE),
        (0x02, (14, 1), RANGE),
        (0x02, (0, 0), RANGE),
        (0x03, (0, 1), RANGE),
        (0x03, (65, 2), RANGE),
        (0x03, (116, 1, 2), RANGE),
    ],
)
def test_what_is_wrong_with_an_instruction_is_a_bit(
    instruction: int, params: tuple[int, ...], bits: int
) -> None:
    assert x_wire().ask_1(1, instruction, *params) == [(1, bits)]


def test_a_wrong_checksum_is_answered_and_does_nothing() -> None:
    wire = x_wire()
    frame = bytearray(build_packet_1(1, 0x03, b"\x41\x01"))
    frame[-1] ^= 1
    (answer,) = wire.answers_1(bytes(frame))
    assert (answer.servo_id, answer.instruction) == (1, CHECKSUM)
    assert wire.peek(65) == 0
    broken_broadcast = bytearray(build_packet_1(254, 0x03, b"\x41\x01"))
    broken_broadcast[-1] ^= 1
    assert wire.exchange(bytes(broken_broadcast)) == b""


def test_errors_of_the_servo_are_in_every_answer() -> None:
    wire = x_wire()
    wire.servos[0].raise_hardware_error(HardwareError.OVERLOAD)
    assert wire.ask_1(1, 0x01) == [(1, 0x20)]
    assert wire.ask_1(1, 0x02, 65, 1) == [(1, 0x20, 0)]
    assert wire.ask_1(1, 0x77) == [(1, 0x20 | INSTRUCTION)]


@pytest.mark.parametrize(("level", "answered"), [(0, [1]), (1, [1, 2]), (2, [1, 2, 3])])
def test_status_return_level_decides_what_is_answered(level: int, answered: list[int]) -> None:
    wire = x_wire()
    assert wire.ask_1(1, 0x03, 68, level) == [(1, 0)]
    found = [
        instruction
        for instruction, params in ((1, ()), (2, (65, 1)), (3, (65, 1)))
        if wire.ask_1(1, instruction, *params)
    ]
    assert found == answered


def test_all_obey_a_broadcast_and_only_a_ping_is_answered() -> None:
    wire = Wire(servo("xm430-w350:1", registers=SPEAKS_1), "ax-12a:2")
    assert wire.ask_1(254, 0x03, 65, 1) == []
    assert wire.peek(65, index=0) == 1
    assert wire.ask_1(254, 0x02, 0, 2) == []
    alone = Wire("ax-12a:7")
    assert alone.ask_1(254, 0x01) == [(7, 0)]


def test_several_answers_to_a_ping_of_all_collide() -> None:
    """The line is low where either pulls it: IDs 1 and 2 read 0, their checksums FC & FB."""
    wire = Wire("ax-12a:1", "ax-12a:2")
    assert wire.exchange(build_packet_1(254, 0x01)) == bytes.fromhex("FF FF 00 02 00 F8")


def test_reg_write_and_action() -> None:
    wire = Wire(*(servo(f"xm430-w350:{i}", registers=SPEAKS_1) for i in (1, 2)))
    for one in (1, 2):
        assert wire.ask_1(one, 0x04, 65, 1) == [(one, 0)]
    assert [wire.peek(65, index=i) for i in (0, 1)] == [0, 0]
    assert wire.ask_1(254, 0x05) == []
    assert [wire.peek(65, index=i) for i in (0, 1)] == [1, 1]


def test_reboot_is_known_to_newer_servos_only() -> None:
    wire = x_wire()
    assert wire.ask_1(1, 0x08) == [(1, 0)]
    assert wire.ask_1(1, 0x01) == []
    wire.wait(BOOT_TIME)
    assert wire.ask_1(1, 0x01) == [(1, 0)]
    assert Wire("ax-12a:1").ask_1(1, 0x08) == [(1, INSTRUCTION)]
    assert Wire(servo("mx-28:1", firmware=39)).ask_1(1, 0x08) == [(1, INSTRUCTION)]
    assert Wire(servo("mx-28:1", firmware=40)).ask_1(1, 0x08) == [(1, 0)]


def test_a_reset_of_all_is_obeyed_by_older_servos_only() -> None:
    wire = Wire(
        "ax-12a:5",
        servo("mx-28:6", firmware=39),
        servo("mx-28:7", firmware=40),
        servo("xm430-w350:8", registers=SPEAKS_1),
    )
    assert wire.ask_1(254, 0x06) == []
    assert [one.servo_id for one in wire.servos] == [1, 1, 7, 8]


def test_a_factory_reset_is_answered_under_the_old_id() -> None:
    wire = x_wire(Status_Return_Level=2)
    assert wire.ask_1(1, 0x06) == [(1, 0)]
    assert wire.servos[0].protocol == 2


def test_bulk_read_takes_the_first_share_of_an_id() -> None:
    wire = Wire("mx-28:1", "mx-64:2", "mx-28:3")
    number = {1: (29, 0), 2: (0x36, 1), 3: (29, 0)}
    asked = (0, 2, 3, 0, 2, 1, 0, 2, 2, 0)
    assert wire.ask_1(254, 0x92, *asked) == [(i, 0, *number[i]) for i in (3, 1, 2)]
    assert wire.ask_1(254, 0x92, 0, 2, 1, 0, 2, 1, 0, 2, 2, 0) == [(1, 0, *number[1])]
    assert wire.ask_1(254, 0x92, 0, 2, 1, 0, 2, 9, 0, 2, 2, 0) == [(1, 0, *number[1])]


def test_bulk_read_ends_before_a_servo_that_does_not_know_it() -> None:
    wire = Wire("mx-28:1", "ax-12a:2", "mx-28:3")
    asked = (0, 2, 1, 0, 2, 2, 0, 2, 3, 0)
    assert [answer[0] for answer in wire.ask_1(254, 0x92, *asked)] == [1]


def test_a_sync_write_with_a_short_last_share_leaves_it_out() -> None:
    wire = Wire(*(servo(f"xm430-w350:{i}", registers=SPEAKS_1) for i in (1, 2)))
    assert wire.ask_1(254, 0x83, 80, 2, 1, 5, 0, 2, 6) == []
    assert [wire.peek(80, 2, i) for i in (0, 1)] == [5, 0]


def test_a_secondary_id_is_obeyed_in_this_protocol_too() -> None:
    wire = x_wire(**{"Secondary(Shadow)_ID": 100})
    assert wire.ask_1(100, 0x03, 65, 1) == []
    assert wire.peek(65) == 1
    assert wire.ask_1(100, 0x03, 9, 7) == []
    assert wire.peek(9) == 0


def test_each_protocols_servos_hear_their_own_frames_only() -> None:
    """The same ID twice, once a protocol: neither disturbs the other."""
    wire = Wire("xm430-w350:1", "ax-12a:1")
    assert wire.ask(1, 0x01) == [(1, 0, 0xFC, 0x03, wire.servos[0].model.firmware)]
    assert wire.ask_1(1, 0x02, 0, 2) == [(1, 0, 12, 0)]
    assert wire.ask(254, 0x03, le(65) + b"\x01") == []
    assert (wire.peek(65, index=0), wire.peek(25, index=1)) == (1, 0)
    assert wire.ask_1(254, 0x03, 25, 1) == []
    assert wire.peek(25, index=1) == 1


def test_negative_goals_of_protocol_2_do_not_hide_requests_of_protocol_1() -> None:
    """FF FF FF FF before an ID looks like a header: its LEN must not take in what follows."""
    wire = Wire("xm430-w350:1", "ax-12a:9")
    shares = b"".join(bytes((i, 0xFF, 0xFF, 0xFF, 0xFF)) for i in (1, 200, 250, 9, 77))
    for _ in range(20):
        assert wire.exchange(build_packet(254, 0x83, le(116, 4) + shares)) == b""
        assert wire.ask_1(9, 0x01) == [(9, 0)]
        assert wire.ask(1, 0x01)
