"""Torques that hold an arm against its weight, against Pinocchio and by hand."""

from pathlib import Path

import msgspec
import numpy as np
import pinocchio as pin
import pytest

from armsyn.arm import arm_names, gravity_torque, load_arm
from armsyn.errors import InputError
from tests.arm.models import pinocchio_model

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"
ARMS = [name for name in arm_names(CALIBRATION) if load_arm(name, CALIBRATION).servo]


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("sliding", [False, True])
def test_torques_are_pinocchios(name: str, *, sliding: bool) -> None:
    """Also for an arm that is mounted aslant, carries something, and has a joint that slides."""
    arm = load_arm(name, CALIBRATION)
    tip = msgspec.structs.replace(arm.tip, mass=0.2, rpy=(0.3, -0.2, 0.1))
    arm = msgspec.structs.replace(arm, gravity=(3.0, -5.0, -7.0), tip=tip)
    if sliding:
        joints = list(arm.joint)
        joints[1] = msgspec.structs.replace(joints[1], kind="prismatic", rpy=(0.4, 0.1, -0.3))
        arm = msgspec.structs.replace(arm, joint=tuple(joints), servo=())
    model = pinocchio_model(arm)
    data = model.createData()
    generator = np.random.default_rng(4)
    for _ in range(50):
        q = generator.uniform(-2.0, 2.0, size=arm.chain.dof)
        expected = pin.computeGeneralizedGravity(model, data, q)
        assert np.abs(expected).max() > 0.1
        assert gravity_torque(arm, q) == pytest.approx(expected, abs=1e-12)


def test_a_stretched_arm_by_hand() -> None:
    """human7 pointing forwards: masses times distances from the shoulder times 9.80665 m/s2."""
    arm = load_arm("human7", CALIBRATION)
    posture = np.zeros(7)
    posture[0] = np.pi / 2
    moment = sum(
        mass * distance
        for mass, distance in [
            (0.21, 0.05),
            (0.245, 0.245),
            (0.11, 0.34),
            (0.13, 0.50),
            (0.10, 0.58),
            (0.08, 0.61),
            (0.03, 0.66),
        ]
    )
    assert gravity_torque(arm, posture)[0] == pytest.approx(9.80665 * moment)


def test_a_hanging_arm_needs_nothing() -> None:
    assert gravity_torque(load_arm("human7", CALIBRATION), np.zeros(7)) == pytest.approx(0.0)


def test_what_is_refused() -> None:
    arm = load_arm("human7", CALIBRATION)
    with pytest.raises(InputError, match="hug_mp4: joint shoulder_abduction has no mass"):
        gravity_torque(load_arm("hug_mp4", CALIBRATION), np.zeros(4))
    for wrong in (np.zeros(6), np.full(7, np.nan)):
        with pytest.raises(InputError, match="7 finite numbers"):
            gravity_torque(arm, wrong)
