"""The motor against its data sheet, closed forms and hand calculations."""

import math
from dataclasses import replace

import pytest

from firmware_sim.physics import kernel
from firmware_sim.physics.axis import Axes
from firmware_sim.physics.kernel import (
    AMBIENT_TEMPERATURE,
    STATIC_FRICTION,
    STEP,
)
from firmware_sim.physics.plant import JointsPlant
from firmware_sim.tables import MODEL_NAMES, find_model

from .one_axis import DATA_SHEETS, TICK, OneAxis


@pytest.mark.parametrize("name", MODEL_NAMES)
def test_every_model_keeps_to_its_data_sheet(name: str) -> None:
    """No-load speed at nominal voltage, stall current in a jam, and a lag of some milliseconds."""
    motor = find_model(name).motor
    rig = OneAxis(motor)
    rig.axis.drive_duty(-1.0)
    rig.run(1.0)
    assert rig.axis.velocity * 30.0 / math.pi == pytest.approx(-motor.no_load_speed, rel=1e-6)
    rig.axis.jam(on=True)
    rig.run(STEP)
    assert rig.axis.current == pytest.approx(-motor.stall_current, rel=1e-12)
    assert 0.004 < motor.inertia * rig.no_load_speed / motor.stall_torque < 0.03


@pytest.mark.parametrize("name", DATA_SHEETS)
def test_full_voltage_without_load_gives_the_data_sheets_speed(name: str) -> None:
    """The losses of the gears at that speed take friction and drag of the stall current."""
    rig = OneAxis(name)
    rig.axis.drive_duty(1.0)
    rig.run(1.0)
    motor = rig.motor
    assert rig.axis.velocity == pytest.approx(rig.no_load_speed, rel=1e-9)
    lost = motor.friction + motor.drag
    assert rig.axis.current == pytest.approx(lost * motor.stall_current, rel=1e-9)


@pytest.mark.parametrize("name", DATA_SHEETS)
def test_stall_torque_stops_it_at_the_stall_current(name: str) -> None:
    rig = OneAxis(name)
    rig.axis.apply_load(rig.motor.stall_torque)
    rig.axis.drive_duty(1.0)
    rig.run(1.0)
    assert rig.axis.velocity == 0.0
    assert rig.axis.current == pytest.approx(rig.motor.stall_current, rel=1e-12)


def test_speed_falls_in_a_line_with_the_load() -> None:
    """From the no-load speed down to standstill at the stall torque less friction."""
    rig = OneAxis()
    motor = rig.motor
    rig.axis.drive_duty(1.0)
    for share in (0.0, 0.25, 0.5, 0.75):
        rig.axis.apply_load(share * (1.0 - motor.friction) * motor.stall_torque)
        rig.run(1.0)
        assert rig.axis.velocity == pytest.approx((1.0 - share) * rig.no_load_speed, rel=1e-9)
        torque = motor.stall_torque / motor.stall_current * rig.axis.current
        losses = rig.friction + rig.drag * rig.axis.velocity
        load = share * (1.0 - motor.friction) * motor.stall_torque
        assert torque == pytest.approx(load + losses, rel=1e-9)


def test_speed_settles_with_the_mechanical_time_constant() -> None:
    """A first-order lag of J v0 / (T0 (1 - friction)), exact at every step."""
    rig = OneAxis("xm540-w270")
    motor = rig.motor
    lag = motor.inertia * rig.no_load_speed / (motor.stall_torque * (1.0 - motor.friction))
    rig.axis.drive_duty(1.0)
    for _ in range(30):
        rig.run(STEP)
    settled = 1.0 - math.exp(-0.030 / lag)
    assert rig.axis.velocity == pytest.approx(rig.no_load_speed * settled, rel=1e-9)
    assert rig.axis.angle == pytest.approx(rig.no_load_speed * (0.030 - lag * settled), rel=1e-9)
    assert 0.005 < lag < 0.02


def test_a_lower_supply_makes_it_slower() -> None:
    """The data sheet has 43 rev/min at 11.1 V beside 46 at 12 V."""
    rig = OneAxis(supply=11.1)
    rig.axis.drive_duty(1.0)
    rig.run(1.0)
    assert rig.axis.velocity * 30.0 / math.pi == pytest.approx(43.0, abs=1.0)


def test_static_friction_holds_and_coulomb_friction_lets_run_on() -> None:
    rig = OneAxis()
    friction = rig.motor.friction
    between = 0.5 * (1.0 + STATIC_FRICTION) * friction
    rig.axis.drive_duty(between)
    rig.run(0.5)
    assert (rig.axis.velocity, rig.axis.angle) == (0.0, 0.0)
    assert rig.axis.settled
    rig.axis.drive_duty(1.01 * STATIC_FRICTION * friction)
    rig.run(0.1)
    assert rig.axis.velocity > 0.0
    rig.axis.drive_duty(between)
    rig.run(5.0)
    slope = rig.no_load_speed / (1.0 - friction)
    assert rig.axis.velocity == pytest.approx((between - friction) * slope, rel=1e-6)


