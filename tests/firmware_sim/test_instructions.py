"""What each instruction is answered with, on the stepped clock."""

from collections.abc import Callable

import pytest

from firmware_sim.firmware.codes import HardwareError, StatusError
from firmware_sim.firmware.servo import BOOT_TIME
from firmware_sim.rig.settings import ServoSettings

from .conftest import Bench
from .wire import Wire, le, servo

MakeBench = Callable[..., Bench]
GOAL_POSITION, PRESENT_POSITION = 116, 132
CLEAR = bytes.fromhex("01 44 58 4C 22")


def test_ping_tells_model_and_firmware(bench: MakeBench) -> None:
    assert bench().ask(1, 0x01) == [(1, 0, 1020 & 0xFF, 1020 >> 8, 45)]


def test_broadcast_ping_is_answered_in_order_of_ids(bench: MakeBench) -> None:
    rig = bench("xm430-w350:9", "xl330-m288:3", "xm540-w270:5")
    assert [answer[0] for answer in rig.ask(254, 0x01)] == [3, 5, 9]


def test_nobody_answers_for_another_id(bench: MakeBench) -> None:
    assert bench().ask(2, 0x01) == []


def test_unknown_instructions_are_answered_with_an_instruction_error(bench: MakeBench) -> None:
    rig = bench()
    for instruction in (0x00, 0x07, 0x09, 0x21, 0x54, 0x81, 0xFF):
        assert rig.ask(1, instruction) == [(1, StatusError.INSTRUCTION)]
        assert rig.ask(254, instruction) == []


def test_status_packets_of_others_are_ignored(bench: MakeBench) -> None:
    assert bench().ask(1, 0x55, b"\x00") == []


def test_read_outside_the_table_is_an_access_error_without_data(bench: MakeBench) -> None:
    rig = bench()
    for address, size in ((660, 4), (662, 1), (14, 2), (132, 0), (0xFFFF, 1)):
        assert rig.ask(1, 0x02, le(address, size)) == [(1, StatusError.ACCESS)]


def test_read_of_the_whole_table_fills_holes_with_zeros(bench: MakeBench) -> None:
    ((_, error, *data),) = bench().ask(1, 0x02, le(0, 147))
    assert error == 0
    assert len(data) == 147
    assert data[14:20] == [0] * 6
    assert data[0:2] == [0xFC, 0x03]


def test_read_and_write_with_too_few_parameters_are_length_errors(bench: MakeBench) -> None:
    rig = bench()
    assert rig.ask(1, 0x02, b"\x84\x00\x04") == [(1, StatusError.DATA_LENGTH)]
    assert rig.ask(1, 0x03, b"\x40\x00") == [(1, StatusError.DATA_LENGTH)]


def test_a_registered_write_waits_for_the_action(bench: MakeBench) -> None:
    rig = bench()
    assert rig.ask(1, 0x04, le(65) + b"\x01") == [(1, 0)]
    assert (rig.read(69), rig.read(65)) == (1, 0)
    assert rig.ask(1, 0x05) == [(1, 0)]
    assert (rig.read(69), rig.read(65)) == (0, 1)


def test_an_action_with_nothing_registered_is_an_instruction_error(bench: MakeBench) -> None:
    rig = bench()
    assert rig.ask(1, 0x05) == [(1, StatusError.INSTRUCTION)]
    rig.ask(1, 0x04, le(65) + b"\x01")
    rig.ask(1, 0x08)
    rig.wait(BOOT_TIME)
    assert rig.ask(1, 0x05) == [(1, StatusError.INSTRUCTION)]  # a reboot forgets it


def test_a_broadcast_action_acts_on_all_and_is_not_answered(bench: MakeBench) -> None:
    rig = bench("xm430-w350:1", "xm430-w350:2")
    for servo_id in (1, 2):
        rig.ask(servo_id, 0x04, le(65) + b"\x01")
    assert rig.ask(254, 0x05) == []
    assert [rig.read(65, servo_id=i) for i in (1, 2)] == [1, 1]


def test_a_broadcast_write_acts_on_all_and_a_broadcast_read_on_none(bench: MakeBench) -> None:
    rig = bench("xm430-w350:1", "xl430-w250:2")
    assert rig.ask(254, 0x03, le(65) + b"\x01") == []
    assert [rig.read(65, servo_id=i) for i in (1, 2)] == [1, 1]
    assert rig.ask(254, 0x02, le(65, 1)) == []


def test_sync_read_answers_in_the_requested_order(bench: MakeBench) -> None:
    rig = bench("xm430-w350:1", "xm430-w350:2", "xm540-w270:3")
    answers = rig.ask(254, 0x82, le(PRESENT_POSITION, 4) + bytes((3, 1, 2)))
    assert answers == [(i, 0, 0, 8, 0, 0) for i in (3, 1, 2)]


