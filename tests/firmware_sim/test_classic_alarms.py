"""Errors, shutdown and what ends it, for AX, MX and XL-320."""

import pytest

from firmware_sim.classic.alarms import BLINKING_AFTER
from firmware_sim.classic.firmware import ClassicFirmware
from firmware_sim.firmware.codes import ALERT, HardwareError, StatusError
from tests.firmware_sim.classic_bench import ClassicBench

OVERLOAD_TIME = 0.5
VOLTAGE, ANGLE_LIMIT, OVERHEATING, RANGE, OVERLOAD = 0x01, 0x02, 0x04, 0x08, 0x20


def overloaded(name: str = "ax-12a", **registers: int) -> ClassicBench:
    """Return a servo that has pushed against something hard for long."""
    servo = ClassicBench(name, **registers)
    servo.axis.jam(True)
    servo.set(Torque_Enable=1, Goal_Position=servo.read("CCW Angle Limit"))
    servo.run(OVERLOAD_TIME - 0.05)
    assert servo.servo.error_bits == 0
    assert servo.read("Present Load") == 1023
    servo.run(0.1)
    return servo


@pytest.mark.parametrize("name", ["ax-12a", "mx-28"])
def test_an_overload_takes_the_torque_limit_away(name: str) -> None:
    servo = overloaded(name)
    assert servo.servo.error_bits == OVERLOAD
    assert servo.read("Torque Limit") == 0
    assert servo.read("Torque Enable") == 1
    servo.run(0.1)
    assert servo.read("Present Load") == 0
    assert servo.axis.current == 0.0


def test_a_torque_limit_ends_an_overload_once_nothing_blocks() -> None:
    servo = overloaded()
    servo.axis.jam(False)
    servo.run(5.0)
    assert servo.servo.error_bits == OVERLOAD  # waiting is not enough
    assert servo.read("Present Position") == 512
    servo.set(Torque_Limit=1023)
    assert servo.servo.error_bits == 0
    servo.run(2.0)
    assert servo.servo.error_bits == 0
    assert servo.read("Present Position") == pytest.approx(1023, abs=3)


def test_a_torque_limit_does_not_end_an_overload_that_goes_on() -> None:
    servo = overloaded()
    servo.set(Torque_Limit=931)  # 91 %
    servo.run(OVERLOAD_TIME - 0.05)
    assert servo.read("Torque Limit") == 931
    servo.run(0.1)
    assert servo.read("Torque Limit") == 0
    assert servo.servo.error_bits == OVERLOAD


def test_what_a_low_torque_limit_pushes_with_is_no_overload() -> None:
    servo = overloaded()
    servo.set(Torque_Limit=910)  # 89 %
    servo.run(5.0)
    assert (servo.read("Torque Limit"), servo.servo.error_bits) == (910, 0)


def test_a_power_cycle_ends_an_overload() -> None:
    servo = overloaded()
    servo.servo.power_cycle(off_for=0.1)
    servo.run(1.0)
    assert servo.servo.error_bits == 0
    assert servo.read("Torque Limit") == 1023
    assert servo.read("Torque Enable") == 0


def test_an_overload_outside_the_mask_only_shows_while_it_lasts() -> None:
    servo = overloaded(Shutdown=OVERHEATING)
    assert servo.servo.error_bits == OVERLOAD
    assert servo.read("Torque Limit") == 1023
    servo.axis.jam(False)
    servo.run(2.0)
    assert servo.servo.error_bits == 0
    assert servo.read("Present Position") == pytest.approx(1023, abs=3)


def test_a_weak_load_is_no_overload() -> None:
    servo = ClassicBench("ax-12a")
    servo.set(Goal_Position=512)
    servo.servo.apply_load(0.3)
    servo.run(20.0)
    assert servo.servo.error_bits == 0
    assert servo.read("Torque Limit") == 1023


def test_heat_keeps_the_torque_away() -> None:
    servo = ClassicBench("ax-12a", Temperature_Limit=20)  # the air has 25
    servo.run(0.1)
    assert servo.servo.error_bits == OVERHEATING
    assert servo.read("Torque Limit") == 0
    servo.set(Torque_Limit=1023)
    servo.run(0.1)
    assert servo.read("Torque Limit") == 0
    servo.set(Temperature_Limit=70)
    servo.run(0.1)
    assert servo.servo.error_bits == OVERHEATING  # why it has let go
    servo.set(Torque_Limit=1023, Goal_Position=600)
    servo.run(1.0)
    assert servo.servo.error_bits == 0
    assert servo.read("Present Position") == pytest.approx(600, abs=3)


def test_a_stalled_motor_gets_hot_and_lets_go() -> None:
    servo = ClassicBench("ax-12a", Shutdown=OVERHEATING)
    servo.axis.jam(True)
    servo.set(Goal_Position=1023)
    # 12 V and 1.5 A are 18 W. Its 54.6 g make 10.49 K/W and 209.6 s of an XM430's 8 K/W and 240 s:
    # 25 degrees become 70 in 209.6 ln(188.8 / (188.8 - 45)) = 57 s.
    servo.run(54.0)
    assert servo.servo.error_bits == OVERLOAD  # not in the mask: it pushes on
    assert servo.read("Torque Limit") == 1023
    servo.run(8.0)
    assert servo.servo.error_bits == OVERHEATING
    assert servo.read("Torque Limit") == 0
    assert 66 <= servo.read("Present Temperature") <= 70
    servo.run(1000.0)
    assert servo.read("Present Temperature") <= 27
    assert servo.read("Torque Limit") == 0


