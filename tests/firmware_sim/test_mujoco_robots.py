"""The arms of the house on their servos: written by armsyn, moved by the simulator."""

import tomllib
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from armsyn.arm import ArmDescription, load_arm
from armsyn.arm.rig import build_rig
from firmware_sim.physics.axis import Axes
from firmware_sim.physics.mujoco import MujocoPlant
from firmware_sim.tables import find_model
from tests.firmware_sim.mujoco_arms import P_GAIN, TICK, seconds

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"


def on_servos(arm: ArmDescription, posture: np.ndarray) -> tuple[Axes, MujocoPlant, np.ndarray]:
    """The arm's rig in a posture, as a simulation would set it up; and its stiffness, N m/rad."""
    document = tomllib.loads(build_rig(arm))
    axes = Axes(len(posture))
    stiffness = []
    servos = document["servo"][: len(posture)]  # without the gripper's
    for axis, servo, angle in zip(axes, servos, posture, strict=True):
        motor = find_model(servo["model"]).motor
        zero = servo["zero_tick"] * TICK
        start = zero + TICK * round(servo["direction"] * angle / TICK)
        axis.configure(motor, TICK, servo["supply_voltage"], start)
        axis.set_position_gains(P_GAIN)
        stiffness.append(P_GAIN * motor.stall_torque)
    plant = MujocoPlant(
        axes,
        document["plant"]["mjcf"],
        [servo["joint"] for servo in servos],
        [servo["direction"] for servo in servos],
        [servo["zero_tick"] * TICK for servo in servos],
        supply_resistance=0.0,
    )
    return axes, plant, np.array(stiffness)


def gravity_torques(arm: ArmDescription, angles: np.ndarray) -> np.ndarray:
    """Pinocchio's, of the links as the description has them."""
    model, parent = pin.Model(), 0
    model.gravity.linear = np.array(arm.gravity)
    for joint in arm.joint:
        place = pin.SE3(pin.rpy.rpyToMatrix(*joint.rpy), np.array(joint.xyz))
        kind = pin.JointModelRevoluteUnaligned(np.array(joint.axis))
        parent = model.addJoint(parent, kind, place, joint.name)
        assert joint.link is not None
        body = pin.Inertia(joint.link.mass, np.array(joint.link.centre_of_mass), np.eye(3))
        model.appendBodyToJoint(parent, body, pin.SE3.Identity())
    tip = pin.SE3(pin.rpy.rpyToMatrix(*arm.tip.rpy), np.array(arm.tip.xyz))
    model.appendBodyToJoint(parent, pin.Inertia(arm.tip.mass, np.zeros(3), np.eye(3)), tip)
    return np.array(pin.computeGeneralizedGravity(model, model.createData(), angles))


POSTURES = {
    "human7": [1.5, 0.1, 0.0, 0.3, 0.0, 0.0, 0.0],
    "koch": [0.0, 0.0, 0.0, 0.0, 0.0],
    "openmanipulator_x": [0.0, 0.6, -0.6, 0.0],
}


@pytest.mark.parametrize("name", POSTURES)
def test_every_joint_sags_by_its_gravity_over_its_stiffness(name: str) -> None:
    """At the sagged posture, within friction (1.2 x 1 % of the stall torque) and one count."""
    arm = load_arm(name, CALIBRATION)
    axes, plant, stiffness = on_servos(arm, np.array(POSTURES[name]))
    wanted = np.array([axis.angle for axis in axes])
    for axis in axes:
        axis.hold()
    plant.advance(seconds(4.0))
    assert all(axis.settled for axis in axes)
    found = np.array([axis.angle for axis in axes])
    sag = found - wanted
    needed = gravity_torques(arm, arm.calibration.to_radians(found / TICK))
    by_hand = -arm.calibration.direction * needed / stiffness
    band = 1.2 * 0.01 / P_GAIN + TICK
    assert np.abs(sag - by_hand).max() < band
    assert np.abs(by_hand).max() > 5 * band


def test_human7_loses_its_hand_by_what_the_loads_say() -> None:
    """Stretched out forward: about 3.4 degrees at the shoulder and 4 cm at the hand."""
    arm = load_arm("human7", CALIBRATION)
    posture = np.array([np.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    axes, plant, _ = on_servos(arm, posture)
    for axis in axes:
        axis.hold()
    plant.advance(seconds(4.0))
    found = arm.calibration.to_radians([axis.angle / TICK for axis in axes])
    drop = arm.chain.forward(posture).tip[2] - arm.chain.forward(found).tip[2]
    assert np.degrees(posture[0] - found[0]) == pytest.approx(3.3, abs=0.4)
    assert drop == pytest.approx(0.045, abs=0.01)


def test_a_raised_arm_falls_as_its_torque_drops_and_ends_at_its_limits_or_hanging() -> None:
    arm = load_arm("human7", CALIBRATION)
    axes, plant, _ = on_servos(arm, np.array(POSTURES["human7"]))
    for axis in axes:
        axis.hold()
    plant.advance(seconds(1.0))
    for axis in axes:
        axis.release()
    plant.advance(seconds(0.2))
    on_the_way = arm.calibration.to_radians([axis.angle / TICK for axis in axes])
    plant.advance(seconds(6.0))
    found = arm.calibration.to_radians([axis.angle / TICK for axis in axes])
    assert found[0] < on_the_way[0] < 1.4
    assert abs(found[0]) < 0.3
    assert (found > arm.chain.lower - 0.02).all()
    assert (found < arm.chain.upper + 0.02).all()
    assert arm.chain.forward(found).tip[2] < -0.6
    assert all(axis.current == 0.0 for axis in axes)
