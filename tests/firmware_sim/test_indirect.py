"""Indirect addresses: one request for registers that lie apart."""

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings

from firmware_sim.firmware.codes import StatusError

from .solo import Solo, raw

ADDRESS, DATA = 168, 224  # of the first pair, XM430
LED, PROFILE, GOAL, VELOCITY, POSITION = 65, 108, 116, 128, 132


def aim(solo: Solo, *targets: int, first: int = 1) -> None:
    """Let Indirect Data from number `first` on be the bytes at these addresses."""
    for number, target in enumerate(targets, first):
        assert solo.write(f"Indirect Address {number}", target) == StatusError.NONE


def test_the_manuals_first_example() -> None:
    solo = Solo()
    aim(solo, LED)
    assert solo.write("Indirect Data 1", 1) == StatusError.NONE
    assert solo.read("LED") == solo.read("Indirect Data 1") == 1
    assert solo.write("Indirect Data 1", 0) == StatusError.NONE
    assert solo.read("LED") == 0


def test_the_manuals_second_example() -> None:
    solo = Solo()
    aim(solo, 116, 117, 118, 119, first=2)
    assert solo.servo.write(DATA + 1, raw(1024, 4)) == StatusError.NONE
    assert solo.read("Goal Position") == 1024
    solo.set(Torque_Enable=1)
    solo.wait(3.0)
    assert solo.read("Present Position") == pytest.approx(1024, abs=2)


def test_from_the_factory_the_data_are_plain_memory() -> None:
    solo = Solo()
    data = bytes(range(28))
    assert solo.servo.write(DATA, data) == StatusError.NONE
    assert solo.servo.read(DATA, 28) == (StatusError.NONE, data)


def test_measured_values_are_measured() -> None:
    solo = Solo()
    aim(solo, *range(VELOCITY, VELOCITY + 8))
    solo.set(Torque_Enable=1, Goal_Position=3500)
    solo.wait(0.1)
    error, data = solo.servo.read(DATA, 8)
    assert error == StatusError.NONE
    assert int.from_bytes(data[:4], "little", signed=True) > 50
    assert data == solo.servo.read(VELOCITY, 8)[1]


def test_the_checks_are_those_of_the_target() -> None:
    solo = Solo()
    aim(solo, *range(GOAL, GOAL + 4), *range(POSITION, POSITION + 4), LED, 300)
    assert solo.servo.write(DATA, raw(5000, 4)) == StatusError.DATA_LIMIT
    assert solo.servo.write(DATA + 4, raw(0, 4)) == StatusError.ACCESS
    assert solo.servo.write(DATA + 8, b"\x02") == StatusError.DATA_RANGE
    assert solo.servo.write(DATA + 9, b"\x00") == StatusError.ACCESS  # nothing is there
    assert solo.servo.read(DATA + 9, 1) == (StatusError.NONE, b"\x00")


def test_only_ram_can_be_aimed_at() -> None:
    solo = Solo()
    for target in (0, 7, 63, 662):
        assert solo.write("Indirect Address 1", target) == StatusError.DATA_RANGE
    for target in (64, 661):
        assert solo.write("Indirect Address 1", target) == StatusError.NONE


def test_part_of_a_target_is_a_length_error() -> None:
    solo = Solo()
    aim(solo, GOAL, GOAL + 1)
    assert solo.servo.write(DATA, b"\x00\x01") == StatusError.DATA_LENGTH
    assert solo.read("Goal Position") == 2048


def test_bytes_in_any_order() -> None:
    solo = Solo()
    aim(solo, GOAL + 3, GOAL + 2, GOAL + 1, GOAL)
    assert solo.servo.write(DATA, raw(1234, 4)[::-1]) == StatusError.NONE
    assert solo.read("Goal Position") == 1234


def test_a_refused_part_refuses_all() -> None:
    solo = Solo()
    aim(solo, LED, *range(GOAL, GOAL + 4))
    assert solo.servo.write(DATA, b"\x01" + raw(5000, 4)) == StatusError.DATA_LIMIT
    assert (solo.read("LED"), solo.read("Goal Position")) == (0, 2048)


def test_a_range_may_mix_them_with_ordinary_registers() -> None:
    """Indirect Address 28 is followed by Indirect Data 1: plain, aimed and plain again."""
    solo = Solo()
    aim(solo, LED, first=2)
    request = raw(250, 2) + b"\x07\x01\x09"  # addresses 222 to 226
    assert solo.servo.write(222, request) == StatusError.NONE
    assert solo.read("LED") == 1
    assert solo.servo.read(222, 5) == (StatusError.NONE, request)
    names = ("Indirect Address 28", "Indirect Data 1", "Indirect Data 3")
    assert [solo.read(name) for name in names] == [250, 7, 9]


def test_a_new_aim_counts_at_once() -> None:
    solo = Solo()
    aim(solo, LED)
    solo.set(Indirect_Data_1=1)
    aim(solo, 146)
    assert solo.read("Indirect Data 1") == 25  # degrees Celsius
    assert solo.write("Indirect Data 1", 0) == StatusError.ACCESS


def test_a_reboot_forgets_the_aims() -> None:
    solo = Solo()
    aim(solo, 146)
    assert solo.read("Indirect Data 1") == 25
    solo.servo.reboot()
    solo.wait(0.2)
    assert solo.read("Indirect Address 1") == DATA
    assert solo.read("Indirect Data 1") == 0


def test_profile_before_goal_however_they_are_gathered() -> None:
    solo = Solo()
    aim(solo, *range(GOAL, GOAL + 4), *range(PROFILE, PROFILE + 8))
    solo.set(Torque_Enable=1)
    assert solo.servo.write(DATA, raw(3000, 4) + raw(5, 4) + raw(40, 4)) == StatusError.NONE
    assert solo.read("Moving Status") & 0x32 == 0x32  # a trapezoid, under way


@pytest.mark.parametrize(("firmware", "data_at"), [(52, 208), (53, 224)])
def test_the_330_series_moves_them_with_its_firmware(firmware: int, data_at: int) -> None:
    solo = Solo("xl330-m288", firmware=firmware)
    aim(solo, LED)
    assert solo.servo.write(data_at, b"\x01") == StatusError.NONE
    assert solo.read("LED") == 1


@given(st.lists(st.integers(64, 661), min_size=1, max_size=28))
@settings(max_examples=100, deadline=None)
def test_any_aims_read_what_is_there(targets: list[int]) -> None:
    solo = Solo()
    aim(solo, *targets)
    error, data = solo.servo.read(DATA, len(targets))
    assert error == StatusError.NONE
    solo.servo.read(64, 662 - 64)  # measures everything
    assert list(data) == [solo.servo.memory.data[target] for target in targets]
