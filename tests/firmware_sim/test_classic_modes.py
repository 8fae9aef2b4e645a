"""Wheel, multi-turn and torque control mode, against the manual and hand calculation."""

import pytest

from firmware_sim.firmware.codes import StatusError
from tests.firmware_sim.classic_bench import ClassicBench

WHEEL = {"CW_Angle_Limit": 0, "CCW_Angle_Limit": 0}
MULTI_TURN = {"CW_Angle_Limit": 4095, "CCW_Angle_Limit": 4095}


@pytest.mark.parametrize(
    ("name", "settings", "rpm"),
    [("ax-12a", WHEEL, 59.0), ("ax-18a", WHEEL, 97.0), ("xl-320", {"Control_Mode": 1}, 114.0)],
)
@pytest.mark.parametrize("direction", [1, -1])
def test_wheels_of_ax_and_xl_320_turn_by_output(
    name: str, settings: dict[str, int], rpm: float, direction: int
) -> None:
    servo = ClassicBench(name, **settings)
    servo.set(Torque_Enable=1, Moving_Speed=512 + (1024 if direction < 0 else 0))
    servo.run(1.0)
    # Without load half the output gives half the speed, less what friction of 1 % takes.
    turned = servo.axis.velocity * 9.5493  # rev/min
    assert direction * turned == pytest.approx(0.5 * rpm, rel=0.03)
    assert direction * servo.read_signed("Present Speed") == pytest.approx(512, rel=0.03)
    assert servo.read_signed("Present Load") == direction * 512
    assert servo.read("Moving") == 1


def test_a_wheel_under_load_turns_slower_at_the_same_output() -> None:
    servo = ClassicBench("ax-12a", **WHEEL)
    servo.set(Torque_Enable=1, Moving_Speed=1023)
    servo.run(0.5)
    free = servo.read("Present Speed")
    servo.servo.apply_load(0.5 * 1.5)
    servo.run(0.5)
    # Speed falls linearly to 0 at the stall torque; back-EMF makes the slope 1 over 0.94.
    assert servo.read("Present Speed") / free == pytest.approx(0.5, abs=0.04)
    assert servo.read("Present Load") == 1023


@pytest.mark.parametrize("stopped", [0, 1024])
def test_a_wheel_stops_at_zero_of_either_direction(stopped: int) -> None:
    servo = ClassicBench("ax-12a", **WHEEL)
    servo.set(Torque_Enable=1, Moving_Speed=600)
    servo.run(0.5)
    servo.set(Moving_Speed=stopped)
    servo.run(0.5)
    assert servo.read("Present Speed") == 0
    assert servo.read("Moving") == 0


def test_a_wheel_uses_no_goal_position() -> None:
    servo = ClassicBench("ax-12a", **WHEEL)
    servo.set(Goal_Position=900)
    assert servo.read("Torque Enable") == 0
    servo.run(1.0)
    assert servo.read("Present Position") == 512


def test_the_wheel_of_an_mx_controls_its_speed() -> None:
    # "Moving Speed (32)": 300 is about 34.2 rev/min; under a load, too.
    servo = ClassicBench("mx-28", **WHEEL)
    servo.set(Torque_Enable=1, Moving_Speed=300)
    servo.run(1.0)
    assert servo.axis.velocity * 9.5493 == pytest.approx(34.2, rel=0.01)
    assert servo.read("Present Speed") == pytest.approx(300, abs=3)
    servo.servo.apply_load(0.3)
    servo.run(2.0)
    assert servo.read("Present Speed") == pytest.approx(300, abs=3)
    servo.set(Moving_Speed=1024 + 100)
    servo.run(2.0)
    assert servo.read("Present Speed") == pytest.approx(1024 + 100, abs=3)


def test_the_wheel_of_an_mx_speeds_up_with_goal_acceleration() -> None:
    servo = ClassicBench("mx-28", **WHEEL)
    servo.set(Goal_Acceleration=10, Torque_Enable=1, Moving_Speed=400)
    servo.run(1.0)
    assert servo.read("Present Speed") * 0.114 == pytest.approx(14.3, rel=0.03)


def test_both_angle_limits_at_0_make_a_wheel_at_once() -> None:
    servo = ClassicBench("ax-12a")
    servo.set(Goal_Position=512, Moving_Speed=100)
    servo.run(0.2)
    servo.set(CCW_Angle_Limit=0)
    servo.run(1.0)
    assert servo.read("Present Speed") == pytest.approx(100, rel=0.2)
    servo.set(CCW_Angle_Limit=1023)
    held = servo.read("Goal Position")
    servo.run(1.0)
    assert servo.read("Present Position") == pytest.approx(held, abs=2)
    assert servo.read("Moving") == 0


def test_multi_turn_mode_turns_several_times() -> None:
    servo = ClassicBench("mx-28", 0, **MULTI_TURN)
    servo.set(Moving_Speed=400, Goal_Position=3 * 4096 + 100)
    servo.run(6.0)
    assert servo.read("Present Position") == pytest.approx(3 * 4096 + 100, abs=4)
    servo.set(Goal_Position=-4096)
    servo.run(8.0)
    assert servo.read("Present Position") == pytest.approx(-4096, abs=4)
    assert servo.axis.angle == pytest.approx(-6.2832, abs=0.01)


