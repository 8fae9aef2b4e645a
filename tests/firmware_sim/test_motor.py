"""The motor against its data sheet, and the position loop against hand calculations."""

import math
from collections.abc import Callable

import pytest

from firmware_sim.drive import PositionDrive
from firmware_sim.model import PWM_FULL, TICKS_PER_TURN
from firmware_sim.motor import (
    AMBIENT_TEMPERATURE,
    STEP,
    THERMAL_RESISTANCE,
    THERMAL_TIME,
    Motor,
)
from firmware_sim.profile import velocity_profile
from firmware_sim.tables import MODEL_NAMES, find_model

from .conftest import Bench

MakeBench = Callable[..., Bench]


def motor_of(name: str, supply: float | None = None) -> Motor:
    data = find_model(name).motor
    return Motor(data, 0.0, data.nominal_voltage if supply is None else supply)


def drive(motor: Motor, duty: float, duration: float) -> None:
    for _ in range(round(duration / STEP)):
        motor.drive(duty)


@pytest.mark.parametrize("name", MODEL_NAMES)
def test_full_voltage_without_load_gives_the_data_sheets_speed(name: str) -> None:
    motor = motor_of(name)
    drive(motor, 1.0, 0.5)
    speed = motor.velocity * 60.0 / TICKS_PER_TURN
    assert speed == pytest.approx(find_model(name).motor.no_load_speed, rel=1e-6)
    assert motor.current == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("name", MODEL_NAMES)
def test_stall_torque_stops_it_at_the_stall_current(name: str) -> None:
    motor, data = motor_of(name), find_model(name).motor
    motor.load_torque = data.stall_torque
    drive(motor, 1.0, 0.5)
    assert motor.velocity == pytest.approx(0.0, abs=1e-6)
    assert motor.current == pytest.approx(data.stall_current)


def test_speed_settles_with_the_mechanical_time_constant() -> None:
    data = find_model("xm540-w270").motor
    time_constant = data.inertia * data.no_load_speed / 60.0 * 2.0 * math.pi / data.stall_torque
    motor = motor_of("xm540-w270")
    drive(motor, 1.0, 0.010)
    full = data.no_load_speed / 60.0 * TICKS_PER_TURN
    settled = 1.0 - math.exp(-0.010 / time_constant)
    assert motor.velocity == pytest.approx(full * settled, rel=1e-9)
    assert motor.angle == pytest.approx(full * (0.010 - time_constant * settled), rel=1e-9)
    assert 0.005 < time_constant < 0.02


def test_a_lower_supply_makes_it_slower() -> None:
    """The data sheet has 43 rev/min at 11.1 V beside 46 at 12 V, which is the line through zero."""
    motor = motor_of("xm430-w350", supply=11.1)
    drive(motor, 1.0, 0.5)
    assert motor.velocity * 60.0 / TICKS_PER_TURN == pytest.approx(43.0, abs=1.0)


def test_losses_warm_it_with_the_square_of_the_current() -> None:
    def rise(load: float) -> float:
        motor = motor_of("xm430-w350")
        motor.load_torque = load
        drive(motor, load / 4.1, 2.0)
        motor.rest(20.0 * THERMAL_TIME)
        return motor.temperature - AMBIENT_TEMPERATURE

    resistance = 12.0 / 2.3
    current = 2.3 * 0.5 / 4.1
    assert rise(0.5) == pytest.approx(current**2 * resistance * THERMAL_RESISTANCE, rel=1e-3)
    assert rise(1.0) == pytest.approx(4.0 * rise(0.5), rel=1e-3)


def test_resting_warms_as_stepping_does() -> None:
    stepped, rested = motor_of("xl430-w250"), motor_of("xl430-w250")
    for motor in (stepped, rested):
        motor.load_torque = 0.7
        drive(motor, 0.7 / 1.5, 1.0)
    drive(stepped, 0.7 / 1.5, 30.0)
    rested.rest(30.0)
    assert rested.temperature == pytest.approx(stepped.temperature, abs=1e-6)


def test_a_load_pulls_it_off_the_goal_by_what_the_gain_needs(bench: MakeBench) -> None:
    """Holding 1 N m of 4.1 takes 24.4 % PWM, which P = 800 / 128 makes of 34.5 ticks."""
    rig = bench()
    rig.write(64, 1)
    rig.servos[0].apply_load(1.0)
    rig.wait(2.0)
    error = 1.0 / 4.1 * PWM_FULL / (800 / 128)
    assert rig.read(132, 4) == pytest.approx(2048 - error, abs=1.0)
    assert rig.read(124, 2) == pytest.approx(PWM_FULL / 4.1, abs=1.0)
    assert rig.read(126, 2) == pytest.approx(2300.0 / 4.1 / 2.69, abs=1.5)
    rig.write(82, 200, 2)  # an integral gain takes the error away
    rig.wait(20.0)
    assert rig.read(132, 4) == pytest.approx(2048, abs=1)


def test_the_xl430_shows_load_instead_of_current(bench: MakeBench) -> None:
    rig = bench("xl430-w250:1")
    rig.write(64, 1)
    rig.servos[0].apply_load(0.3)
    rig.wait(3.0)
    assert rig.read(126, 2) == pytest.approx(1000 * 0.3 / 1.5, abs=2)


@pytest.mark.parametrize(
    ("gains", "expected"),
    [
        ((800, 0, 0), 20 * 800 / 128),
        ((0, 6554, 0), 20 * 6554 / 65536),
        ((0, 0, 160), 20 * 160 / 16),
    ],
    ids=["P", "I", "D"],
)
def test_gains_make_the_pwm_that_the_manual_says(
    gains: tuple[int, int, int], expected: float
) -> None:
    """After one period with an error of 20 ticks: P/128, I/65536 and D/16 of it."""
    drive = PositionDrive(motor_of("xm430-w350"))
    drive.set_gains(*gains)
    drive.engage()
    drive.follow(velocity_profile(0.0, 0.0, 20.0, 0.0, 0.0))
    drive.advance(1)
    assert drive.pwm == pytest.approx(expected)


def test_goal_pwm_caps_the_output(bench: MakeBench) -> None:
    rig = bench()
    rig.write(64, 1)
    rig.write(100, 200, 2)
    rig.write(116, 4000, 4)
    rig.wait(0.2)
    assert rig.read(124, 2) == 200
    assert rig.read(128, 4) == pytest.approx(46.0 * 200 / PWM_FULL / 0.229, abs=1.0)


def test_it_overheats_and_shuts_down(bench: MakeBench) -> None:
    rig = bench()
    rig.write(64, 1)
    rig.servos[0].apply_load(4.0)
    rig.wait(5.0)
    warm = rig.read(146)
    rig.wait(600.0)
    assert 25 < warm < 80
    assert rig.ask(1, 0x01)[0][1] == 0x80
    assert (rig.read(70), rig.read(64), rig.read(124, 2)) == (0x04, 0, 0)


@pytest.mark.parametrize("name", MODEL_NAMES)
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
    speed = model.motor.no_load_speed / 60 * TICKS_PER_TURN
    lag = PWM_FULL / (gain * speed)
    assert lag < 0.080
    behind = 2000 - rig.read(132, 4)
    if model.table["Position D Gain"].default:
        assert 1000 * lag < behind < 1600 * lag
    else:
        assert behind == pytest.approx(1000 * lag, abs=4.0)
    rig.wait(1.0)
    assert rig.read(132, 4) == 2000
    assert rig.read(128, 4) == rig.read(124, 2) == 0
