"""Arms whose joints stand in a URDF: against Pinocchio, and what is refused."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from armsyn.arm import ArmDescription, gravity_torque, load_arm
from armsyn.errors import DescriptionError

URDF = """<?xml version="1.0"?>
<robot name="mine">
  <link name="base"><inertial><mass value="3"/></inertial></link>
  <link name="upper">
    <inertial><origin xyz="0.1 0 0.02" rpy="0.3 -0.2 0.1"/><mass value="0.4"/>
      <inertia ixx="1e-4" iyy="9e-4" izz="8e-4" ixy="1e-5" ixz="0" iyz="2e-5"/></inertial>
  </link>
  <link name="bracket">
    <inertial><origin xyz="0 0.01 0"/><mass value="0.05"/>
      <inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="lower"><inertial><origin xyz="0.09 0 0"/><mass value="0.2"/>
      <inertia ixx="2e-5" iyy="4e-4" izz="4e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="finger"><inertial><origin xyz="0.02 0 0"/><mass value="0.03"/>
      <inertia ixx="1e-6" iyy="2e-6" izz="2e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.1" rpy="0 0.2 0"/>
    <axis xyz="0 1 0"/><limit lower="-1.5" upper="1.2" velocity="3.5" effort="1"/>
  </joint>
  <joint name="weld" type="fixed">
    <parent link="upper"/><child link="bracket"/><origin xyz="0.2 0 0" rpy="0.5 0 0"/>
  </joint>
  <joint name="elbow" type="continuous">
    <parent link="bracket"/><child link="lower"/><origin xyz="0.05 0 0"/><axis xyz="0 1 0.2"/>
  </joint>
  <joint name="jaw" type="prismatic">
    <parent link="lower"/><child link="finger"/><origin xyz="0.15 0.01 0" rpy="0 0 0.4"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.03" velocity="0" effort="1"/>
  </joint>
  <joint name="end" type="fixed">
    <parent link="lower"/><child link="hand"/><origin xyz="0.18 0 0" rpy="0 0 0.1"/>
  </joint>
</robot>
"""

ARM = """
schema = "armsyn-arm-1"
name = "mine"
title = "one of my own"

[urdf]
file = "mine.urdf"
tip = "hand"

[landmarks]
hand = "tip"

[[joint]]
name = "elbow"
rest = 0.4
lower = -2.0
max_velocity = 2.0
max_acceleration = 10.0

[[joint]]
name = "shoulder"
rest = -0.3
max_acceleration = 12.0
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "mine.urdf").write_text(URDF)
    (tmp_path / "mine.toml").write_text(ARM)
    return tmp_path


def mine(folder: Path, arm: tuple[str, str] = ("", ""), urdf: tuple[str, str] = ("", "")) -> None:
    """Load the arm with something replaced in one of its files."""
    assert arm[0] in ARM
    assert urdf[0] in URDF
    (folder / "mine.toml").write_text(ARM.replace(*arm, 1) if arm[0] else ARM)
    (folder / "mine.urdf").write_text(URDF.replace(*urdf, 1) if urdf[0] else URDF)
    load_arm("mine", folder)


def reduced() -> tuple[pin.Model, pin.Data]:
    """Pinocchio's own reading of the file, with the jaw held at zero."""
    model = pin.buildModelFromXML(URDF)
    model = pin.buildReducedModel(model, [model.getJointId("jaw")], pin.neutral(model))
    return model, model.createData()


def configuration(q: np.ndarray) -> np.ndarray:
    """Pinocchio has the cosine and sine of a joint without limits."""
    return np.array([q[0], np.cos(q[1]), np.sin(q[1])])


def test_joints_are_the_urdfs_and_what_is_changed(folder: Path) -> None:
    arm = load_arm("mine", folder)
    assert arm.joint_names == ("shoulder", "elbow")
    assert [(j.lower, j.upper) for j in arm.joint] == [(-1.5, 1.2), (-2.0, np.pi)]
    assert [j.max_velocity for j in arm.joint] == [3.5, 2.0]
    assert arm.rest.tolist() == [-0.3, 0.4]


def test_kinematics_and_weight_are_pinocchios(folder: Path) -> None:
    arm: ArmDescription = load_arm("mine", folder)
    model, data = reduced()
    hand = model.getFrameId("hand")
    generator = np.random.default_rng(7)
    for q in generator.uniform(-1.5, 1.2, size=(30, 2)):
        pin.framesForwardKinematics(model, data, configuration(q))
        assert arm.chain.forward(q).tip == pytest.approx(data.oMf[hand].translation, abs=1e-9)
        weight = pin.computeGeneralizedGravity(model, data, configuration(q))
        # Pinocchio's standard gravity is 9.81
        expected = weight * 9.80665 / 9.81
        assert gravity_torque(arm, q) == pytest.approx(expected, abs=1e-6)


def test_links_are_pinocchios_bodies(folder: Path) -> None:
    model, _ = reduced()
    for joint, body in zip(load_arm("mine", folder).joint, list(model.inertias)[1:], strict=True):
        assert joint.link is not None
        assert joint.link.inertia is not None
        assert joint.link.mass == pytest.approx(body.mass)
        assert joint.link.centre_of_mass == pytest.approx(body.lever, abs=1e-9)
        assert joint.link.inertia.matrix == pytest.approx(body.inertia, abs=1e-9)


