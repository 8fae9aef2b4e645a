"""Hands, obstacles, shadows and grippers where the arm's bodies are simulated."""

import math
from pathlib import Path

import numpy as np
import pytest

from firmware_sim.errors import PlantError
from firmware_sim.physics import kernel
from firmware_sim.physics.mujoco import MujocoPlant
from firmware_sim.testing import SteppedPort, stepped
from tests.firmware_sim.mujoco_arms import (
    GRAVITY,
    MOTOR,
    PENDULUM,
    TICK,
    WEIGHT,
    make_axes,
    pendulum,
    seconds,
)

TORQUE, GOAL_CURRENT, GOAL, POSITION, CURRENT = 64, 102, 116, 132, 126

RIG = f"""
[[servo]]
id = 1
model = "xm430-w350"
joint = "hinge"
start_tick = 1024   # hangs

[[servo]]
id = 2
model = "xm430-w350"
shadow_of = 1
drive_mode = 1
start_tick = 1030   # mounted six ticks further

[[servo]]
id = 3
model = "xl330-m288"
joint = "gripper"
registers = {{ "Operating Mode" = 5 }}

[plant]
mjcf = '''{PENDULUM.format(gravity=-GRAVITY)}'''
"""


def arm() -> SteppedPort:
    return stepped(rig=RIG, mujoco=True)


def value(port: SteppedPort, number: int, address: int, size: int) -> int:
    _, data = port.bus.servos[number].read(address, size)
    return int.from_bytes(data, "little", signed=True)


def put(port: SteppedPort, number: int, address: int, size: int, what: int) -> None:
    assert not port.bus.servos[number].write(address, what.to_bytes(size, "little"))


def let(port: SteppedPort, duration: float) -> None:
    port.wait_until(port.clock.now() + duration)
    port.simulation.advance(port.clock.now())


def test_a_hand_lifts_a_limp_arm_holds_it_and_lets_it_fall() -> None:
    """Held, the hand's pull is what gravity takes; friction of the gears helps it a little."""
    axis, plant = pendulum(-math.pi / 2)
    axis.take_hand(0.0, 1.0, 3.0)
    plant.advance(seconds(4.0))
    row = axis._row
    assert axis.angle == pytest.approx(0.0, abs=2 * TICK)
    pull = row[kernel.HAND_GRIP] * row[kernel.HAND_RATE]
    assert pull == pytest.approx(WEIGHT, abs=1.5 * MOTOR.friction * MOTOR.stall_torque)
    assert plant.axes.settled
    axis.let_go()
    plant.advance(seconds(0.5))
    assert axis.angle < -0.5


def test_a_weak_hand_cannot_lift_it() -> None:
    """Up to where m g l cos(angle) is its torque, with friction either way."""
    axis, plant = pendulum(-math.pi / 2)
    axis.take_hand(0.0, 0.5, 0.5)
    plant.advance(seconds(6.0))
    friction = kernel.STATIC_FRICTION * MOTOR.friction * MOTOR.stall_torque
    assert WEIGHT * math.cos(axis.angle) == pytest.approx(0.5, abs=friction + 0.01)


@pytest.mark.parametrize("direction", [1, -1])
def test_an_obstacle_stops_a_falling_arm_and_is_taken_away(direction: int) -> None:
    axes = make_axes([0.5 * direction])
    plant = MujocoPlant(
        axes, PENDULUM.format(gravity=-GRAVITY), ["hinge"], [direction], supply_resistance=0.0
    )
    stop = -0.3 * direction
    axes[0].block(low=stop) if direction > 0 else axes[0].block(high=stop)
    plant.advance(seconds(3.0))
    assert axes[0].angle == pytest.approx(stop, abs=TICK)
    assert axes[0].velocity == pytest.approx(0.0, abs=1e-3)
    axes[0].unblock()
    plant.advance(seconds(6.0))
    assert axes[0].angle == pytest.approx(-math.pi / 2 * direction, abs=0.05)


def test_an_obstacle_leaves_the_joints_own_range() -> None:
    mjcf = PENDULUM.format(gravity=-GRAVITY).replace('"hinge"', '"hinge" range="-1 2"')
    axes = make_axes([0.5])
    plant = MujocoPlant(axes, mjcf, ["hinge"], supply_resistance=0.0)
    axes[0].block(low=-1.3)
    plant.advance(seconds(3.0))
    assert axes[0].angle == pytest.approx(-1.0, abs=0.01)


def test_a_shadow_shares_the_weight() -> None:
    port = arm()
    assert port.hands.turn({1: 2048}, keep=True)
    assert value(port, 1, POSITION, 4) == pytest.approx(value(port, 0, POSITION, 4) + 6, abs=1)
    for number, tick in ((0, 2048), (1, 2054)):
        put(port, number, TORQUE, 1, 1)
        put(port, number, GOAL, 4, tick)
    port.simulation.clear("hand")
    let(port, 2.0)
    currents = np.array([value(port, number, CURRENT, 2) for number in (0, 1)]) * 0.00269
    half = WEIGHT / 2 / 4.1 * 2.3
    assert currents == pytest.approx([half, half], abs=0.05 * 2.3 / 4.1 + 0.02)
    assert value(port, 0, POSITION, 4) > 2025


def test_a_gripper_that_the_bodies_do_not_have_grips_an_object() -> None:
    port = arm()
    port.simulation.inject("obstacle:id=3,tick=2500")
    put(port, 2, TORQUE, 1, 1)
    put(port, 2, GOAL_CURRENT, 2, 150)
    put(port, 2, GOAL, 4, 3000)
    let(port, 2.0)
    assert value(port, 2, POSITION, 4) == pytest.approx(2500, abs=1)
    assert value(port, 2, CURRENT, 2) == pytest.approx(150, abs=3)
    port.simulation.clear()
    let(port, 2.0)
    assert value(port, 2, POSITION, 4) == pytest.approx(3000, abs=6)
    assert value(port, 0, POSITION, 4) == pytest.approx(1024, abs=2)  # the arm hangs


def test_other_joints_that_the_bodies_do_not_have_are_refused() -> None:
    with pytest.raises(PlantError, match="has no joint 'gripper'; its joints are hinge"):
        stepped(rig=RIG + '[gripper]\nname = "jaw"\n', mujoco=True)
    named = RIG.replace('joint = "gripper"', 'joint = "jaw"') + '[gripper]\nname = "jaw"\n'
    assert stepped(rig=named, mujoco=True)


def test_a_gripper_of_two_servos_is_one_joint(tmp_path: Path) -> None:
    fourth = '[[servo]]\nid = 4\nmodel = "xl330-m288"\nshadow_of = 3\ndrive_mode = 1\n[plant]'
    path = tmp_path / "rig.toml"
    path.write_text(RIG.replace("[plant]", fourth))
    port = stepped(rig=path, mujoco=True)
    assert port.hands.turn({3: 2600})
    assert value(port, 3, POSITION, 4) == pytest.approx(2600, abs=2)
