"""The arm as rigid bodies, against closed forms, fine integration and independent joints."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipk

from firmware_sim.physics import kernel
from firmware_sim.physics.motor_data import MotorData
from firmware_sim.physics.mujoco import MujocoPlant
from firmware_sim.physics.plant import JointsPlant
from firmware_sim.physics.profile import velocity_profile
from tests.firmware_sim.mujoco_arms import (
    LINK_INERTIA,
    MOTOR,
    P_GAIN,
    PENDULUM,
    STIFFNESS,
    TICK,
    WEIGHT,
    frictionless,
    make_axes,
    pendulum,
    seconds,
)

FRICTION_BAND = kernel.STATIC_FRICTION * MOTOR.friction * MOTOR.stall_torque / STIFFNESS
"""Within which friction holds a joint that its position loop would move, rad."""


@pytest.mark.parametrize("start", [0.0, 0.6, -0.9, math.pi / 2, 2.5])
def test_a_raised_arm_sags_by_torque_over_stiffness(start: float) -> None:
    """STIFFNESS x = m g l cos(start - x), within friction and one encoder count."""
    start = TICK * round(start / TICK)
    axis, plant = pendulum(start)
    axis.hold()
    plant.advance(seconds(3.0))
    sag = brentq(lambda x: STIFFNESS * x - WEIGHT * math.cos(start - x), -0.2, 0.2)
    assert start - axis.angle == pytest.approx(sag, abs=FRICTION_BAND + TICK)
    if start == 0.0:
        assert sag > 0.03  # the sag by hand stands well above the tolerance
        assert 0.2 * sag > FRICTION_BAND + TICK


def test_an_integral_gain_lifts_it_back_however_slowly() -> None:
    """A count of error adds 2e-6 of duty a step: standing must not be taken for the end."""
    axis, plant = pendulum(0.0)
    axis.set_position_gains(P_GAIN, 100 / 65536 / 885 / TICK)
    axis.hold()
    plant.advance(seconds(0.5))
    assert axis.angle < -0.01
    plant.advance(seconds(60.0))
    assert abs(axis.ticks) <= 1


def test_the_current_is_what_the_weight_asks_for() -> None:
    axis, plant = pendulum(0.0)
    axis.hold()
    plant.advance(seconds(3.0))
    held = axis.current * MOTOR.stall_torque / MOTOR.stall_current
    friction = kernel.STATIC_FRICTION * MOTOR.friction * MOTOR.stall_torque
    assert held == pytest.approx(WEIGHT * math.cos(axis.angle), abs=friction)
    assert axis.duty == pytest.approx(axis.current / MOTOR.stall_current, rel=1e-6)


def test_a_fall_without_losses_takes_the_pendulums_time_and_energy() -> None:
    """A quarter of the period, sqrt(I / m g l) K(sin^2(a/2)), from an amplitude a of 90 degrees."""
    axis, plant = pendulum(0.0)
    frictionless(axis, plant)
    inertia = LINK_INERTIA + MOTOR.inertia
    quarter = math.sqrt(inertia / WEIGHT) * ellipk(math.sin(math.pi / 4) ** 2)
    fastest = math.sqrt(2.0 * WEIGHT / inertia)
    steps, before = 0, 0.0
    while axis.angle > -math.pi / 2:
        before = axis.angle
        plant.advance(1)
        steps += 1
    overshot = (-math.pi / 2 - axis.angle) / (before - axis.angle)
    assert (steps - overshot) * kernel.STEP == pytest.approx(quarter, rel=0.005)
    assert axis.velocity == pytest.approx(-fastest, rel=0.005)
    plant.advance(seconds(3 * quarter))  # up to the other side, and half the way back
    energy = 0.5 * inertia * axis.velocity**2 + WEIGHT * math.sin(axis.angle)
    assert energy == pytest.approx(0.0, abs=0.01 * WEIGHT)


def test_a_fall_with_losses_against_fine_integration() -> None:
    axis, plant = pendulum(0.4)
    axis.hold()
    plant.advance(seconds(2.0))
    held = axis.angle
    axis.release()
    start = axis.angle
    inertia = LINK_INERTIA + MOTOR.inertia
    drag = MOTOR.drag * MOTOR.stall_torque / (MOTOR.no_load_speed * 2.0 * math.pi / 60.0)
    friction = MOTOR.friction * MOTOR.stall_torque

    def move(_: float, y: np.ndarray) -> list[float]:
        torque = -WEIGHT * math.cos(y[0]) - drag * y[1]
        return [y[1], (torque - math.copysign(friction, y[1] or torque)) / inertia]

    fall = solve_ivp(move, (0.0, 0.5), [start, 0.0], rtol=1e-9, max_step=1e-3, dense_output=True)
    for time in np.arange(0.05, 0.501, 0.05):
        plant.advance(50)
        angle, speed = fall.sol(time)
        assert axis.angle == pytest.approx(angle, abs=0.01)
        assert axis.velocity == pytest.approx(speed, abs=0.05)
    assert abs(held - 0.4) < 0.06
    assert axis.angle < -0.7
    assert axis.current == 0.0


def test_a_push_beyond_the_stall_torque_overloads() -> None:
    """It gives way until the weight helps: push = stall torque + m g l sin(way)."""
    start = TICK * round(-math.pi / 2 / TICK)
    axis, plant = pendulum(start)
    axis.hold()
    plant.advance(seconds(1.0))
    axis.apply_load(0.5 * MOTOR.stall_torque)
    plant.advance(seconds(2.0))
    assert axis.saturated_for == 0.0
    push = 1.15 * MOTOR.stall_torque
    axis.apply_load(push)
    plant.advance(seconds(10.0))
    assert axis.saturated_for > 1.0
    assert axis.duty == 1.0
    assert axis.current == pytest.approx(MOTOR.stall_current, rel=1e-3)
    helps = WEIGHT * math.sin(start - axis.angle)
    friction = kernel.STATIC_FRICTION * MOTOR.friction * MOTOR.stall_torque
    assert push == pytest.approx(MOTOR.stall_torque + helps, abs=friction)
    before = axis.saturated_for
    plant.advance(seconds(1.0))
    assert axis.saturated_for == pytest.approx(before + 1.0)


def test_a_weight_beyond_the_stall_torque_overloads() -> None:
    """Ten times the gravity, 9.8 N m against a stall torque of 4: it gives way until it can."""
    axis, plant = pendulum(-0.3, gravity=98.0665)
    axis.hold()
    plant.advance(seconds(4.0))
    assert axis.saturated_for > 1.0
    assert axis.duty == 1.0
    # where m g l cos(angle) is the stall torque, give or take friction
    assert 10.0 * WEIGHT * math.cos(axis.angle) == pytest.approx(MOTOR.stall_torque, rel=0.02)


def test_friction_holds_what_it_can_without_creeping() -> None:
    """Hanging 1.5 degrees aside: 0.026 N m against a static friction of 0.048."""
    axis, plant = pendulum(-math.pi / 2 + 0.026)
    start = axis.angle
    plant.advance(seconds(20.0))
    assert abs(axis.angle - start) < 1e-4
    axis.set_friction(0.2)
    plant.advance(seconds(2.0))
    assert axis.angle < start - 0.01


def test_without_weight_it_moves_as_an_independent_joint() -> None:
    """A profile, a step, a push and a release: within 2 ms of the exact steps' trajectories."""
    light = PENDULUM.format(gravity=0.0).replace("0.5", "1e-9").replace("0.001 " * 3, "1e-9 " * 3)
    light = light.replace('"0.001 0.001 0.001"', '"1e-9 1e-9 1e-9"')
    axes, plain = make_axes([0.0]), make_axes([0.0])
    arm = MujocoPlant(axes, light, ["hinge"], supply_resistance=0.0)
    joint = JointsPlant(plain, 0.0)
    apart, fastest = 0.0, 0.0
    for step in range(2500):
        for axis in (axes[0], plain[0]):
            if step == 10:
                axis.follow(velocity_profile(axis.angle, 0.0, 1.0, 2.0, 10.0))
            elif step == 900:
                axis.follow(velocity_profile(axis.angle, 0.0, 0.5, 0.0, 0.0))
            elif step == 1500:
                axis.apply_load(1.0)
            elif step == 2000:
                axis.release()
        arm.advance(1)
        joint.advance(1)
        apart = max(apart, abs(axes[0].angle - plain[0].angle))
        fastest = max(fastest, abs(plain[0].velocity))
    assert fastest > 3.0
    assert apart < 0.002 * fastest
    assert plain[0].angle < 0.3  # the push did turn it


