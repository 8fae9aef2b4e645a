"""Motors and profiles as the registers of a servo show them."""

from collections.abc import Callable

import pytest

from firmware_sim.tables import find_model

from .conftest import Bench

VELOCITY_UNIT = 0.229 * 4096 / 60  # ticks/s of a count (e-Manual, "Profile Velocity(112)")
ACCELERATION_UNIT = 214.577 * 4096 / 3600  # ticks/s^2 ("Profile Acceleration(108)")
PWM_FULL = 885
FRICTION = 4
"""Ticks by which the friction of the gears lets a servo with its default gains miss its goal."""

MakeBench = Callable[..., Bench]


def test_a_load_pulls_it_off_the_goal_by_what_the_gain_needs(bench: MakeBench) -> None:
    """Holding 1 N m of 4.1 takes 24.4 % PWM, which P = 800 / 128 makes of 34.5 ticks."""
    rig = bench()
    rig.write(64, 1)
    rig.servos[0].apply_load(1.0)
    rig.wait(2.0)
    error = 1.0 / 4.1 * PWM_FULL / (800 / 128)
    assert rig.read(132, 4) == pytest.approx(2048 - error, abs=FRICTION)
    carried = 0.012  # by static friction, of full effort
    assert rig.read(124, 2) == pytest.approx(PWM_FULL / 4.1, abs=carried * PWM_FULL + 3.0)
    assert rig.read(126, 2) == pytest.approx(2300.0 / 4.1 / 2.69, abs=carried * 2300.0 / 2.69 + 1.5)
    rig.write(82, 200, 2)  # an integral gain takes the error away
    rig.wait(20.0)
    assert rig.read(132, 4) == pytest.approx(2048, abs=1)


def test_the_xl430_shows_load_instead_of_current(bench: MakeBench) -> None:
    rig = bench("xl430-w250:1")
    rig.write(64, 1)
    rig.servos[0].apply_load(0.3)
    rig.wait(3.0)
    assert rig.read(126, 2) == pytest.approx(1000 * 0.3 / 1.5, abs=14)


def test_goal_pwm_caps_the_output(bench: MakeBench) -> None:
    rig = bench()
    rig.write(64, 1)
    rig.write(100, 200, 2)
    rig.write(116, 4000, 4)
    rig.wait(0.2)
    assert rig.read(124, 2) == 200
    speed = 46.0 * (200 / PWM_FULL - 0.01) / 0.99  # gear friction takes 1 % of the torque
    assert rig.read(128, 4) == pytest.approx(speed / 0.229, abs=1.0)


def test_it_overheats_and_shuts_down(bench: MakeBench) -> None:
    rig = bench()
    rig.write(64, 1)
    rig.servos[0].apply_load(3.5)
    rig.wait(5.0)
    warm = rig.read(146)
    rig.wait(600.0)
    assert 25 < warm < 80
    assert rig.ask(1, 0x01)[0][1] == 0x80
    assert (rig.read(70), rig.read(64), rig.read(124, 2)) == (0x04, 0, 0)


@pytest.mark.parametrize("name", ["xm430-w350", "xm540-w270", "xl430-w250", "xl330-m288"])
def test_a_stream_of_goals_is_followed_with_the_loops_lag(bench: MakeBench, name: str) -> None:
    """A ramp is followed with the lag PWM_FULL / (P v0), and reached without error.

    The XL430's large D gain meets the cap of the PWM at each step of the goal, which costs more.
    """
    rig = bench(f"{name}:1", start_tick=1000)
    rig.write(64, 1)
    start = rig.clock.now()
    for tick in range(1, 201):  # 200 Hz
        rig.clock.advance_to(start + tick / 200)
        rig.write(116, 1000 + 5 * tick, 4)
    model = find_model(name)
    gain = model.table["Position P Gain"].default / 128
    speed = model.motor.no_load_speed / 60 * 4096
    lag = PWM_FULL / (gain * speed)
    friction = 0.01 * PWM_FULL / gain
    assert lag < 0.080
    behind = 2000 - rig.read(132, 4)
    if model.table["Position D Gain"].default:
        assert 1000 * lag < behind < 1600 * lag + friction
    else:
        assert behind == pytest.approx(1000 * lag + friction, abs=4.0)
    rig.wait(1.0)
    assert rig.read(132, 4) == pytest.approx(2000, abs=FRICTION)
    assert rig.read(128, 4) == 0


def test_trajectory_registers_follow_the_profile(bench: MakeBench) -> None:
    rig = bench()
    rig.write(112, 50, 4)
    rig.write(108, 5, 4)
    rig.write(64, 1)
    rig.write(116, 3048, 4)
    start = rig.clock.now()
    speed, acceleration = 50 * VELOCITY_UNIT, 5 * ACCELERATION_UNIT
    ramp = speed / acceleration
    for since in (0.1, 0.3, 0.6, 0.9, 1.2):
        rig.clock.advance_to(start + since)
        expected = (
            0.5 * acceleration * since**2
            if since < ramp
            else 0.5 * speed * ramp + speed * (since - ramp)
        )
        velocity = min(acceleration * since, speed)
        # A millisecond of physics, a wire time, and a count of rounding.
        assert rig.read(140, 4) == pytest.approx(2048 + expected, abs=2.0 + 2e-3 * speed)
        assert rig.read(136, 4) == pytest.approx(velocity / VELOCITY_UNIT, abs=1.5)
        assert (rig.read(122), rig.read(123) & 0x32) == (1, 0x32)
    rig.wait(2.0)
    assert rig.read(140, 4) == 3048
    assert rig.read(132, 4) == pytest.approx(3048, abs=FRICTION)
    assert (rig.read(122), rig.read(123)) == (0, 0x31)
    assert rig.read(136, 4) == 0


def test_a_time_based_profile_through_the_registers(bench: MakeBench) -> None:
    rig = bench(Drive_Mode=4)
    rig.write(112, 1000, 4)
    rig.write(108, 500, 4)
    rig.write(64, 1)
    rig.write(116, 3048, 4)
    start = rig.clock.now()
    rig.clock.advance_to(start + 0.5)
    assert rig.read(140, 4) == pytest.approx(2548, abs=5)
    assert rig.read(123) & 0x30 == 0x20
    rig.clock.advance_to(start + 0.99)
    assert rig.read(122) == 1
    rig.clock.advance_to(start + 1.01)
    assert rig.read(140, 4) == 3048


def test_a_goal_on_the_way_keeps_the_velocity(bench: MakeBench) -> None:
    rig = bench()
    rig.write(112, 50, 4)
    rig.write(108, 5, 4)
    rig.write(64, 1)
    rig.write(116, 4000, 4)
    rig.wait(0.9)
    before = rig.read(136, 4)
    rig.write(116, 1000, 4)
    assert before == 50
    assert rig.read(136, 4) == pytest.approx(before, abs=1)
    rig.wait(0.2)
    slower = rig.read(136, 4)
    assert 0 < slower < 50 - 10
    rig.wait(6.0)
    assert rig.read(132, 4) == pytest.approx(1000, abs=FRICTION)


def test_a_rectangular_profile_shows_as_one(bench: MakeBench) -> None:
    rig = bench()
    rig.write(112, 50, 4)
    rig.write(64, 1)
    rig.write(116, 3048, 4)
    rig.wait(0.1)
    assert rig.read(123) & 0x32 == 0x12
    assert rig.read(136, 4) == 50
