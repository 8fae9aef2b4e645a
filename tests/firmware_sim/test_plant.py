"""Many axes at once: their supply, chunks of time, compiled and plain code, other mechanics."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.physics import kernel
from firmware_sim.physics.axis import Axes
from firmware_sim.physics.kernel import STEP
from firmware_sim.physics.plant import JointsPlant, make_supplies
from firmware_sim.physics.profile import velocity_profile

from .one_axis import DATA_SHEETS, TICK

MOTORS = list(DATA_SHEETS.values())


def busy_axes(count: int = 7) -> Axes:
    """One axis in each mode of control, at motors of all kinds."""
    axes = Axes(count)
    for number, axis in enumerate(axes):
        axis.configure(MOTORS[number % len(MOTORS)], TICK, 12.0, 0.1 * number)
        axis.set_position_gains(4.6, 0.02, 1.0, 0.05, 0.001)
        axis.set_velocity_gains(0.3, 0.01)
        axis.apply_load(0.05 * number)
    axes[0].follow(velocity_profile(0.0, 0.0, 2.0, 3.0, 8.0))
    axes[1].drive_velocity(2.0, 10.0)
    axes[2].drive_current(0.4)
    axes[3].drive_duty(0.5)
    goal = velocity_profile(0.4, 0.0, -1.0, 4.0, 0.0)
    axes[4].drive_compliance(goal, (0.01, 0.02), (2.0, 3.0), 0.03)
    axes[5].set_caps(0.9, 0.5)
    axes[5].follow(velocity_profile(0.5, 0.0, -1.0, 0.0, 0.0))
    return axes


def test_two_loaded_servos_share_the_sag_of_their_supply() -> None:
    """V = E / (1 + Rs sum of u^2 / R), and the supply gives what the windings take."""
    axes = Axes(2)
    duties = (1.0, -0.5)
    for axis, duty in zip(axes, duties, strict=True):
        axis.configure(DATA_SHEETS["xm540-w270"], TICK, 12.0)
        axis.jam(on=True)
        axis.drive_duty(duty)
    JointsPlant(axes, 0.3).advance(5)
    winding = 12.0 / 4.4
    voltage = 12.0 / (1.0 + 0.3 * sum(duty**2 for duty in duties) / winding)
    drawn = 0.0
    for axis, duty in zip(axes, duties, strict=True):
        assert axis.voltage == pytest.approx(voltage, rel=1e-12)
        assert axis.current == pytest.approx(duty * voltage / winding, rel=1e-12)
        drawn += duty * axis.current
    assert voltage == pytest.approx(12.0 - 0.3 * drawn, rel=1e-12)
    assert 1.0 < 12.0 - voltage < 1.8


def test_a_running_motor_draws_what_its_back_emf_leaves() -> None:
    axes = Axes(1)
    axes[0].configure(DATA_SHEETS["xm430-w350"], TICK, 12.0)
    axes[0].drive_duty(0.8)
    JointsPlant(axes, 2.0).advance(2000)
    assert axes[0].voltage == pytest.approx(12.0 - 2.0 * 0.8 * axes[0].current, rel=1e-9)
    assert 0.01 < axes[0].current < 0.2


def test_supplies_are_apart() -> None:
    axes = Axes(3)
    for number, axis in enumerate(axes):
        axis.configure(DATA_SHEETS["xm430-w350"], TICK, 12.0, supply=number // 2)
    axes[0].jam(on=True)
    axes[0].drive_duty(1.0)
    JointsPlant(axes, [0.2, 0.2]).advance(1)
    assert axes[0].voltage == axes[1].voltage < 12.0
    assert axes[2].voltage == 12.0


def test_many_stalled_servos_pull_their_supply_down_but_not_below_nothing() -> None:
    axes = Axes(253)
    for axis in axes:
        axis.configure(DATA_SHEETS["xm540-w270"], TICK, 12.0)
        axis.jam(on=True)
        axis.drive_current(4.0)
    plant = JointsPlant(axes, 0.05)
    plant.advance(200)
    assert 0.0 < axes[0].voltage < 3.0
    assert axes[0].duty == 1.0
    assert len({axis.voltage for axis in axes}) == 1


def test_a_standing_servo_slips_when_its_supply_sags() -> None:
    """It had settled, so that its loop rested; its gears must still be looked at."""
    axes = Axes(2)
    for axis in axes:
        axis.configure(DATA_SHEETS["xm430-w350"], TICK, 12.0)
    axes[0].set_position_gains(4.6)
    axes[0].hold()
    axes[0].apply_load(2.0)
    plant = JointsPlant(axes, 1.0)
    plant.advance(3000)
    assert all(axis.settled for axis in axes)
    before = axes[0].angle
    axes[1].jam(on=True)
    axes[1].drive_duty(1.0)
    plant.advance(3000)
    sagged = axes[0].angle
    assert axes[0].voltage < 11.0
    assert sagged < before - TICK
    torque = axes[0].current / 2.3 * 4.1
    assert torque == pytest.approx(2.0, abs=1.2 * 0.041)


def test_a_standing_current_stays_when_its_supply_sags() -> None:
    axes = Axes(2)
    for axis in axes:
        axis.configure(DATA_SHEETS["xm430-w350"], TICK, 12.0)
        axis.jam(on=True)
    axes[0].drive_current(0.5)
    plant = JointsPlant(axes, 1.0)
    plant.advance(100)
    assert axes.settled
    assert axes[0].current == pytest.approx(0.5, rel=1e-9)
    axes[1].drive_duty(0.9)
    assert not axes.settled
    plant.advance(100)
    assert axes[0].voltage < 11.0
    assert axes[0].current == pytest.approx(0.5, rel=1e-9)


@given(st.lists(st.integers(1, 60), min_size=1, max_size=12))
def test_any_chunks_of_time_come_to_the_same(chunks: list[int]) -> None:
    whole, cut = busy_axes(), busy_axes()
    JointsPlant(whole).advance(sum(chunks))
    plant = JointsPlant(cut)
    for chunk in chunks:
        plant.advance(chunk)
    assert np.array_equal(whole.state, cut.state)


def test_seven_steps_are_seven_times_one_also_at_rest() -> None:
    """The closed form of heat at rest is the sum of its steps but for rounding."""
    whole, cut = Axes(1), Axes(1)
    plants = [JointsPlant(whole), JointsPlant(cut)]
    for axes in (whole, cut):
        axes[0].configure(MOTORS[0], TICK, 12.0)
        axes[0].jam(on=True)
        axes[0].drive_duty(1.0)
    for _ in range(1000):
        plants[0].advance(7)
        for _ in range(7):
            plants[1].advance(1)
    assert whole.column(kernel.SETTLED)[0]
    assert not whole[0].settled  # its firmware may yet give up
    assert np.allclose(whole.state, cut.state, rtol=1e-11, atol=0.0)
    assert whole[0].saturated_for == pytest.approx(7.0)


_PLAIN = """
import json, sys
from tests.firmware_sim.test_plant import busy_axes
from firmware_sim.physics.plant import JointsPlant
axes = busy_axes()
JointsPlant(axes).advance(400)
json.dump([[float(x).hex() for x in row] for row in axes.state], sys.stdout)
"""


def test_compiled_code_does_what_the_plain_functions_do() -> None:
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    answer = subprocess.run(
        [sys.executable, "-c", _PLAIN],
        env=environment,
        cwd=Path(__file__).parents[2],
        capture_output=True,
        check=True,
        timeout=120,
    )
    plain = [[float.fromhex(x) for x in row] for row in json.loads(answer.stdout)]
    axes = busy_axes()
    JointsPlant(axes).advance(400)
    assert np.allclose(axes.state, plain, rtol=1e-9, atol=1e-12)


def test_other_mechanics_get_the_same_joints_out_of_the_loops() -> None:
    """Exact exponentials in numpy for the mechanics; loads well over friction, none reverses."""
    ours, theirs = Axes(2), Axes(2)
    for axes in (ours, theirs):
        for axis, duty in zip(axes, (0.8, -0.6), strict=True):
            axis.configure(DATA_SHEETS["xm430-w350"], TICK, 12.0)
            axis.drive_duty(duty)
            axis.apply_load(math.copysign(0.5, duty))
    JointsPlant(ours, 0.1).advance(50)
    supplies, torques, dampings = make_supplies([0.1]), np.zeros(2), np.zeros(2)
    angles, speeds = np.zeros(2), np.zeros(2)
    for _ in range(50):
        kernel.drive(theirs.state, supplies, torques, dampings)
        friction = theirs.column(kernel.FRICTION) * np.sign(torques)
        final = (torques - friction - theirs.column(kernel.LOAD)) / dampings
        lag = theirs.column(kernel.INERTIA) / dampings
        gone = (speeds - final) * (1.0 - np.exp(-STEP / lag))
        angles = angles + final * STEP + gone * lag
        speeds = speeds - gone
        kernel.observe(theirs.state, angles, speeds)
    same = [kernel.ANGLE, kernel.SPEED, kernel.AMPERES, kernel.VOLTAGE, kernel.TEMPERATURE]
    assert np.allclose(ours.state[:, same], theirs.state[:, same], rtol=1e-9)
    assert ours[0].ticks == theirs[0].ticks > 0
