"""`armsyn arms`: the list of arms and the rig file."""

import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from armsyn.arm import load_arm
from armsyn.arm.droop import expected_droop
from tests.cli.commands import Outcome

Call = Callable[..., Outcome]


@pytest.fixture(autouse=True)
def only_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ARMSYN_CALIBRATION", raising=False)


def test_the_list_is_for_people(call: Call, calibration: Path) -> None:
    said = call("arms", "--calibration", calibration)
    assert (said.status, said.err) == (0, "")
    lines = said.out.splitlines()
    assert any(line.split()[:4] == ["human7", "7", "7", "yes"] for line in lines)
    assert any(line.split()[:4] == ["hug_mp4", "4", "0", "no"] for line in lines)


def test_the_list_as_json(call: Call, calibration: Path) -> None:
    (calibration / "broken.toml").write_text("schema = ")
    (calibration / "not a name.toml").write_text("")
    said = call("arms", "--calibration", calibration, "--json")
    assert (said.status, said.err) == (0, "")
    arms = {entry["name"]: entry for entry in said.document["arms"]}
    assert arms["koch"] == {
        "name": "koch",
        "file": str(calibration / "koch.toml"),
        "title": "Koch v1.1, 5 joints",
        "joints": 5,
        "servos": 6,
        "masses": True,
    }
    assert "broken.toml" in arms["broken"]["error"]
    assert "not the name of an arm" in arms["not a name"]["error"]


def test_no_arms_at_all(call: Call, tmp_path: Path) -> None:
    call("arms", "--calibration", tmp_path).refused(2, "no arms found")


def test_the_rig_file(call: Call, calibration: Path, tmp_path: Path) -> None:
    out = tmp_path / "koch.rig.toml"
    out.write_text("old")
    said = call("arms", "rig", "koch", "--out", out, "--calibration", calibration)
    assert (said.status, said.out, said.err) == (0, "", f"wrote {out}\n")
    document = tomllib.loads(out.read_text())
    assert [servo["id"] for servo in document["servo"]] == [1, 2, 3, 4, 5, 6]
    assert "<mujoco" in document["plant"]["mjcf"]
    printed = call("arms", "--calibration", calibration, "rig", "koch")
    assert (printed.status, printed.err) == (0, "")
    assert printed.out == out.read_text()


def test_refusals_write_nothing(call: Call, calibration: Path, tmp_path: Path) -> None:
    out = tmp_path / "rig.toml"
    description = calibration / "koch.toml"
    description.write_text(description.read_text().replace("[joint.link]\nmass = 0.0638", "[x.y]"))
    spoilt = ["--calibration", calibration, "--out", out]
    call("arms", "rig", "koch", *spoilt).refused(2, "koch.toml")
    call("arms", "rig", "hug_mp4", *spoilt).refused(2, "hug_mp4 has no servos")
    call("arms", "rig", "nobody", *spoilt).refused(2, "no nobody.toml", "human7")
    said = call("arms", "--json", "rig", "koch")
    assert said.status == 2
    assert "--json belongs to the list of arms" in said.document["error"]["message"]
    call("arms", "rig", "human7", "--out", tmp_path / "none" / "rig.toml").refused(
        2, "cannot write it"
    )
    assert [path.name for path in tmp_path.iterdir()] == ["calibration"]


def test_a_joint_without_mass_is_named(call: Call, calibration: Path) -> None:
    description = calibration / "koch.toml"
    head, link, rest = description.read_text().partition("[joint.link]\n")
    description.write_text(head + rest[rest.index("[[joint]]") :])
    assert link
    said = call("arms", "rig", "koch", "--calibration", calibration)
    said.refused(2, "joint shoulder_pan has no mass", "[joint.link]")


ALL = ["human7", "koch", "openmanipulator_x", "reachy_right", "viperx_300s", "widowx_250s"]


@pytest.mark.parametrize("name", ALL)
def test_every_arm_has_a_rig_file(call: Call, calibration: Path, name: str) -> None:
    said = call("arms", "rig", name, "--calibration", calibration)
    assert (said.status, said.err) == (0, "")
    servos = tomllib.loads(said.out)["servo"]
    arm = load_arm(name, calibration)
    assert [servo["id"] for servo in servos] == [servo.id for servo in arm.servo]
    shadows = {servo["id"]: servo.get("shadow_of") for servo in servos if "shadow_of" in servo}
    assert shadows == {servo.id: servo.shadow_of for servo in arm.shadows}