def test_multi_turn_counts_with_divider_and_offset() -> None:
    servo = ClassicBench(
        "mx-64", 1536, CW_Angle_Limit=4095, Resolution_Divider=4, Multi_Turn_Offset=1024
    )
    before = servo.axis.angle
    assert servo.read("Present Position") == 1536
    servo.set(Goal_Position=1536 + 1024)  # 1024 counts are one turn
    servo.run(2.0)
    assert servo.read("Present Position") == pytest.approx(2560, abs=2)
    assert servo.axis.angle - before == pytest.approx(6.2832, abs=0.01)


def test_multi_turn_mode_begins_in_the_turn_that_the_wheel_is_in() -> None:
    servo = ClassicBench("mx-28", **WHEEL)
    servo.set(Torque_Enable=1, Moving_Speed=300)
    servo.run(5.0)
    servo.set(Moving_Speed=0)
    servo.run(0.5)
    assert servo.axis.ticks > 2 * 4096
    servo.set(Torque_Enable=0, CW_Angle_Limit=4095, CCW_Angle_Limit=4095)
    assert servo.read("Present Position") == servo.axis.ticks % 4096


def test_turns_are_lost_without_power() -> None:
    servo = ClassicBench("mx-28", 0, **MULTI_TURN)
    servo.set(Goal_Position=2 * 4096 + 1000)
    servo.run(4.0)
    servo.servo.power_cycle(off_for=0.1)
    servo.run(1.0)
    assert servo.read("Present Position") == pytest.approx(1000, abs=30)


def test_outside_multi_turn_mode_a_goal_beyond_a_turn_is_refused() -> None:
    servo = ClassicBench("mx-28")
    assert servo.write("Goal Position", 4096) == StatusError.DATA_LIMIT
    assert servo.write("Goal Position", -1) == StatusError.DATA_LIMIT
    assert servo.write("Goal Position", 30_000) == StatusError.DATA_RANGE


def test_current_reads_as_in_the_manuals_example() -> None:
    # "Current (68)": 2048 without current; 2148 is 450 mA.
    servo = ClassicBench("mx-64")
    assert servo.read("Current") == 2048
    servo.set(Torque_Control_Mode_Enable=1, Torque_Enable=1, Goal_Torque=100)
    servo.axis.jam(True)
    servo.run(0.2)
    assert servo.axis.current == pytest.approx(0.45, abs=0.005)
    assert servo.read("Current") == pytest.approx(2148, abs=1)
    servo.set(Goal_Torque=1024 + 100)
    servo.run(0.2)
    assert servo.read("Current") == pytest.approx(1948, abs=1)


def test_torque_control_holds_a_load_of_its_torque_and_no_more() -> None:
    # 100 counts are 0.45 A: 0.45 / 4.1 of 6 N m, which is 0.659 N m.
    servo = ClassicBench("mx-64")
    servo.set(Torque_Control_Mode_Enable=1, Torque_Enable=1, Goal_Torque=100)
    servo.servo.apply_load(0.659)
    servo.run(0.5)
    assert servo.read_signed("Present Speed") == 0
    servo.servo.apply_load(1.2 * 0.659)
    servo.run(0.2)
    assert servo.axis.velocity < 0.0
    servo.servo.apply_load(0.8 * 0.659)
    servo.run(0.4)
    assert servo.axis.velocity > 0.0


def test_torque_limit_limits_goal_torque() -> None:
    # "Goal Torque cannot be bigger than Torque Limit".
    servo = ClassicBench("mx-106", Max_Torque=200)
    servo.axis.jam(True)
    servo.set(Torque_Control_Mode_Enable=1, Torque_Enable=1, Goal_Torque=250)
    servo.run(0.2)
    assert servo.read("Current") == pytest.approx(2048 + 200, abs=2)


def test_position_control_returns_when_torque_control_ends() -> None:
    servo = ClassicBench("mx-64")
    servo.set(Torque_Control_Mode_Enable=1, Torque_Enable=1, Goal_Torque=50)
    servo.run(0.3)
    servo.set(Torque_Control_Mode_Enable=0, Goal_Position=2000, Moving_Speed=100)
    servo.run(3.0)
    assert servo.read("Present Position") == pytest.approx(2000, abs=3)


def test_reverse_mode_of_an_mx_106_turns_the_other_way() -> None:
    servo = ClassicBench("mx-106", 2048, Drive_Mode=1)
    before = servo.axis.angle
    assert servo.read("Present Position") == 2048
    servo.set(Goal_Position=2548)
    servo.run(2.0)
    assert servo.read("Present Position") == pytest.approx(2548, abs=3)
    assert servo.axis.angle - before == pytest.approx(-500 * 6.283185 / 4096, abs=0.005)