@pytest.mark.parametrize("direction", [1, -1])
def test_direction_and_zero_only_change_how_angles_are_counted(direction: int) -> None:
    zero = 1.25
    axes = make_axes([zero + direction * 0.3])
    plant = MujocoPlant(
        axes, PENDULUM.format(gravity=-9.8), ["hinge"], [direction], [zero], supply_resistance=0.0
    )
    plant.advance(seconds(0.3))
    straight = make_axes([0.3])
    other = MujocoPlant(straight, PENDULUM.format(gravity=-9.8), ["hinge"], supply_resistance=0.0)
    other.advance(seconds(0.3))
    assert straight[0].angle < 0.1
    assert axes[0].angle == pytest.approx(zero + direction * straight[0].angle, abs=1e-12)
    assert axes[0].velocity == pytest.approx(direction * straight[0].velocity, abs=1e-12)


def test_two_servos_on_one_joint_share_its_weight() -> None:
    """The second sits mirrored: the sag is half of one servo's."""
    axes = make_axes([0.0, 2.0])
    plant = MujocoPlant(
        axes,
        PENDULUM.format(gravity=-9.80665),
        ["hinge", "hinge"],
        [1, -1],
        [0.0, 2.0],
        supply_resistance=0.0,
    )
    for axis in axes:
        axis.hold()
    plant.advance(seconds(3.0))
    sag = brentq(lambda x: 2.0 * STIFFNESS * x - WEIGHT * math.cos(x), 0.0, 0.2)
    assert -axes[0].angle == pytest.approx(sag, abs=FRICTION_BAND + TICK)
    assert axes[1].angle - 2.0 == pytest.approx(-axes[0].angle, abs=1e-9)
    assert axes[0].current == pytest.approx(-axes[1].current, rel=0.1)


