"""`armsyn arms`: the list of arms and the rig file."""

import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

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
    call("arms", "--json", "rig", "koch").refused(2, "--json belongs to the list of arms")
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