def test_without_torque_the_gears_run_down() -> None:
    """J dv/dt = -Tf - b v: it stands after J/b ln(1 + b v0 / Tf)."""
    rig = OneAxis()
    rig.axis.drive_duty(1.0)
    rig.run(1.0)
    start, speed = rig.axis.angle, rig.axis.velocity
    rig.axis.release()
    lag, drift = rig.motor.inertia / rig.drag, rig.friction / rig.drag
    rig.run(0.1)
    left = (speed + drift) * math.exp(-0.1 / lag) - drift
    assert rig.axis.velocity == pytest.approx(left, rel=1e-9)
    assert (rig.axis.current, rig.axis.duty) == (0.0, 0.0)
    stands_after = lag * math.log(1.0 + speed / drift)
    rig.run(stands_after - 0.1 + 2 * STEP)
    assert rig.axis.velocity == 0.0
    way = speed * lag - drift * stands_after
    assert rig.axis.angle - start == pytest.approx(way, rel=1e-9)
    assert rig.axis.settled


def test_without_torque_a_load_turns_it_against_friction() -> None:
    rig = OneAxis()
    rig.axis.apply_load(rig.friction)
    rig.run(1.0)
    assert rig.axis.angle == 0.0
    rig.axis.apply_load(0.5)
    rig.run(0.05)
    lag = rig.motor.inertia / rig.drag
    final = (0.5 - rig.friction) / rig.drag
    assert rig.axis.velocity == pytest.approx(-final * (1.0 - math.exp(-0.05 / lag)), rel=1e-9)
    rig.run(5.0)
    assert rig.axis.velocity == pytest.approx(-final, rel=1e-6)


def test_a_reversal_agrees_with_small_steps() -> None:
    """Through standstill within a step, against Euler's method at a microsecond."""
    rig = OneAxis()
    motor = rig.motor
    rig.axis.drive_duty(0.3)
    rig.run(0.05)
    angle, speed = rig.axis.angle, rig.axis.velocity
    rig.axis.drive_duty(-0.4)
    rig.run(0.04)
    lost = motor.friction + motor.drag
    back_emf_torque = motor.stall_torque * (1.0 - lost) / rig.no_load_speed
    for _ in range(40_000):
        torque = -0.4 * motor.stall_torque - (back_emf_torque + rig.drag) * speed
        torque -= math.copysign(rig.friction, speed)
        speed += torque / motor.inertia * 1e-6
        angle += speed * 1e-6
    assert rig.axis.velocity == pytest.approx(speed, rel=1e-4)
    assert rig.axis.angle == pytest.approx(angle, abs=1e-5)
    assert speed < 0.0


@pytest.mark.parametrize("load", [0.5, 1.0])
def test_losses_warm_it_with_the_square_of_the_current(load: float) -> None:
    """A first-order curve to i^2 R times the thermal resistance; the load of a jam is known."""
    rig = OneAxis()
    motor = rig.motor
    rig.axis.jam(on=True)
    rig.axis.drive_duty(load / motor.stall_torque)
    current = motor.stall_current * load / motor.stall_torque
    power = current**2 * motor.nominal_voltage / motor.stall_current
    for _ in range(2):
        rig.run(120.0)
    rise = power * 8.0 * (1.0 - math.exp(-240.0 / 240.0))  # an XM430: 8 K/W, 240 s
    assert rig.axis.temperature - AMBIENT_TEMPERATURE == pytest.approx(rise, rel=1e-5)


@pytest.mark.parametrize(
    ("name", "resistance", "time"), [("xl330-m288", 21.98, 144.8), ("xm540-w270", 5.019, 303.0)]
)
def test_heat_goes_by_the_size_of_the_servo(name: str, resistance: float, time: float) -> None:
    """18 g and 165 g against 82 g: 8 K/W times (m / 82 g)^(-2/3), 240 s times (m / 82 g)^(1/3)."""
    rig = OneAxis(find_model(name).motor)
    rig.axis.jam(on=True)
    rig.axis.drive_duty(0.3)
    rig.run(100.0)
    losses = (0.3 * rig.motor.stall_current) ** 2
    losses *= rig.motor.nominal_voltage / rig.motor.stall_current
    rise = losses * resistance * (1.0 - math.exp(-100.0 / time))
    assert rig.axis.temperature - 25.0 == pytest.approx(rise, rel=1e-3)


