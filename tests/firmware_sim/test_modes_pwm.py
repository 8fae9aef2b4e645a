"""PWM mode, and the slope of the 330 series."""

import pytest

from firmware_sim.firmware.codes import StatusError

from .solo import Solo


@pytest.mark.parametrize("goal", [442, -442])
def test_half_the_pwm_gives_half_the_speed(goal: int) -> None:
    solo = Solo(Operating_Mode=16)
    solo.set(Torque_Enable=1, Goal_PWM=goal)
    solo.wait(3.0)
    assert solo.read("Present PWM") == goal
    speed = 46.0 / 0.229 * (abs(goal) / 885 - 0.01) / 0.99  # gear friction: 1 % of stall torque
    assert abs(solo.read("Present Velocity")) == pytest.approx(speed, abs=1)
    assert solo.read("Present Velocity") * goal > 0


def test_gains_do_nothing() -> None:
    solo = Solo(Operating_Mode=16)
    solo.set(Torque_Enable=1, Goal_PWM=300, Position_P_Gain=16_000, Velocity_P_Gain=16_000)
    solo.set(Goal_Position=0, Goal_Velocity=-100)
    solo.wait(2.0)
    assert solo.read("Present PWM") == 300


def test_the_pwm_limit_is_a_limit() -> None:
    solo = Solo(Operating_Mode=16, PWM_Limit=400)
    assert solo.write("Goal PWM", 401) == StatusError.DATA_LIMIT
    assert solo.write("Goal PWM", -400) == StatusError.NONE


def test_the_slope_of_the_manuals_example() -> None:
    """PWM Slope(62) 140 at 5 V: full PWM after 5000 mV / 276.84 mV/ms = 18.06 ms."""
    solo = Solo("xl330-m288", Operating_Mode=16, PWM_Slope=140)
    solo.set(Torque_Enable=1, Goal_PWM=885)
    for millisecond in range(1, 19):
        solo.wait(0.001)
        assert solo.read("Present PWM") == pytest.approx(885 * millisecond / 18.06, abs=1)
    solo.wait(0.001)
    assert solo.read("Present PWM") == 885


def test_the_slope_counts_from_the_present_pwm_and_both_ways() -> None:
    solo = Solo("xl330-m288", Operating_Mode=16, PWM_Slope=70)
    solo.set(Torque_Enable=1, Goal_PWM=400)
    solo.wait(0.1)
    assert solo.read("Present PWM") == 400
    solo.set(Goal_PWM=-400)
    solo.wait(0.010)
    assert solo.read("Present PWM") == pytest.approx(400 - 10 * 885 / 36.12, abs=2)
    solo.wait(0.1)
    assert solo.read("Present PWM") == -400


def test_torque_off_ends_a_slope() -> None:
    solo = Solo("xl330-m288", Operating_Mode=16, PWM_Slope=1)
    solo.set(Torque_Enable=1, Goal_PWM=885)
    solo.wait(0.05)
    solo.set(Torque_Enable=0)
    solo.wait(0.5)
    assert solo.read("Present PWM") == 0


def test_other_models_change_the_pwm_at_once() -> None:
    solo = Solo("xm430-w350", Operating_Mode=16)
    solo.set(Torque_Enable=1, Goal_PWM=885)
    solo.wait(0.001)
    assert solo.read("Present PWM") == 885


def test_the_slope_of_the_manuals_example_at_12_v() -> None:
    """PWM Slope(62) 255 in 3.955 mV/ms: full PWM after 12000 mV / 1008.47 mV/ms = 11.90 ms."""
    solo = Solo("xc330-t288", voltage=12.0, Operating_Mode=16, PWM_Slope=255)
    solo.set(Torque_Enable=1, Goal_PWM=885)
    for millisecond in range(1, 12):
        solo.wait(0.001)
        assert solo.read("Present PWM") == pytest.approx(885 * millisecond / 11.90, abs=1)
    solo.wait(0.001)
    assert solo.read("Present PWM") == 885


@pytest.mark.parametrize(("mode", "goal"), [(3, "Goal_Position"), (1, "Goal_Velocity")])
def test_the_slope_holds_in_the_other_modes(mode: int, goal: str) -> None:
    solo = Solo("xl330-m288", Operating_Mode=mode, PWM_Slope=14)
    solo.axis.jam(on=True)
    solo.set(Velocity_I_Gain=16_000, Velocity_P_Gain=16_000, Torque_Enable=1)
    solo.set(**{goal: 400})
    solo.wait(0.05)
    sign = -1 if mode == 3 else 1
    assert solo.read("Present PWM") == pytest.approx(sign * 50 * 885 / 180.6, abs=2)
    solo.wait(0.2)
    assert solo.read("Present PWM") == sign * 885