@pytest.mark.parametrize("name", [*ALL, "hug_mp4"])
def test_an_arm_is_shown(call: Call, calibration: Path, name: str) -> None:
    facts = call("arms", "show", name, "--calibration", calibration, "--json").document
    arm = load_arm(name, calibration)
    assert [joint["name"] for joint in facts["joints"]] == list(arm.joint_names)
    assert {servo["id"] for servo in facts["servos"]} == {servo.id for servo in arm.servo}
    hand = facts["landmarks"][-1]
    assert hand["zero_m"] == pytest.approx(arm.chain.forward([0.0] * arm.chain.dof).tip)
    assert (facts["gripper"] is None) == (arm.gripper is None)
    if name != "hug_mp4":
        droops = [joint["droop"] for joint in facts["joints"]]
        assert droops == pytest.approx(expected_droop(arm).tolist())
    said = call("arms", "show", name, "--calibration", calibration)
    assert (said.status, said.err) == (0, "")
    for joint in arm.joint_names:
        assert any(line.split()[:1] == [joint] for line in said.out.splitlines())
    assert "…" not in said.out


def test_what_is_shown_of_human7(call: Call, calibration: Path) -> None:
    facts = call("arms", "show", "human7", "--calibration", calibration, "--json").document
    assert facts["files"]["description"] == str(calibration / "human7.toml")
    assert facts["files"]["synergies"] == str(calibration / "human7.synergies.json")
    assert facts["files"]["calibration"] is None
    assert [mark["name"] for mark in facts["landmarks"]] == ["shoulder", "elbow", "wrist", "hand"]
    assert facts["moving_mass_kg"] == pytest.approx(1.115)
    # XM540-W270 at 12 V: 2.94 N m over 48.8 N m/rad; the hand hangs 0.66 m out
    assert facts["joints"][0]["droop"] == pytest.approx(0.0603, abs=2e-3)
    assert 0.035 < facts["droop"]["hand_m"] < 0.06
    said = call("arms", "show", "human7", "--calibration", calibration).out
    assert "droop at worst, uncorrected" in said
    assert "P gain / 128 / 885" in said.replace("\n", " ")


def test_a_picture_of_an_arm(call: Call, calibration: Path, tmp_path: Path) -> None:
    picture = tmp_path / "koch.png"
    said = call("arms", "show", "koch", "--calibration", calibration, "--plot", picture)
    assert (said.status, said.err) == (0, f"wrote {picture}\n")
    assert picture.read_bytes().startswith(b"\x89PNG")
    call("arms", "show", "koch", "--plot", tmp_path / "koch.pdf").refused(2, "written as .png")
    call("arms", "show", "koch", "--plot", tmp_path / "none" / "koch.png").refused(2, "cannot")
    call("arms", "show", "nobody").refused(2, "no nobody.toml")


def test_ones_own_arm(call: Call, tmp_path: Path) -> None:
    """From the template to its rig file, as an owner would."""
    made = call("arms", "template", "--name", "left", "--out", tmp_path / "left.toml")
    assert (made.status, made.out) == (0, "")
    call("arms", "template", "--out", tmp_path / "left.toml").refused(2, "exists already")
    printed = call("arms", "template", "--name", "left")
    assert printed.out == (tmp_path / "left.toml").read_text()
    assert call("arms", "show", "left", "--calibration", tmp_path).status == 0
    assert call("arms", "rig", "left", "--calibration", tmp_path).status == 0
    (tmp_path / "left.toml").write_text(printed.out.replace("rest = 0.0", "rest = 9.0", 1))
    call("arms", "show", "left", "--calibration", tmp_path).refused(
        2, "left.toml: joint shoulder: rest 9 is outside its limits"
    )
    call("arms", "template", "--tip", "hand").refused(2, "give --urdf")
    call("arms", "template", "--urdf", tmp_path / "none.urdf").refused(2, "none.urdf")