@pytest.mark.parametrize(
    ("voltage", "bits"), [(5.5, VOLTAGE), (6.0, 0), (14.0, 0), (14.6, VOLTAGE)]
)
def test_voltages_outside_the_limits_are_reported(voltage: float, bits: int) -> None:
    servo = ClassicBench("ax-12a", voltage=voltage)
    servo.run(0.1)
    assert servo.servo.error_bits == bits
    assert servo.read("Present Voltage") == round(voltage * 10)
    assert servo.read("Torque Limit") == 1023  # the mask, 36, has not this bit


def test_a_voltage_in_the_mask_shuts_down() -> None:
    servo = ClassicBench("ax-12a", voltage=14.6, Shutdown=VOLTAGE)
    servo.run(0.1)
    assert servo.read("Torque Limit") == 0


def test_a_wrong_goal_shuts_down_if_the_mask_says_so() -> None:
    servo = ClassicBench("ax-12a", CCW_Angle_Limit=600, Shutdown=ANGLE_LIMIT)
    servo.set(Goal_Position=550)
    servo.run(0.5)
    assert servo.write("Goal Position", 700) == StatusError.DATA_LIMIT
    assert servo.read("Torque Limit") == 0
    assert servo.read("Goal Position") == 550
    assert servo.servo.error_bits == 0  # it speaks of the instruction, in its own answer
    servo.set(Torque_Limit=1023)
    servo.run(0.5)
    assert servo.read("Torque Limit") == 1023


def test_by_default_a_wrong_goal_costs_nothing() -> None:
    servo = ClassicBench("ax-12a", CCW_Angle_Limit=600)
    assert servo.write("Goal Position", 700) == StatusError.DATA_LIMIT
    assert servo.read("Torque Limit") == 1023
    assert servo.read("Torque Enable") == 0


def test_an_overload_of_an_xl_320_is_in_hardware_error_status() -> None:
    servo = overloaded("xl-320")
    assert servo.read("Hardware Error Status") == 0x01
    assert servo.servo.alert == ALERT
    assert (servo.read("Torque Limit"), servo.read("Torque Enable")) == (0, 0)
    servo.axis.jam(False)
    servo.set(Torque_Limit=1023, Torque_Enable=1, Goal_Position=700)
    servo.run(3.0)
    assert servo.read("Hardware Error Status") == 0
    assert servo.servo.alert == 0
    assert servo.read("Present Position") > 650


def test_other_errors_of_an_xl_320_have_their_own_bits() -> None:
    hot = ClassicBench("xl-320", Temperature_Limit=20)
    hot.run(0.1)
    assert hot.read("Hardware Error Status") == 0x02
    assert hot.read("Torque Limit") == 0
    high = ClassicBench("xl-320", voltage=9.5)
    high.run(0.1)
    assert high.read("Hardware Error Status") == 0x04
    assert high.read("Torque Limit") == 1023  # the mask, 3, has not this bit


@pytest.mark.parametrize("name", ["ax-12a", "xl-320"])
def test_an_error_can_be_brought_about(name: str) -> None:
    servo = ClassicBench(name)
    servo.set(Goal_Position=700)
    servo.servo.raise_hardware_error(HardwareError.OVERLOAD)
    assert servo.servo.error_bits == OVERLOAD
    assert servo.read("Torque Limit") == 0
    servo.set(Torque_Limit=1023)
    assert servo.servo.error_bits == 0


def test_errors_that_it_cannot_detect_change_nothing() -> None:
    servo = ClassicBench("ax-12a")
    servo.servo.raise_hardware_error(HardwareError.MOTOR_ENCODER)
    assert servo.servo.error_bits == 0
    assert servo.read("Torque Limit") == 1023


def led(servo: ClassicBench) -> int:
    firmware = servo.servo.firmware
    assert isinstance(firmware, ClassicFirmware)
    return firmware.led


def test_the_led_blinks_by_the_second_for_an_alarm_of_its_mask() -> None:
    servo = ClassicBench("ax-12a", Alarm_LED=OVERHEATING, Shutdown=0, Temperature_Limit=20)
    seen = []
    for _ in range(40):
        servo.run(0.1)
        seen.append(led(servo))
    assert seen[10:20] == seen[20:30]
    assert sum(seen[10:20]) == 5
    servo.set(Temperature_Limit=70, LED=1)
    after = []
    for _ in range(10):
        after.append(led(servo))
        servo.run(0.1)
    assert sum(after) == 5  # it goes on
    servo.run(BLINKING_AFTER - 0.9)
    assert {led(servo), servo.read("LED")} == {1}
    servo.run(0.5)
    assert led(servo) == 1
    servo.set(LED=0)
    assert led(servo) == 0


def test_the_led_does_not_blink_for_what_is_not_in_its_mask() -> None:
    servo = ClassicBench("ax-12a", Alarm_LED=OVERLOAD, Shutdown=0, Temperature_Limit=20)
    for _ in range(15):
        servo.run(0.1)
        assert led(servo) == 0
    assert servo.servo.error_bits == OVERHEATING


def test_the_led_of_an_xl_320_has_colours() -> None:
    servo = ClassicBench("xl-320")
    servo.set(LED=6)
    assert led(servo) == 6
