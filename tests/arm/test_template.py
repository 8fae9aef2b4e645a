"""The template is an arm as it stands, with or without a URDF."""

import re
from pathlib import Path

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.arm.rig import build_rig
from armsyn.arm.template import build_template
from armsyn.errors import DescriptionError, InputError
from tests.arm.test_urdf import URDF


def test_it_can_be_loaded_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(build_template("mine"))
    arm = load_arm("mine", tmp_path)
    assert arm.joint_names == ("shoulder", "elbow")
    assert [servo.id for servo in arm.leaders] == [1, 2]
    assert list(arm.anatomy) == ["shoulder", "elbow", "hand"]
    assert "<mujoco" in build_rig(arm)


def test_what_is_commented_out_can_be_put_in(tmp_path: Path) -> None:
    """Every line that is a table or a key after its mark of a comment."""
    head, mark, tail = build_template("mine").partition("# [gripper]")
    head = re.sub(r"(?m)^# (facing|gravity) = ", r"\1 = ", head)
    opened = head + re.sub(r"(?m)^# (\[+\w+\]+|\w+ = )", r"\1", mark + tail)
    servo = '[[servo]]\njoint = "gripper"\nid = 3\nmodel = "xm430-w350"\nzero_tick = 2048\n'
    text = f"{opened}\n{servo}rest_tick = 2700\nsupply_voltage = 12.0\n"
    (tmp_path / "mine.toml").write_text(text)
    arm = load_arm("mine", tmp_path)
    assert arm.gripper is not None
    assert [plane.name for plane in arm.plane] == ["table"]
    assert [box.name for box in arm.box] == ["camera"]


def test_a_urdf_is_named_by_the_way_from_the_description_s_folder(tmp_path: Path) -> None:
    urdf = tmp_path / "arms" / "meshes" / "parts.urdf"
    urdf.parent.mkdir(parents=True)
    urdf.write_text(URDF)
    folder = tmp_path / "arms"
    (folder / "mine.toml").write_text(build_template("mine", urdf, tip="hand", folder=folder))
    assert load_arm("mine", folder).joint_names == ("shoulder", "elbow")
    with pytest.raises(InputError, match="copy it into"):
        build_template("mine", urdf, tip="hand", folder=tmp_path / "other")


def test_from_a_urdf_it_is_filled_in(tmp_path: Path) -> None:
    urdf = tmp_path / "parts.urdf"
    urdf.write_text(URDF)
    text = build_template("mine", urdf, tip="hand")
    (tmp_path / "mine.toml").write_text(text)
    arm = load_arm("mine", tmp_path)
    assert arm.joint_names == ("shoulder", "elbow")
    assert arm.joint[0].max_velocity == 3.5
    assert [j.lower for j in arm.joint] == [-1.5, -np.pi]
    assert "-1.5 to 1.2 rad; 0.45 kg" in text
    assert "<mujoco" in build_rig(arm)


def test_a_range_without_zero_rests_in_its_middle(tmp_path: Path) -> None:
    urdf = tmp_path / "parts.urdf"
    urdf.write_text(URDF.replace('lower="-1.5"', 'lower="0.4"'))
    (tmp_path / "mine.toml").write_text(build_template("mine", urdf, "base", "hand"))
    assert load_arm("mine", tmp_path).rest.tolist() == [0.8, 0.0]


def test_what_is_refused(tmp_path: Path) -> None:
    urdf = tmp_path / "parts.urdf"
    urdf.write_text(URDF)
    with pytest.raises(DescriptionError, match="name one as tip"):
        build_template("mine", urdf)
    with pytest.raises(DescriptionError, match="is not the name of an arm"):
        build_template("../mine")
    with pytest.raises(InputError, match=r"none\.urdf: cannot be read"):
        build_template("mine", tmp_path / "none.urdf")