def test_a_servo_outside_the_arm_feels_nothing_of_it() -> None:
    axes, plain = make_axes([0.5, 0.0]), make_axes([0.0])
    plant = MujocoPlant(axes, PENDULUM.format(gravity=-9.8), ["hinge", None], supply_resistance=0.0)
    joint = JointsPlant(plain, 0.0)
    for axis in (axes[1], plain[0]):
        axis.hold()
        axis.follow(velocity_profile(0.0, 0.0, 1.0, 2.0, 10.0))
    for _ in range(100):
        plant.advance(10)
        joint.advance(10)
        assert axes[1].angle == pytest.approx(plain[0].angle, abs=0.004)
    assert axes[0].angle < -1.0  # while the arm fell
    assert axes[1].angle == pytest.approx(1.0, abs=0.01)


def test_an_arm_at_rest_settles_and_wakes() -> None:
    axis, plant = pendulum(0.3)
    axis.hold()
    plant.advance(seconds(3.0))
    assert axis.settled
    angle, warmth = axis.angle, axis.temperature
    plant.advance(seconds(60.0))
    assert axis.angle == angle
    assert axis.temperature > warmth + 0.01
    axis.follow(velocity_profile(0.3, 0.0, 0.8, 1.0, 5.0))
    plant.advance(1)
    assert not axis.settled
    plant.advance(seconds(3.0))
    assert axis.angle == pytest.approx(0.8, abs=0.06)


def test_an_axis_put_elsewhere_takes_its_joint_along() -> None:
    axis, plant = pendulum(0.3)
    axis.configure(MOTOR, TICK, 12.0, -math.pi / 2)
    plant.advance(seconds(1.0))
    assert axis.angle == pytest.approx(-math.pi / 2, abs=0.001)


def test_the_same_commands_give_the_same_state() -> None:
    states = []
    for _ in range(2):
        axis, plant = pendulum(0.3)
        axis.hold()
        axis.follow(velocity_profile(0.3, 0.0, 1.0, 2.0, 10.0))
        plant.advance(700)
        axis.release()
        plant.advance(200)
        states.append(plant.axes.state.tobytes())
    assert states[0] == states[1]


def test_losses_of_a_supply_are_those_of_independent_joints() -> None:
    motor = MotorData(12.0, 4.0, 2.0, 46.0, 0.008, friction=0.0)
    axes, plain = make_axes([0.0], motor), make_axes([0.0], motor)
    arm = MujocoPlant(axes, PENDULUM.format(gravity=0.0), ["hinge"], supply_resistance=0.5)
    joint = JointsPlant(plain, 0.5)
    for axis in (axes[0], plain[0]):
        axis.jam(True)
        axis.drive_duty(1.0)
    arm.advance(50)
    joint.advance(50)
    assert plain[0].voltage == pytest.approx(12.0 * 6.0 / 6.5)
    assert axes[0].voltage == pytest.approx(plain[0].voltage, abs=1e-3)
