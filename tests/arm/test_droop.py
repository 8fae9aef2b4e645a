"""Expected droop: loads against a random search, stiffness against the simulator's tables."""

import math
from pathlib import Path

import numpy as np
import pytest

from armsyn.arm import arm_names, gravity_torque, load_arm
from armsyn.arm.droop import expected_droop, stiffness, worst_loads
from armsyn.arm.motors import MOTORS, position_stiffness
from armsyn.errors import InputError
from firmware_sim.tables import find_model

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"
ARMS = [name for name in arm_names(CALIBRATION) if load_arm(name, CALIBRATION).servo]


@pytest.mark.parametrize("name", ARMS)
def test_no_posture_is_heavier_than_the_worst(name: str) -> None:
    arm = load_arm(name, CALIBRATION)
    loads = worst_loads(arm)
    for joint, load in enumerate(loads):
        assert (arm.chain.lower <= load.posture).all()
        assert (load.posture <= arm.chain.upper).all()
        assert gravity_torque(arm, load.posture)[joint] == pytest.approx(load.torque, abs=1e-9)
    generator = np.random.default_rng(6)
    postures = generator.uniform(arm.chain.lower, arm.chain.upper, size=(1000, arm.chain.dof))
    found = np.abs([gravity_torque(arm, q) for q in postures]).max(axis=0)
    worst = np.abs([load.torque for load in loads])
    assert (found <= worst * 1.001 + 1e-9).all()


def test_human7_stretched_out_is_its_shoulders_worst() -> None:
    """All of the arm straight and level: masses times distances (tests/arm/test_gravity.py)."""
    arm = load_arm("human7", CALIBRATION)
    level = 9.80665 * (
        0.21 * 0.05 + 0.245 * 0.245 + 0.11 * 0.34 + 0.13 * 0.50 + 0.10 * 0.58 + 0.08 * 0.61
        + 0.03 * 0.66
    )  # fmt: skip
    assert abs(worst_loads(arm)[0].torque) == pytest.approx(level, rel=1e-3)
    # XM540-W270: 800 / 128 counts a tick of 2 pi / 4096, 885 counts are 10.6 N m
    spring = 800 / 128 / 885 * 10.6 / (2 * np.pi / 4096)
    assert expected_droop(arm)[0] == pytest.approx(level / spring, rel=1e-3)


def test_two_motors_on_a_joint_are_twice_as_stiff() -> None:
    arm = load_arm("widowx_250s", CALIBRATION)
    found = stiffness(arm)
    assert found[1] == pytest.approx(2 * found[0])
    assert found[2] == pytest.approx(2 * found[3])


def test_a_lower_supply_is_less_stiff() -> None:
    assert position_stiffness("xm430-w350", 2, 9.0) == pytest.approx(
        0.75 * position_stiffness("xm430-w350", 2, 12.0)
    )


def test_unknown_loops_are_not_guessed() -> None:
    assert math.isnan(position_stiffness("xl-320", 2, 7.4))
    assert math.isnan(position_stiffness("mx-64", 1, 12.0))
    assert np.isnan(stiffness(load_arm("hug_mp4", CALIBRATION))).all()
    with pytest.raises(InputError, match="has no mass"):
        expected_droop(load_arm("hug_mp4", CALIBRATION))


@pytest.mark.parametrize(("name", "protocol"), MOTORS)
def test_the_table_is_the_simulators(name: str, protocol: int) -> None:
    """Two tables written apart from the same manual."""
    model = find_model(name, protocol=protocol)
    motor = MOTORS[name, protocol]
    assert (motor.stall_torque, motor.voltage) == (
        model.motor.stall_torque,
        model.motor.nominal_voltage,
    )
    if motor.p_gain is not None:
        assert model.table.by_name["Position P Gain"].default == motor.p_gain
    else:
        assert model.table.by_name["CW Compliance Slope"].default == 32
