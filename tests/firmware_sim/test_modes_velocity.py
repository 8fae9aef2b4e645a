"""Velocity mode: PI control, acceleration, and what it reports."""

import pytest

from firmware_sim.firmware.codes import StatusError

from .solo import Solo

RPM = 0.229  # of one count (e-Manual, "Goal Velocity(104)")
RPM2 = 214.577  # rev/min^2 of one count ("Profile Acceleration(108)")


def running(goal: int = 100, name: str = "xm430-w350", **registers: int) -> Solo:
    solo = Solo(name, Operating_Mode=1)
    solo.set(**registers, Torque_Enable=1, Goal_Velocity=goal)
    return solo


@pytest.mark.parametrize("name", ["xm430-w350", "xl430-w250", "xl330-m288", "xm540-w270"])
@pytest.mark.parametrize("goal", [60, -60])
def test_it_turns_with_the_goal_velocity(name: str, goal: int) -> None:
    solo = running(goal, name)
    solo.wait(5.0)
    assert solo.read("Present Velocity") == pytest.approx(goal, abs=1)
    start = solo.read("Present Position")
    solo.wait(1.0)
    turned = solo.read("Present Position") - start
    assert turned == pytest.approx(goal * RPM / 60.0 * 4096, rel=0.02)


def test_it_follows_an_acceleration() -> None:
    """Trajectory v = a t, and the counts' units: 10 counts are 2145.77 rev/min^2."""
    solo = running(100, Profile_Acceleration=10)
    ramp = 100 * RPM / (10 * RPM2) * 60.0  # s
    for _ in range(5):
        solo.wait(ramp / 5.0)
        wanted = min(100.0, solo.world.now / ramp * 100.0)
        assert solo.read("Velocity Trajectory") == pytest.approx(wanted, abs=1.0)
    solo.wait(0.01)
    assert solo.read("Velocity Trajectory") == 100


def test_a_time_based_acceleration_is_how_long_it_takes() -> None:
    solo = Solo(Operating_Mode=1, Drive_Mode=4)
    solo.set(Torque_Enable=1, Profile_Acceleration=400, Goal_Velocity=80)
    solo.wait(0.2)
    assert solo.read("Velocity Trajectory") == pytest.approx(40, abs=1)
    solo.wait(0.201)
    assert solo.read("Velocity Trajectory") == 80
    solo.set(Goal_Velocity=-80)
    solo.wait(0.2)
    assert solo.read("Velocity Trajectory") == pytest.approx(0, abs=1)


def test_a_ramp_and_a_turn_are_movement() -> None:
    solo = running(100, Profile_Acceleration=1)
    solo.wait(0.01)
    assert solo.read("Moving") == 1
    assert solo.read("Moving Status") & 0x0B == 0x02  # in position, following error: other modes
    solo.wait(15.0)
    assert solo.read("Moving") == 1
    assert solo.read("Moving Status") & 0x0B == 0x00
    solo.set(Profile_Acceleration=0, Goal_Velocity=0)
    solo.wait(2.0)
    assert solo.read("Moving") == 0


def test_proportional_gain_alone_leaves_the_error_of_the_closed_form() -> None:
    """P control of v = k u - f: v = (k P g - f) / (1 + k P), all in counts.

    k is the no-load speed over a full PWM, less the friction's 1 % of the stall torque, f.
    """
    solo = running(100, Velocity_I_Gain=0, Velocity_P_Gain=640)
    solo.wait(3.0)
    proportional = 640 / 128
    gain = 46.0 / RPM / 885 / 0.99
    friction = 0.01 * 885
    wanted = gain * (proportional * 100 - friction) / (1.0 + gain * proportional)
    assert solo.read("Present Velocity") == pytest.approx(wanted, abs=1.0)


def test_the_integral_removes_the_error_of_a_load() -> None:
    solo = running(50)
    solo.axis.apply_load(1.0)
    solo.wait(5.0)
    assert solo.read("Present Velocity") == pytest.approx(50, abs=1)
    assert solo.read("Present Current") > 150


def test_goal_pwm_caps_the_output() -> None:
    solo = running(200, Goal_PWM=200)
    solo.wait(3.0)
    assert 194 <= solo.read("Present PWM") <= 200
    assert solo.read("Present Velocity") == pytest.approx(46 / RPM * (200 / 885 - 0.01), abs=2)


def test_reverse_mode_turns_it() -> None:
    solo = Solo(Operating_Mode=1, Drive_Mode=1)
    solo.set(Torque_Enable=1, Goal_Velocity=50)
    solo.wait(3.0)
    assert solo.axis.velocity < 0.0
    assert solo.read("Present Velocity") == pytest.approx(50, abs=1)
    assert solo.read("Present PWM") > 0
    assert solo.read("Present Position") > 2048


def test_the_velocity_limit_is_a_limit() -> None:
    solo = Solo(Operating_Mode=1, Velocity_Limit=80)
    assert solo.write("Goal Velocity", 81) == StatusError.DATA_LIMIT
    assert solo.write("Goal Velocity", -80) == StatusError.NONE


def test_a_goal_written_before_the_torque_counts_when_it_comes_on() -> None:
    solo = Solo(Operating_Mode=1)
    solo.set(Goal_Velocity=40)
    solo.wait(0.5)
    assert solo.read("Present Velocity") == 0
    solo.set(Torque_Enable=1)
    solo.wait(3.0)
    assert solo.read("Present Velocity") == pytest.approx(40, abs=1)


def test_positions_run_over_many_turns() -> None:
    solo = running(200)
    solo.wait(10.0)
    assert solo.read("Present Position") > 5 * 4096
    assert solo.read("Position Trajectory") == solo.read("Present Position")
