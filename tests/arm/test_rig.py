"""The rig file: TOML that says of an arm's servos and bodies what the description does."""

import tomllib
from pathlib import Path

import msgspec
import mujoco
import numpy as np
import pytest

from armsyn.arm import ArmDescription, arm_names, load_arm
from armsyn.arm.mjcf import build_mjcf
from armsyn.arm.rig import build_rig
from armsyn.errors import InputError

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"
ARMS = [name for name in arm_names(CALIBRATION) if load_arm(name, CALIBRATION).servo]


def compiled(arm: ArmDescription) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(build_mjcf(arm))


def changed(arm: ArmDescription, index: int, **fields: object) -> ArmDescription:
    """The arm with fields of one joint replaced."""
    joints = list(arm.joint)
    joints[index] = msgspec.structs.replace(joints[index], **fields)
    return msgspec.structs.replace(arm, joint=tuple(joints))


def test_every_arm_with_servos_has_masses() -> None:
    assert set(ARMS) == {
        "human7",
        "koch",
        "openmanipulator_x",
        "reachy_right",
        "viperx_300s",
        "widowx_250s",
    }
    for name in ARMS:
        assert all(joint.link is not None for joint in load_arm(name, CALIBRATION).joint)


@pytest.mark.parametrize("name", ARMS)
def test_the_servos_are_the_descriptions(name: str) -> None:
    arm = load_arm(name, CALIBRATION)
    document = tomllib.loads(build_rig(arm))
    assert set(document) == {"servo", "supply", "plant"}
    assert document["supply"] == {"resistance": 0.03}
    assert set(document["plant"]) == {"mjcf"}
    for table, servo in zip(document["servo"], arm.servo, strict=True):
        expected = msgspec.structs.asdict(servo)
        expected["start_tick"] = expected.pop("rest_tick")
        assert table == {name: value for name, value in expected.items() if value is not None}
    mujoco.MjModel.from_xml_string(document["plant"]["mjcf"])


@pytest.mark.parametrize("name", ARMS)
def test_bodies_lie_where_forward_kinematics_says(name: str) -> None:
    arm = load_arm(name, CALIBRATION)
    model = compiled(arm)
    data = mujoco.MjData(model)
    generator = np.random.default_rng(1)
    for _ in range(20):
        data.qpos[:] = generator.uniform(arm.chain.lower, arm.chain.upper)
        mujoco.mj_kinematics(model, data)
        frames = arm.chain.forward(data.qpos)
        for row, body in enumerate((*arm.joint_names, "tip")):
            assert data.body(body).xpos == pytest.approx(frames.positions[row], abs=1e-12)
            turned = data.body(body).xmat.reshape(3, 3)
            assert turned == pytest.approx(frames.orientations[row], abs=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_joints_end_at_their_limits(name: str) -> None:
    arm = load_arm(name, CALIBRATION)
    model = compiled(arm)
    for joint in arm.joint:
        found = model.joint(joint.name)
        assert found.limited[0]
        assert found.range == pytest.approx([joint.lower, joint.upper])


def test_masses_are_those_of_the_links_and_the_tip() -> None:
    arm = load_arm("human7", CALIBRATION)
    model = compiled(arm)
    for joint in arm.joint:
        assert joint.link is not None
        assert model.body(joint.name).mass[0] == joint.link.mass
        assert model.body(joint.name).ipos == pytest.approx(joint.link.centre_of_mass)
    assert model.body("tip").mass[0] == arm.tip.mass > 0
    assert model.opt.gravity == pytest.approx(arm.gravity)


def test_an_arm_without_masses_is_refused() -> None:
    arm = changed(load_arm("koch", CALIBRATION), 2, link=None)
    with pytest.raises(InputError, match=r"koch: joint elbow_flex has no mass: .*\[joint\.link\]"):
        build_rig(arm)


def test_an_arm_without_servos_is_refused() -> None:
    with pytest.raises(InputError, match="hug_mp4 has no servos"):
        build_rig(load_arm("hug_mp4", CALIBRATION))


@pytest.mark.parametrize("name", ["a'''b", 'say "two"', "a\\b", "<&>", "Ellenbogen übel 🦾"])
def test_names_are_written_so_that_they_read_back(name: str) -> None:
    arm = changed(load_arm("koch", CALIBRATION), 0, name=name)
    servo = msgspec.structs.replace(arm.servo[0], joint=name, model=name)
    arm = msgspec.structs.replace(arm, servo=(servo, *arm.servo[1:]))
    document = tomllib.loads(build_rig(arm))
    assert (document["servo"][0]["joint"], document["servo"][0]["model"]) == (name, name)
    model = mujoco.MjModel.from_xml_string(document["plant"]["mjcf"])
    assert model.joint(0).name == name


@pytest.mark.parametrize("spoilt", ["joint", "model"])
def test_names_that_cannot_be_written_are_refused(spoilt: str) -> None:
    arm = load_arm("koch", CALIBRATION)
    if spoilt == "joint":
        arm = changed(arm, 0, name="a\x01b")
    else:
        servo = msgspec.structs.replace(arm.servo[0], model="a\x7fb")
        arm = msgspec.structs.replace(arm, servo=(servo, *arm.servo[1:]))
    with pytest.raises(InputError, match="this name cannot be written"):
        build_rig(arm)
