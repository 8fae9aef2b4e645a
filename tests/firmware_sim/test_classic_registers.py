"""Registers of AX, MX and XL-320: what is refused, what is locked, what lasts."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_sim.classic.firmware import ClassicFirmware
from firmware_sim.firmware.codes import StatusError
from tests.firmware_sim.classic_bench import ClassicBench

OK, RANGE, LIMIT, ACCESS, LENGTH = (
    StatusError.NONE,
    StatusError.DATA_RANGE,
    StatusError.DATA_LIMIT,
    StatusError.ACCESS,
    StatusError.DATA_LENGTH,
)


MODELS = ("ax-12a", "ax-18a", "mx-28", "mx-64", "mx-106", "xl-320")


@pytest.mark.parametrize(
    ("name", "register", "value", "error"),
    [
        ("ax-12a", "Goal Position", 1024, RANGE),
        ("ax-12a", "Moving Speed", 2048, RANGE),
        ("ax-12a", "Punch", 31, RANGE),  # "from 0x20 to 0x3FF"
        ("ax-12a", "Torque Limit", 1024, RANGE),
        ("ax-12a", "Baud Rate", 0, RANGE),
        ("ax-12a", "ID", 254, RANGE),
        ("ax-12a", "ID", 253, OK),
        ("ax-12a", "Present Position", 1, RANGE),
        ("mx-28", "P Gain", 255, RANGE),
        ("mx-28", "Resolution Divider", 5, RANGE),
        ("mx-28", "Baud Rate", 252, OK),
        ("mx-106", "Drive Mode", 2, RANGE),
        ("xl-320", "ID", 253, RANGE),
        ("xl-320", "LED", 7, OK),
        ("xl-320", "LED", 8, RANGE),
        ("xl-320", "Present Position", 1, ACCESS),
        ("xl-320", "Control Mode", 3, RANGE),
    ],
)
def test_values_outside_the_manuals_ranges_are_refused(
    name: str, register: str, value: int, error: StatusError
) -> None:
    servo = ClassicBench(name)
    before = servo.read(register)
    assert servo.write(register, value) == error
    assert servo.read(register) == (before if error else value)


@pytest.mark.parametrize(("goal", "error"), [(299, LIMIT), (300, OK), (700, OK), (701, LIMIT)])
@pytest.mark.parametrize("name", ["ax-12a", "mx-28", "xl-320"])
def test_goals_end_at_the_angle_limits(name: str, goal: int, error: StatusError) -> None:
    servo = ClassicBench(name, 500, CW_Angle_Limit=300, CCW_Angle_Limit=700)
    assert servo.write("Goal Position", goal) == error


def test_one_byte_of_a_register_can_be_written_with_protocol_1() -> None:
    servo = ClassicBench("ax-12a")
    servo.set(Moving_Speed=0x123)
    assert servo.servo.write(33, b"\x02") == OK
    assert servo.read("Moving Speed") == 0x223
    assert servo.servo.write(32, b"\x45") == OK
    assert servo.read("Moving Speed") == 0x245


def test_one_byte_of_a_register_cannot_be_written_with_protocol_2() -> None:
    servo = ClassicBench("xl-320")
    assert servo.servo.write(33, b"\x02") == LENGTH


def test_several_registers_are_written_at_once_or_not_at_all() -> None:
    servo = ClassicBench("ax-12a")
    assert servo.servo.write(30, bytes((0x00, 0x03, 0x40, 0x00))) == OK  # as in a sync write
    assert (servo.read("Goal Position"), servo.read("Moving Speed")) == (0x300, 0x40)
    assert servo.servo.write(30, bytes((0x10, 0x00, 0x00, 0x08))) == RANGE
    assert (servo.read("Goal Position"), servo.read("Moving Speed")) == (0x300, 0x40)


def test_writes_behind_the_table_are_refused() -> None:
    servo = ClassicBench("ax-12a")
    assert servo.servo.write(49, b"\x00\x00") == RANGE
    assert servo.servo.write(200, b"\x00") == RANGE
    assert servo.servo.write(30, b"") == RANGE


def test_lock_keeps_the_eeprom_until_the_power_goes() -> None:
    servo = ClassicBench("ax-12a")
    servo.set(Temperature_Limit=69, Lock=1)
    assert servo.write("Temperature Limit", 65) == RANGE
    assert servo.write("Lock", 0) == RANGE
    servo.set(Moving_Speed=50, LED=1)  # RAM is free
    assert (servo.read("Temperature Limit"), servo.read("Lock")) == (69, 1)
    servo.servo.power_cycle(off_for=0.2)
    servo.run(1.0)
    assert servo.read("Lock") == 0
    servo.set(Temperature_Limit=65)
    assert servo.read("LED") == 0


@pytest.mark.parametrize(("name", "error"), [("ax-12a", OK), ("mx-28", OK), ("xl-320", ACCESS)])
def test_torque_locks_the_eeprom_of_an_xl_320_only(name: str, error: StatusError) -> None:
    servo = ClassicBench(name)
    servo.set(Torque_Enable=1)
    assert servo.write("Temperature Limit", 60) == error
    servo.set(Torque_Enable=0)
    assert servo.write("Temperature Limit", 60) == OK


@pytest.mark.parametrize("name", MODELS)
def test_torque_limit_is_max_torque_at_power_up(name: str) -> None:
    servo = ClassicBench(name)
    assert servo.read("Torque Limit") == servo.model.table["Max Torque"].default
    servo.set(Max_Torque=400)
    assert servo.read("Torque Limit") == servo.model.table["Max Torque"].default
    servo.servo.power_cycle(off_for=0.1)
    servo.run(1.0)
    assert servo.read("Torque Limit") == 400


def test_a_new_id_and_rate_count_at_once() -> None:
    servo = ClassicBench("ax-12a")
    assert (servo.servo.servo_id, servo.servo.baud_rate) == (1, 1_000_000)
    assert servo.servo.return_delay == pytest.approx(500e-6)
    servo.set(ID=200, Baud_Rate=34, Return_Delay_Time=10)
    assert (servo.servo.servo_id, servo.servo.baud_rate) == (200, 57_143)
    assert servo.servo.return_delay == pytest.approx(20e-6)
    assert servo.servo.protocol == 1


def test_a_factory_reset_brings_the_initial_values_back() -> None:
    servo = ClassicBench("mx-28")
    servo.set(ID=7, Baud_Rate=1, P_Gain=64, CCW_Angle_Limit=3000)
    servo.servo.factory_reset(keep_id=False, keep_baud_rate=False)
    servo.run(1.0)
    for name in ("ID", "Baud Rate", "P Gain", "CCW Angle Limit"):
        assert servo.read(name) == servo.model.table[name].default


def test_an_ax_is_deaf_while_it_writes_its_eeprom() -> None:
    servo = ClassicBench("ax-12a")
    firmware = servo.servo.firmware
    assert isinstance(firmware, ClassicFirmware)
    servo.run(1.0)
    servo.set(Moving_Speed=10)
    assert firmware.deaf_until <= servo.now
    servo.set(Max_Torque=500)
    assert firmware.deaf_until - servo.now == pytest.approx(2 * 6.0e-3)
    servo.set(LED=1)
    assert firmware.deaf_until - servo.now == pytest.approx(2 * 6.0e-3)


@settings(max_examples=60, deadline=None)
@given(
    name=st.sampled_from(MODELS),
    writes=st.lists(
        st.tuples(st.integers(0, 80), st.binary(min_size=0, max_size=12), st.booleans()),
        max_size=25,
    ),
)
def test_no_write_brings_a_register_out_of_its_range(
    name: str, writes: list[tuple[int, bytes, bool]]
) -> None:
    servo = ClassicBench(name)
    for address, data, wait in writes:
        before = bytes(servo.servo.memory.data)
        if servo.servo.write(address, data):
            kept = bytearray(servo.servo.memory.data)
            for lost in ("Torque Limit", "Torque Enable", "Hardware Error Status"):
                if lost in servo.model.table.by_name:  # an alarm that the mask may have
                    register = servo.model.table[lost]
                    kept[register.address : register.end] = before[register.address : register.end]
            assert bytes(kept) == before
        if wait:
            servo.run(0.05)
    for register in servo.model.table.registers:
        assert register.minimum <= servo.read(register.name) <= register.maximum, register.name


def test_registered_writes_wait_for_the_action() -> None:
    servo = ClassicBench("ax-12a")
    assert servo.servo.register_write(30, bytes((0xF4, 0x01))) == OK
    assert (servo.read("Registered Instruction"), servo.read("Torque Enable")) == (1, 0)
    assert servo.servo.act() == OK
    assert (servo.read("Registered Instruction"), servo.read("Goal Position")) == (0, 500)
    assert servo.servo.act() == StatusError.INSTRUCTION


def test_realtime_tick_counts_milliseconds_and_wraps() -> None:
    servo = ClassicBench("mx-28")
    servo.run(1.5)
    assert servo.read("Realtime Tick") == 1500
    servo.run(32.0)
    assert servo.read("Realtime Tick") == 33_500 - 32_768
    servo.servo.reboot()
    servo.run(0.25)
    assert servo.read("Realtime Tick") == 250


def test_realtime_tick_is_not_in_older_firmware() -> None:
    servo = ClassicBench("mx-28", firmware=36)
    assert servo.read("Firmware Version") == 36
    assert "Realtime Tick" not in servo.model.table.by_name
    servo.set(Goal_Acceleration=20)


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("ax-12a", 12),
        ("ax-18a", 18),
        ("mx-28", 29),
        ("mx-64", 310),
        ("mx-106", 320),
        ("xl-320", 350),
    ],
)
def test_model_numbers_are_read(name: str, number: int) -> None:
    assert ClassicBench(name).read("Model Number") == number


@pytest.mark.parametrize(("name", "error"), [("ax-12a", OK), ("mx-28", OK), ("xl-320", ACCESS)])
def test_a_read_may_begin_between_registers(name: str, error: StatusError) -> None:
    """10 is none of theirs; protocol 1.0 has no access error."""
    servo = ClassicBench(name)
    found, data = servo.servo.read(10, 2)
    assert found == error
    assert len(data) == (2 if error == OK else 0)
    assert error != OK or data[0] == 0
