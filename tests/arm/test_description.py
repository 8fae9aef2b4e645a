"""Arm descriptions: the ones of the house, and what strict reading refuses."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.arm import arm_names, find_file, load_arm
from armsyn.arm.description import parse_arm
from armsyn.errors import DescriptionError

ARM = """
schema = "armsyn-arm-1"
name = "two"
title = "two joints"

[landmarks]
elbow = "b"
hand = "tip"

[tip]
xyz = [0.1, 0.0, 0.0]

[[joint]]
name = "a"
axis = [0.0, 0.0, 1.0]
lower = -1.0
upper = 1.0
rest = 0.5
max_velocity = 2.0
max_acceleration = 10.0

[[joint]]
name = "b"
xyz = [0.2, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
lower = -1.0
upper = 1.0
rest = 0.0
max_velocity = 2.0
max_acceleration = 10.0

[[servo]]
joint = "a"
id = 1
model = "xm430-w350"
zero_tick = 2048
rest_tick = 2374
supply_voltage = 12.0

[[servo]]
joint = "b"
id = 2
model = "xm430-w350"
direction = -1
zero_tick = 2048
rest_tick = 2048
supply_voltage = 12.0
"""


@pytest.fixture(autouse=True)
def only_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ARMSYN_CALIBRATION", raising=False)


def load(folder: Path, text: str) -> None:
    (folder / "two.toml").write_text(text)
    load_arm("two", folder)


@pytest.mark.parametrize("name", arm_names())
def test_the_arms_of_the_house(name: str) -> None:
    arm = load_arm(name)
    assert arm.chain.names == arm.joint_names
    assert (arm.chain.lower <= arm.rest).all()
    assert (arm.rest <= arm.chain.upper).all()
    assert len(arm.landmark_frames) == len(arm.landmarks)
    if arm.servo:
        ticks = [servo.rest_tick for servo in arm.leaders]
        assert arm.calibration.to_radians(ticks) == pytest.approx(arm.rest, abs=2.4e-3)


def test_what_is_read(tmp_path: Path) -> None:
    (tmp_path / "two.toml").write_text(ARM)
    arm = load_arm("two", tmp_path)
    assert arm.joint_names == ("a", "b")
    assert arm.calibration.direction.tolist() == [1, -1]
    assert arm.servo[1].baud == 1_000_000
    assert arm.landmark_frames == (1, 2)
    assert arm.chain.forward([0.0, 0.0]).tip == pytest.approx([0.3, 0.0, 0.0])
    assert np.array_equal(arm.max_velocity, [2.0, 2.0])


def test_an_arm_may_follow_the_hand_only() -> None:
    hand = parse_arm(ARM.replace("[landmarks]", 'follows = "hand"\n[landmarks]'), "two.toml")
    assert hand.anatomy == {"elbow": "b", "hand": "tip"}
    assert (hand.landmarks, hand.landmark_frames) == ({"hand": "tip"}, (2,))
    both = parse_arm(ARM, "two.toml")
    assert both.landmarks == both.anatomy == hand.anatomy


SPOILED = {
    "duplicate ID": ("id = 2", "id = 1", "servo ID 1 is given twice"),
    "ID beyond the bus": ("id = 2", "id = 253", "id"),
    "unknown field": ("id = 2", "id = 2\ncolour = 3", "colour"),
    "unknown field of a box": (
        "[tip]",
        '[[box]]\nname = "camera"\ncenter = [1.0, 0.0, 0.0]\n[tip]',
        "`center` - at `$.box[0]`; allowed are name, centre, size, rpy; did you mean 'centre'?",
    ),
    "misspelt field": ("zero_tick = 2048\nrest_tick = 2374", "zero = 2048", "zero"),
    "missing field": ('title = "two joints"', "", "title"),
    "text for a number": ("upper = 1.0", 'upper = "1"', "upper"),
    "not a number": ("rest = 0.5", "rest = nan", "joint a: rest must be finite, got nan"),
    "endless speed": ("max_velocity = 2.0", "max_velocity = inf", "joint a: max_velocity must be"),
    "endless voltage": ("= 12.0", "= inf", "servo 1: supply_voltage must be finite, got inf"),
    "facing nowhere": (
        "[landmarks]",
        "facing = nan\n[landmarks]",
        "facing must be finite, got nan",
    ),
    "tip nowhere": ("[0.1, 0.0, 0.0]", "[0.1, nan, 0.0]", "tip: xyz must be finite"),
    "joint nowhere": ("[0.2, 0.0, 0.0]", "[inf, 0.0, 0.0]", "joint b: xyz must be finite"),
    "speed of zero": ("max_velocity = 2.0", "max_velocity = 0.0", "max_velocity"),
    "limits crossed": ("lower = -1.0", "lower = 2.0", "joint a: lower limit 2"),
    "rest outside": ("rest = 0.5", "rest = 1.5", "joint a: rest 1.5 is outside its limits"),
    "axis without length": ("axis = [0.0, 0.0, 1.0]", "axis = [0.0, 0.0, 0.0]", "joint a"),
    "two joints of a name": ('name = "b"', 'name = "a"', "share a name"),
    "unknown landmark": ('elbow = "b"', 'elbow = "c"', "landmark elbow: 'c'"),
    "hand not last": ('hand = "tip"', 'hand = "b"', "must be 'tip'"),
    "servo of another joint": ('joint = "b"', 'joint = "c"', "servos move"),
    "rest tick elsewhere": ("rest_tick = 2374", "rest_tick = 2000", "is not the joint's rest"),
    "two baud rates": ("id = 2", "id = 2\nbaud = 57600", "one baud rate"),
    "another schema": ("armsyn-arm-1", "armsyn-arm-9", "schema"),
    "another name": ('name = "two"', 'name = "three"', "name is 'three'"),
    "no TOML": ("[tip]", "[tip", "line"),
}


@pytest.mark.fault(36)
@pytest.mark.parametrize("what", SPOILED)
def test_a_spoiled_description(tmp_path: Path, what: str) -> None:
    before, after, text = SPOILED[what]
    assert before in ARM
    with pytest.raises(DescriptionError) as caught:
        load(tmp_path, ARM.replace(before, after, 1))
    message = str(caught.value)
    assert text in message
    assert "two.toml" in message
    assert "\n" not in message
    assert caught.value.exit_status == 2


def test_a_description_that_is_no_text(tmp_path: Path) -> None:
    (tmp_path / "two.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DescriptionError, match=r"two\.toml"):
        load_arm("two", tmp_path)


@pytest.mark.fault(38)
def test_a_huge_description(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="larger than 1000000 bytes"):
        load(tmp_path, ARM + "#" * 1_000_001)


@pytest.mark.fault(37)
@pytest.mark.parametrize("name", ["", "../human7", "a/b", ".hidden", "x" * 65])
def test_names_that_are_paths(name: str) -> None:
    with pytest.raises(DescriptionError, match="is not the name of an arm"):
        find_file(name, ".toml")


def test_an_unknown_arm_names_the_known(tmp_path: Path) -> None:
    (tmp_path / "two.toml").write_text(ARM)
    with pytest.raises(DescriptionError, match=r"no nobody\.toml in .* \(arms found: two\)"):
        load_arm("nobody", tmp_path)


def test_what_an_arm_has_not_learned_is_not_taken_for_a_misspelt_name(tmp_path: Path) -> None:
    (tmp_path / "two.toml").write_text(ARM)
    for suffix, cure in ((".atlas.json", "--arm two --atlas"), (".synergies.json", "--arm two")):
        with pytest.raises(DescriptionError, match=f"run armsyn learn {cure}") as caught:
            find_file("two", suffix, tmp_path)
        assert "did you mean" not in str(caught.value)
    with pytest.raises(DescriptionError) as caught:
        find_file("two", ".other", tmp_path)
    assert "did you mean" not in str(caught.value)


def test_a_named_folder_is_searched_alone_and_says_what_it_lacks(tmp_path: Path) -> None:
    found = find_file("koch", ".toml")
    with pytest.raises(DescriptionError, match=r"no koch\.toml in .* \(only the folder") as caught:
        load_arm("koch", tmp_path)
    assert f"copy {found} there" in str(caught.value)


def test_the_environment_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "two.toml").write_text(ARM)
    monkeypatch.setenv("ARMSYN_CALIBRATION", str(tmp_path))
    assert find_file("two", ".toml") == tmp_path / "two.toml"
    assert "human7" in arm_names()


@pytest.mark.fault(38)
def test_tables_nested_without_end_are_refused() -> None:
    with pytest.raises(DescriptionError, match=r"deep\.toml"):
        parse_arm("x = " + "[" * 20_000, "deep.toml")