def test_a_link_may_be_changed_and_masses_may_be_missing(folder: Path) -> None:
    link = "rest = 0.4\nlink = { mass = 1.0, centre_of_mass = [0.0, 0.0, 0.1] }"
    (folder / "mine.toml").write_text(ARM.replace("rest = 0.4", link))
    changed = load_arm("mine", folder).joint[1].link
    assert changed is not None
    assert (changed.mass, changed.inertia) == (1.0, None)
    bare = URDF.replace('<mass value="0.4"/>', '<mass value="0"/>')
    (folder / "mine.urdf").write_text(bare.replace('<mass value="0.05"/>', ""))
    assert load_arm("mine", folder).joint[0].link is None


def test_a_tip_may_be_moved(folder: Path) -> None:
    (folder / "mine.toml").write_text(ARM + "\n[tip]\nmass = 0.1\nxyz = [0.2, 0.0, 0.0]\n")
    arm = load_arm("mine", folder)
    assert (arm.tip.xyz, arm.tip.mass, arm.tip.rpy) == ((0.2, 0, 0), 0.1, (0.0, 0.0, 0.1))


REFUSED = {
    "no rest": (("rest = 0.4\n", ""), "joint elbow: rest is missing"),
    "no speed anywhere": (("max_velocity = 2.0\n", ""), "joint elbow: max_velocity is missing"),
    "rest beyond": (("rest = 0.4", "rest = -2.1"), "joint elbow: rest -2.1 is outside its limits"),
    "another joint": (('name = "elbow"', 'name = "knee"'), "table 1: name 'knee' is no joint"),
    "one joint twice": (('name = "elbow"', 'name = "shoulder"'), "table 2: joint shoulder has one"),
    "unknown tip": (('tip = "hand"', 'tip = "foot"'), "no link 'foot'"),
    "no tip of two": (('tip = "hand"', ""), "name one as tip: finger, hand"),
    "unknown key": (('tip = "hand"', "top = 1"), "urdf: Object contains unknown field `top`"),
    "no file": (("mine.urdf", "yours.urdf"), "file 'yours.urdf' is no file"),
    "a folder": (("mine.urdf", "."), "file '.' is no file"),
    "out of the folder": (("mine.urdf", "../mine.urdf"), "is outside the description's folder"),
    "absolute": (("mine.urdf", "/etc/passwd"), "is outside the description's folder"),
    "no path": (("mine.urdf", "a\\u0000b"), "cannot be a path"),
    "no number": (("rest = 0.4", "rest = nan"), "joint elbow: rest must be finite"),
    "no table": (("[urdf]\nfile = ", "urdf = "), "urdf: Expected `object`, got `str`"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_refused_of_the_description(folder: Path, what: str) -> None:
    change, said = REFUSED[what]
    if what == "no table":
        change = ('[urdf]\nfile = "mine.urdf"\ntip = "hand"\n', "")
        (folder / "mine.toml").write_text('urdf = "mine.urdf"\n' + ARM.replace(*change, 1))
        with pytest.raises(DescriptionError) as caught:
            load_arm("mine", folder)
    else:
        with pytest.raises(DescriptionError) as caught:
            mine(folder, arm=change)
    assert said in str(caught.value)
    assert "mine.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


SPOILED = {
    "negative mass": ('<mass value="0.4"/>', '<mass value="-1"/>', "link upper: its mass is -1"),
    "mass in words": ('<mass value="0.4"/>', '<mass value="much"/>', "value of <mass> must be 1"),
    "no body": ('ixx="2e-5" iyy="4e-4"', 'ixx="9e-1" iyy="4e-4"', "joint elbow: what it moves"),
    "inertia nowhere": ('ixx="2e-5"', 'ixx="inf"', "link lower: ixx of <inertia> must be 1 finite"),
    "endless speed": ('velocity="3.5"', 'velocity="inf"', "joint shoulder: velocity of <limit>"),
    "no chain": ('<parent link="base"/>', '<parent link="hand"/>', "loop"),
    "an attack": ("<robot", '<!DOCTYPE x [<!ENTITY a "b">]><robot', "DOCTYPE"),
    "no xml": ("</robot>", "", "not well-formed"),
    "huge": ("<robot", "<!--" + "x" * 10_000_000 + "--><robot", "larger than 10000000 bytes"),
}


@pytest.mark.parametrize("what", SPOILED)
def test_what_is_refused_of_the_urdf(folder: Path, what: str) -> None:
    before, after, said = SPOILED[what]
    with pytest.raises(DescriptionError) as caught:
        mine(folder, urdf=(before, after))
    assert said in str(caught.value)
    assert "mine.urdf" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.fault(37)
def test_a_link_out_of_the_folder_is_outside(folder: Path) -> None:
    elsewhere = folder.parent / f"{folder.name}-elsewhere.urdf"
    elsewhere.write_text(URDF)
    (folder / "mine.urdf").unlink()
    (folder / "mine.urdf").symlink_to(elsewhere)
    with pytest.raises(DescriptionError, match="is outside the description's folder"):
        load_arm("mine", folder)
    elsewhere.unlink()


def test_a_folder_below_is_inside(folder: Path) -> None:
    (folder / "parts").mkdir()
    (folder / "mine.urdf").rename(folder / "parts" / "mine.urdf")
    (folder / "mine.toml").write_text(ARM.replace("mine.urdf", "parts/mine.urdf"))
    assert load_arm("mine", folder).joint_names == ("shoulder", "elbow")
