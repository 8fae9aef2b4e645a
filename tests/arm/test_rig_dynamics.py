"""The MJCF's dynamics against Pinocchio's, on models built apart from the same description."""

from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from armsyn.arm import arm_names, load_arm
from armsyn.arm.mjcf import build_mjcf
from tests.arm.models import pinocchio_model

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"
ARMS = [name for name in arm_names(CALIBRATION) if load_arm(name, CALIBRATION).servo]


@pytest.mark.parametrize("name", ARMS)
def test_gravity_and_inverse_dynamics(name: str) -> None:
    arm = load_arm(name, CALIBRATION)
    oracle = pinocchio_model(arm)
    oracle_data = oracle.createData()
    model = mujoco.MjModel.from_xml_string(build_mjcf(arm))
    # Pinocchio's arm neither ends at its limits nor lies on the table
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    generator = np.random.default_rng(2)
    greatest = 0.0
    for _ in range(50):
        q = generator.uniform(arm.chain.lower, arm.chain.upper)
        v, a = generator.normal(size=(2, len(q)))
        data.qpos[:], data.qvel[:], data.qacc[:] = q, 0.0, 0.0
        mujoco.mj_forward(model, data)
        gravity = pin.computeGeneralizedGravity(oracle, oracle_data, q)
        assert data.qfrc_bias == pytest.approx(gravity, abs=1e-6)
        greatest = max(greatest, np.abs(gravity).max())
        data.qvel[:], data.qacc[:] = v, a
        mujoco.mj_inverse(model, data)
        needed = data.qfrc_inverse
        assert needed == pytest.approx(pin.rnea(oracle, oracle_data, q, v, a), abs=1e-6)
    assert greatest > 0.1  # N m: the comparison is not one of zeros


def test_human7_weighs_on_its_shoulder_as_by_hand() -> None:
    """Stretched out forward: sum of mass times distance, and 9.80665 m/s2."""
    arm = load_arm("human7", CALIBRATION)
    model = mujoco.MjModel.from_xml_string(build_mjcf(arm))
    data = mujoco.MjData(model)
    data.joint("shoulder_flexion").qpos[0] = np.pi / 2
    mujoco.mj_forward(model, data)
    arms = [
        (0.21, 0.05),
        (0.245, 0.245),
        (0.11, 0.34),
        (0.13, 0.50),
        (0.10, 0.58),
        (0.08, 0.61),
        (0.03, 0.66),
    ]
    by_hand = 9.80665 * sum(mass * distance for mass, distance in arms)
    assert data.joint("shoulder_flexion").qfrc_bias[0] == pytest.approx(by_hand, rel=1e-9)