def test_servos_after_a_missing_one_stay_silent_in_a_sync_read(bench: MakeBench) -> None:
    rig = bench("xm430-w350:1", "xm430-w350:3")
    answers = rig.ask(254, 0x82, le(PRESENT_POSITION, 4) + bytes((1, 2, 3)))
    assert [answer[0] for answer in answers] == [1]


def test_sync_write_reaches_each_servo_and_is_not_answered(bench: MakeBench) -> None:
    rig = bench("xm430-w350:1", "xm430-w350:2")
    shares = bytes((1, 0x10, 4, 0, 0, 2, 0x20, 4, 0, 0))
    assert rig.ask(254, 0x83, le(GOAL_POSITION, 4) + shares) == []
    assert [rig.read(GOAL_POSITION, 4, i) for i in (1, 2)] == [0x0410, 0x0420]


def test_sync_write_with_a_short_last_share_leaves_it_out(bench: MakeBench) -> None:
    rig = bench("xm430-w350:1", "xm430-w350:2")
    gains = le(80, 4)  # two registers of two bytes, of which the last share has but one
    rig.ask(254, 0x83, gains + bytes((1, 0x10, 0, 0x20, 0, 2, 0x30, 0)))
    assert [rig.read(address, 2, i) for i in (1, 2) for address in (80, 82)] == [0x10, 0x20, 0, 0]


@pytest.mark.parametrize(("level", "answered"), [(0, [1]), (1, [1, 2]), (2, [1, 2, 3])])
def test_status_return_level_decides_what_is_answered(
    bench: MakeBench, level: int, answered: list[int]
) -> None:
    rig = bench()
    assert rig.write(68, level) == 0  # this one is answered as the old level says
    found = [
        instruction
        for instruction, params in ((1, b""), (2, le(132, 4)), (3, le(65) + b"\x01"))
        if rig.ask(1, instruction, params)
    ]
    assert found == answered
    assert bool(rig.ask(254, 0x82, le(132, 4) + b"\x01")) == (level >= 1)


def test_a_damaged_packet_is_answered_with_a_crc_error_and_does_nothing(bench: MakeBench) -> None:
    rig = bench()
    frame = bytearray.fromhex("FF FF FD 00 01 06 00 03 41 00 01")
    answer = rig.port.exchange(bytes(frame) + b"\x00\x00")
    assert answer[4:9] == bytes((1, 4, 0, 0x55, StatusError.CRC))
    assert rig.read(65) == 0


def test_a_reboot_clears_ram_keeps_eeprom_and_takes_a_while(bench: MakeBench) -> None:
    rig = bench()
    rig.write(9, 10)
    rig.write(65, 1)
    rig.write(64, 1)
    assert rig.ask(1, 0x08) == [(1, 0)]
    assert rig.ask(1, 0x01) == []
    rig.wait(BOOT_TIME)
    assert [rig.read(address) for address in (9, 64, 65)] == [10, 0, 0]


def test_realtime_tick_counts_milliseconds_from_boot_and_wraps(bench: MakeBench) -> None:
    rig = bench()
    rig.clock.advance_to(20.0)
    assert rig.read(120, 2, signed=False) == 20_000
    rig.clock.advance_to(32.768 + 0.005)
    assert rig.read(120, 2, signed=False) == 5
    rig.ask(1, 0x08)
    rig.wait(0.25)
    assert rig.read(120, 2, signed=False) in (250, 251)


@pytest.mark.parametrize(("option", "expected"), [(0xFF, (1, 1)), (0x01, (7, 1)), (0x02, (7, 3))])
def test_factory_reset_keeps_what_its_option_says(
    bench: MakeBench, option: int, expected: tuple[int, int]
) -> None:
    rig = bench("xm430-w350:7")
    rig.write(31, 50, servo_id=7)
    assert rig.ask(7, 0x06, bytes((option,))) == [(7, 0)]
    rig.wait(BOOT_TIME)
    servo = rig.servos[0]
    assert (servo.memory.value("ID"), servo.memory.value("Baud Rate")) == expected
    rig.port.baud_rate = servo.baud_rate
    servo_id = expected[0]
    assert rig.read(31, servo_id=servo_id) == 80
    assert rig.read(9, servo_id=servo_id) == 250


def test_factory_reset_refuses_other_options_and_ignores_a_broadcast_of_all(
    bench: MakeBench,
) -> None:
    rig = bench("xm430-w350:7")
    assert rig.ask(7, 0x06, b"\x03") == [(7, StatusError.DATA_RANGE)]
    assert rig.ask(7, 0x06) == [(7, StatusError.DATA_LENGTH)]
    assert rig.ask(254, 0x06, b"\xff") == []
    assert rig.ask(7, 0x01)[0][0] == 7


