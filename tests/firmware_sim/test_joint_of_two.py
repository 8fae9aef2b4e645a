"""Two motors on one joint, against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest

from firmware_sim.physics import kernel
from firmware_sim.physics.axis import Axes, Axis
from firmware_sim.physics.kernel import STEP
from firmware_sim.physics.motor_data import MotorData
from firmware_sim.physics.plant import JointsPlant
from tests.firmware_sim.one_axis import DATA_SHEETS, TICK

XM430 = DATA_SHEETS["xm430-w350"]
SMOOTH = replace(XM430, friction=0.0)
STALL, CURRENT, VOLTAGE = 4.1, 2.3, 12.0


class Pair:
    """Two axes that turn as one, or opposite ways, beside one alone that is like the first."""

    def __init__(
        self, gear: int = 1, motor: MotorData = SMOOTH, second: MotorData | None = None
    ) -> None:
        self.axes = Axes(3)
        for axis, data in zip(self.axes, (motor, second or motor, motor), strict=True):
            axis.configure(data, TICK, VOLTAGE)
            axis.set_position_gains(4.6)
        self.axes.couple(0, 1, gear)
        self.plant = JointsPlant(self.axes, 0.0)

    @property
    def both(self) -> tuple[Axis, Axis]:
        return self.axes[0], self.axes[1]

    def run(self, duration: float) -> None:
        self.plant.advance(round(duration / STEP))


def figures(axis: Axis) -> tuple[float, float, float]:
    """Inertia, drag, and what the back-EMF takes from a driven motor."""
    row = axis._row
    back = row[kernel.TORQUE_CONSTANT] * row[kernel.BACK_EMF] / row[kernel.RESISTANCE]
    return row[kernel.INERTIA], row[kernel.DRAG], back


@pytest.mark.parametrize("gear", [1, -1])
def test_a_limp_motor_is_one_more_inertia_to_turn(gear: int) -> None:
    """Speed is T / D (1 - exp(-D t / J)), with both inertias and drags, and one back-EMF."""
    pair = Pair(gear, second=replace(DATA_SHEETS["xm540-w270"], friction=0.0))
    driven, limp = pair.both
    driven.drive_duty(0.5)
    pair.run(0.05)
    (j1, d1, back), (j2, d2, _) = figures(driven), figures(limp)
    damping, torque = d1 + d2 + back, 0.5 * STALL
    speed = torque / damping * (1.0 - math.exp(-damping * 0.05 / (j1 + j2)))
    assert driven.velocity == pytest.approx(speed, rel=1e-9)
    assert limp.velocity == pytest.approx(gear * speed, rel=1e-9)
    assert limp.current == 0.0


@pytest.mark.parametrize("gear", [1, -1])
def test_two_that_push_alike_move_as_one_alone(gear: int) -> None:
    """Twice the torque at twice the inertia."""
    pair = Pair(gear, motor=XM430)
    for axis, duty in zip(pair.axes, (0.4, gear * 0.4, 0.4), strict=True):
        axis.drive_duty(duty)
    pair.run(0.2)
    first, second, alone = pair.axes
    assert (first.velocity, first.current) == pytest.approx(
        (alone.velocity, alone.current), rel=1e-9
    )
    assert (second.velocity, second.current) == pytest.approx(
        (gear * alone.velocity, gear * alone.current), rel=1e-9
    )
    assert abs(first.angle) == pytest.approx(abs(second.angle), rel=1e-9)


@pytest.mark.parametrize("gear", [1, -1])
def test_each_carries_half_of_a_load(gear: int) -> None:
    """Under position control: half the current, half the sag, of one that carries it alone."""
    pair = Pair(gear)
    for axis in pair.axes:
        axis.hold()
    pair.axes[0].apply_load(1.0)
    pair.axes[2].apply_load(1.0)
    pair.run(1.0)
    first, second, alone = pair.axes
    count = 4.6 * TICK * CURRENT  # what an encoder count is worth, A
    assert alone.current == pytest.approx(CURRENT * 1.0 / STALL, abs=count)
    assert first.current == pytest.approx(CURRENT * 0.5 / STALL, abs=count)
    assert second.current == pytest.approx(gear * first.current, abs=count)
    assert first.angle == pytest.approx(0.5 * alone.angle, abs=TICK)
    assert second.angle == pytest.approx(gear * first.angle, rel=1e-9)


@pytest.mark.parametrize("gear", [1, -1])
def test_a_motor_that_brakes_is_driven_back(gear: int) -> None:
    """With no duty its winding is closed: i = -ke w / R, against the way it is turned."""
    pair = Pair(gear)
    driver, brake = pair.both
    driver.drive_duty(0.5)
    brake.drive_duty(0.0)
    pair.run(0.5)
    (_, drag, back), row = figures(driver), brake._row
    speed = 0.5 * STALL / (2.0 * (drag + back))
    assert brake.velocity == pytest.approx(gear * speed, rel=1e-6)
    induced = -row[kernel.BACK_EMF] * gear * speed / row[kernel.RESISTANCE]
    assert brake.current == pytest.approx(induced, rel=1e-6)


def test_two_that_push_against_each_other_stand_and_heat() -> None:
    pair = Pair(-1, motor=XM430)
    for axis in pair.both:
        axis.drive_duty(0.8)
    pair.run(5.0)
    for axis in pair.both:
        assert (axis.velocity, axis.angle) == (0.0, 0.0)
        assert axis.current == pytest.approx(0.8 * CURRENT, rel=1e-9)
        assert axis.temperature > kernel.AMBIENT_TEMPERATURE + 1.0


def test_gears_of_two_stick_twice_as_hard() -> None:
    friction = XM430.friction * STALL * kernel.STATIC_FRICTION
    for load, moves in ((1.95, False), (2.05, True)):
        pair = Pair(motor=XM430)
        pair.axes[1].apply_load(load * friction)
        pair.run(0.1)
        assert (pair.axes[0].angle < 0.0) == moves


def test_a_jam_of_one_holds_both() -> None:
    pair = Pair()
    pair.axes[1].jam(on=True)
    pair.axes[0].drive_duty(1.0)
    pair.run(0.5)
    assert pair.axes[0].angle == 0.0
    pair.axes[1].jam(on=False)
    pair.run(0.5)
    assert pair.axes[0].angle > 0.1


def test_angles_that_are_apart_keep_apart() -> None:
    pair = Pair(-1)
    pair.axes[1].configure(SMOOTH, TICK, VOLTAGE, 0.03)
    pair.axes.couple(0, 1, -1)
    pair.axes[0].drive_duty(0.3)
    pair.run(0.4)
    first, second = pair.both
    assert second.angle == pytest.approx(0.03 - first.angle, abs=1e-12)
    assert second.ticks == round(second.angle / TICK)


def test_they_settle_together_and_wake_together() -> None:
    pair = Pair(motor=XM430)
    for axis in pair.axes:
        axis.hold()
    pair.run(0.5)
    assert all(axis.settled for axis in pair.axes)
    pair.axes[1].step_to(0.2)
    assert not pair.axes.settled
    pair.run(1.0)
    assert pair.axes[0].angle == pytest.approx(0.1, abs=0.02)  # between the two goals
    assert pair.axes[0].current == pytest.approx(-pair.axes[1].current, abs=0.3)


def test_chunks_of_time_make_no_difference() -> None:
    angles = []
    for chunks in ([300], [1, 2, 97, 200], [1] * 300):
        pair = Pair(-1, motor=XM430)
        pair.axes[0].drive_duty(0.6)
        pair.axes[1].hold()
        for steps in chunks:
            pair.plant.advance(steps)
        angles.append(pair.axes.state.copy())
    for other in angles[1:]:
        np.testing.assert_array_equal(angles[0], other)
