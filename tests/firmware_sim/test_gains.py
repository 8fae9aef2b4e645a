"""Position gains and feed-forward: the conversions of the manual, seen in the PWM they make."""

import pytest

from .solo import Solo

PROFILE = {"Profile_Velocity": 60, "Profile_Acceleration": 20}


def lag_of(gain: int) -> float:
    """Following error, ticks, in the middle of a ramp with a feed-forward gain."""
    solo = Solo(Operating_Mode=4)
    solo.set(Position_P_Gain=400, Feedforward_1st_Gain=gain, **PROFILE)
    solo.set(Torque_Enable=1, Goal_Position=8000)
    solo.wait(2.0)
    return solo.read("Position Trajectory") - solo.read("Present Position")


@pytest.mark.parametrize("gain", [400, 800, 1600])
def test_a_held_load_shows_the_proportional_gain(gain: int) -> None:
    """PWM = P/128 times the error in ticks."""
    solo = Solo()
    solo.set(Position_P_Gain=gain, Torque_Enable=1)
    solo.axis.apply_load(1.0)
    solo.wait(1.0)
    error = 2048 - solo.read("Present Position")
    assert error > 0
    assert solo.read("Present PWM") == pytest.approx(gain / 128 * error, abs=1)


def test_the_integral_brings_a_loaded_horn_to_its_goal() -> None:
    solo = Solo()
    solo.set(Position_I_Gain=200, Torque_Enable=1)
    solo.axis.apply_load(1.0)
    solo.wait(8.0)
    assert solo.read("Present Position") == pytest.approx(2048, abs=1)
    assert solo.read("Present PWM") == pytest.approx(885 / 4.1, abs=20)


def test_the_integral_counts_error_over_milliseconds() -> None:
    """With P = 0 a blocked horn's PWM grows by I/65536 of the error in ticks every ms."""
    solo = Solo()
    solo.axis.jam(on=True)
    solo.set(Position_P_Gain=0, Position_I_Gain=100, Torque_Enable=1, Goal_Position=2148)
    solo.wait(1.0)
    assert solo.read("Present PWM") == pytest.approx(100 / 65_536 * 100 * 1000, abs=1.5)


def test_the_derivative_brakes() -> None:
    """A step with much P overshoots; D makes it overshoot less."""
    tops = []
    for gain in (0, 3000):
        solo = Solo()
        solo.set(Position_P_Gain=6000, Position_D_Gain=gain, Torque_Enable=1, Goal_Position=2300)
        top = 0
        for _ in range(300):
            solo.wait(0.001)
            top = max(top, solo.read("Present Position"))
        tops.append(top)
    assert tops[0] - 2300 > 2 * (tops[1] - 2300)


def test_velocity_feed_forward_takes_the_lag_away() -> None:
    """The speed that a PWM of K/4 a tick per ms gives cancels the lag; half of it, half of it."""
    speed = 60 * 0.229 / 60 * 4.096  # ticks per ms
    needed = 60 / (46.0 / 0.229) * 885 * 0.99 + 0.01 * 885  # PWM for it, with the gears' friction
    gain = round(4 * needed / speed)
    lag, half, none = lag_of(0), lag_of(gain // 2), lag_of(gain)
    assert lag == pytest.approx(needed / (400 / 128), rel=0.1)
    assert half == pytest.approx(lag / 2, rel=0.1)
    assert abs(none) <= 3


def test_acceleration_feed_forward_pushes_while_it_accelerates() -> None:
    """K/4 times ticks per ms^2, in PWM, from the first moment."""
    pushes = []
    for gain in (0, 16_000):
        solo = Solo(Operating_Mode=4)
        solo.axis.jam(on=True)
        solo.set(Position_P_Gain=0, Feedforward_2nd_Gain=gain, **PROFILE, Torque_Enable=1)
        solo.set(Goal_Position=8000)
        solo.wait(0.01)
        pushes.append(solo.read("Present PWM"))
    acceleration = 20 * 214.577 / 3600 * 4096 * 1e-6  # ticks per ms^2
    assert pushes[0] == 0
    assert pushes[1] == pytest.approx(16_000 / 4 * acceleration, abs=1)