def test_older_firmware_obeys_a_reset_of_all_to_all() -> None:
    """e-Manual, Protocol 2.0, Factory Reset: newer firmware, from 42, does not."""
    wire = Wire(servo("xm430-w350:7", firmware=41), servo("xm430-w350:8", firmware=42))
    assert wire.ask(254, 0x06, b"\xff") == []
    assert [one.servo_id for one in wire.servos] == [1, 8]
    assert wire.ask(254, 0x06, b"\x01") == []
    assert [one.return_delay for one in wire.servos] == [500e-6, 500e-6]


def test_clear_brings_the_position_back_into_one_turn_once_it_rests() -> None:
    wire = Wire(servo("xm430-w350:1", registers={"Operating Mode": 4}))
    assert wire.ask(1, 0x03, le(64) + b"\x01") == [(1, 0)]
    assert wire.ask(1, 0x03, le(GOAL_POSITION) + le(6000, size=4)) == [(1, 0)]
    wire.wait(0.1)
    assert wire.ask(1, 0x10, CLEAR) == [(1, StatusError.RESULT_FAIL)]
    wire.wait(10.0)
    assert wire.peek(PRESENT_POSITION, 4) == pytest.approx(6000, abs=5)
    assert wire.ask(254, 0x10, CLEAR) == []
    assert wire.peek(PRESENT_POSITION, 4) == pytest.approx(6000 - 4096, abs=5)


def test_clear_wants_its_word() -> None:
    wire = Wire("xm430-w350:1")
    assert wire.ask(1, 0x10, CLEAR) == [(1, 0)]
    assert wire.ask(1, 0x10, b"\x02" + CLEAR[1:]) == [(1, StatusError.DATA_RANGE)]
    assert wire.ask(1, 0x10, CLEAR[:4]) == [(1, StatusError.DATA_LENGTH)]


@pytest.mark.parametrize("old", [servo("xm430-w350:1", firmware=41), servo("xl-320:1")])
def test_clear_and_backup_are_unknown_to_older_firmware(old: ServoSettings) -> None:
    wire = Wire(old)
    for instruction, params in ((0x10, CLEAR), (0x20, b"\x01CTRL")):
        assert wire.ask(1, instruction, params) == [(1, StatusError.INSTRUCTION)]


def test_a_backup_is_restored_and_the_servo_boots() -> None:
    wire = Wire("xm430-w350:1")
    assert wire.ask(1, 0x20, b"\x01CTRL") == [(1, 0)]
    assert wire.ask(1, 0x03, le(31) + b"\x32") == [(1, 0)]
    assert wire.ask(1, 0x03, le(64) + b"\x01") == [(1, 0)]
    assert wire.ask(1, 0x20, b"\x02CTRL") == [(1, StatusError.RESULT_FAIL)]
    assert wire.ask(1, 0x03, le(64) + b"\x00") == [(1, 0)]
    assert wire.ask(1, 0x20, b"\x02CTRL") == [(1, 0)]
    assert wire.ask(1, 0x01) == []
    wire.wait(BOOT_TIME)
    assert wire.peek(31) == 80


@pytest.mark.parametrize(
    ("params", "error"),
    [
        (b"\x03CTRL", StatusError.DATA_RANGE),
        (b"\x01CTRM", StatusError.DATA_RANGE),
        (b"\x01CTR", StatusError.DATA_LENGTH),
        (b"", StatusError.DATA_LENGTH),
    ],
)
def test_backup_wants_its_word(params: bytes, error: StatusError) -> None:
    assert Wire("xm430-w350:1").ask(1, 0x20, params) == [(1, error)]


def test_a_new_id_counts_from_the_next_packet_on(bench: MakeBench) -> None:
    rig = bench()
    assert rig.write(7, 42) == 0
    assert rig.ask(1, 0x01) == []
    assert rig.ask(42, 0x01)[0][0] == 42


def test_a_new_baud_rate_counts_from_the_next_packet_on(bench: MakeBench) -> None:
    rig = bench()
    assert rig.write(8, 4) == 0
    rig.port.baud_rate = 2_000_000
    assert rig.ask(1, 0x01)[0][0] == 1


def test_the_alert_bit_is_set_while_there_is_a_hardware_error(bench: MakeBench) -> None:
    rig = bench()
    rig.write(64, 1)
    rig.servos[0].raise_hardware_error(HardwareError.OVERLOAD)
    assert rig.ask(1, 0x01)[0][1] == 0x80
    assert rig.write(65, 1) == 0x80
    assert (rig.read(70), rig.read(64)) == (0x20, 0)
    assert rig.write(64, 1) == 0x80 | StatusError.RESULT_FAIL
    rig.ask(1, 0x08)
    rig.wait(BOOT_TIME)
    assert rig.write(64, 1) == 0
    assert rig.read(70) == 0


def test_an_error_that_shutdown_does_not_name_leaves_the_torque_on(bench: MakeBench) -> None:
    rig = bench()
    rig.write(64, 1)
    rig.servos[0].raise_hardware_error(HardwareError.MOTOR_ENCODER)
    assert (rig.read(70), rig.read(64)) == (0x08, 1)