def test_resting_warms_as_stepping_does() -> None:
    """The second of two axes rests only if the first does too."""
    temperatures = []
    for first_runs in (False, True):
        axes = Axes(2)
        for axis in axes:
            axis.configure(DATA_SHEETS["xl430-w250"], TICK, 12.0)
        axes[1].jam(on=True)
        axes[1].drive_duty(0.8)
        axes[0].drive_duty(float(first_runs))
        JointsPlant(axes, 0.0).advance(30_000)
        assert axes.settled is not first_runs
        temperatures.append(axes[1].temperature)
    assert temperatures[0] == pytest.approx(temperatures[1], abs=1e-9)
    assert temperatures[0] > AMBIENT_TEMPERATURE + 5.0


def test_the_horn_lags_by_the_backlash() -> None:
    width = 0.01
    rig = OneAxis(replace(DATA_SHEETS["xm430-w350"], backlash=width))
    motor_angle = rig.axes.column(kernel.MOTOR_ANGLE)
    rig.axis.drive_duty(0.2)
    rig.run(0.5)
    assert motor_angle[0] - rig.axis.angle == pytest.approx(0.5 * width, rel=1e-9)
    rig.axis.release()
    rig.run(2.0)
    turned, horn = motor_angle[0], rig.axis.angle
    rig.axis.drive_duty(-0.05)
    while rig.axis.angle == horn:
        assert rig.axis.velocity == 0.0
        assert motor_angle[0] > turned - width
        rig.run(STEP)
    assert motor_angle[0] <= turned - width
    assert motor_angle[0] - rig.axis.angle == pytest.approx(-0.5 * width, rel=1e-9)


def test_the_encoder_counts_to_the_nearest_tick_over_all_turns() -> None:
    rig = OneAxis(start=-20.49 * TICK)
    assert rig.axis.ticks == -20
    rig.axis.drive_duty(1.0)
    rig.run(10.0)
    assert rig.axis.ticks == pytest.approx(rig.axis.angle / TICK, abs=0.5)
    assert rig.axis.ticks > 5 * 4096
    assert type(rig.axis.ticks) is int
    assert type(rig.axis.angle) is float


def test_a_jam_holds_the_horn_until_it_is_freed() -> None:
    rig = OneAxis()
    rig.axis.jam(on=True)
    rig.axis.drive_duty(1.0)
    rig.run(1.0)
    assert (rig.axis.angle, rig.axis.velocity) == (0.0, 0.0)
    assert rig.axis.current == pytest.approx(rig.motor.stall_current)
    rig.axis.jam(on=False)
    rig.run(1.0)
    assert rig.axis.velocity == pytest.approx(rig.no_load_speed, rel=1e-6)


def test_a_stuck_encoder_lets_a_position_loop_run_away() -> None:
    rig = OneAxis().held()
    rig.axis.stick_encoder(on=True)
    rig.axis.apply_load(1.0)
    rig.run(1.0)
    assert rig.axis.ticks == 0
    assert rig.axis.angle < -1.0


def test_a_stuck_encoder_lets_a_velocity_loop_run_away() -> None:
    rig = OneAxis()
    rig.axis.stick_encoder(on=True)
    rig.axis.set_velocity_gains(0.1, 0.001)
    rig.axis.drive_velocity(0.5)
    rig.run(5.0)
    assert rig.axis.velocity == pytest.approx(rig.no_load_speed, rel=1e-3)


def test_a_supply_of_nothing_gives_nothing() -> None:
    rig = OneAxis()
    rig.axis.drive_current(0.5)
    rig.run(0.5)
    rig.axis.set_supply(0.0)
    rig.run(3.0)
    assert rig.axis.velocity == rig.axis.voltage == 0.0
    assert rig.axis.current == pytest.approx(0.0, abs=1e-12)
    rig.axis.drive_current(0.0)
    rig.run(0.1)
    assert rig.axis.duty == 0.0
    rig.axis.drive_current(0.5)
    rig.axis.set_supply(12.0)
    rig.run(0.5)
    assert rig.axis.velocity > 1.0


def test_more_friction_takes_more_torque() -> None:
    rig = OneAxis()
    rig.axis.set_friction(30.0)
    rig.axis.drive_duty(1.1 * 0.3)
    rig.run(1.0)
    assert rig.axis.angle == 0.0
    rig.axis.drive_duty(1.0)
    rig.run(1.0)
    share = (1.0 - 30.0 * rig.motor.friction) / (1.0 - rig.motor.friction)
    assert rig.axis.velocity == pytest.approx(share * rig.no_load_speed, rel=1e-9)
