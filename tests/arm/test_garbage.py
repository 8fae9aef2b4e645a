"""Descriptions of any kind of nonsense: an arm, or one line that says what is wrong."""

import math
import tomllib
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armsyn.arm import ArmDescription
from armsyn.arm.description import MOST_JOINTS, parse_arm
from armsyn.errors import DescriptionError

CALIBRATION = Path(__file__).resolve().parents[2] / "calibration"
TEXTS = [(CALIBRATION / f"{name}.toml").read_text() for name in ("human7", "viperx_300s", "koch")]

NUMBERS = st.one_of(
    st.floats(),
    st.integers(-(2**70), 2**70),
    st.sampled_from([math.nan, math.inf, -math.inf, 1e308, 5e-324, 0, -1]),
)
VALUES = st.one_of(
    NUMBERS, st.booleans(), st.text(max_size=8), st.lists(NUMBERS, max_size=4), st.just({})
)


def outcome(text: str) -> tuple[ArmDescription | None, str]:
    try:
        return parse_arm(text, "some.toml"), ""
    except DescriptionError as error:
        return None, str(error)


def judge(text: str) -> None:
    """An arm whose numbers are numbers, or one line that names the file."""
    arm, said = outcome(text)
    if arm is None:
        assert said.startswith("some.toml: ")
        assert "\n" not in said
        assert len(said) < 2000
        return
    assert "nan" not in repr(msgspec.to_builtins(arm))
    assert (arm.chain.lower <= arm.rest).all()
    assert (arm.rest <= arm.chain.upper).all()


@given(st.text())
def test_any_text(text: str) -> None:
    judge(text)


@pytest.mark.fault(36)
@given(st.sampled_from(TEXTS), st.data())
def test_any_damage(text: str, data: st.DataObject) -> None:
    """Some characters are lost, some come in."""
    start = data.draw(st.integers(0, len(text)))
    length = data.draw(st.integers(0, 40))
    judge(text[:start] + data.draw(st.text(max_size=10)) + text[start + length :])


@pytest.mark.fault(36)
@settings(max_examples=300)
@given(st.sampled_from(TEXTS), st.data())
def test_any_value_of_any_line(text: str, data: st.DataObject) -> None:
    lines = text.splitlines()
    places = [row for row, line in enumerate(lines) if " = " in line and line[0] != "#"]
    row = data.draw(st.sampled_from(places))
    value = data.draw(VALUES)
    key = lines[row].split(" = ")[0]
    lines[row] = f"{key} = {as_toml(value)}"
    changed = "\n".join(lines)
    tomllib.loads(changed)
    judge(changed)


def as_toml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return "[" + ", ".join(as_toml(x) for x in value) + "]"
    if isinstance(value, str):
        return (
            '"' + "".join(f"\\U{ord(c):08x}" for c in value if not 0xD800 <= ord(c) < 0xE000) + '"'
        )
    return "{}" if value == {} else repr(value)


@pytest.mark.parametrize(
    "line",
    [
        f"x = {'9' * 5000}",
        "x = 1e99999",
        "x = 0001-01-01",
        "x = 25:61:00",
        "x.y = 1\nx = 2",
        "a." * 500 + "b = 1",
        "\x00",
    ],
)
def test_what_toml_itself_may_choke_on(line: str) -> None:
    with pytest.raises(DescriptionError, match=r"^some\.toml: "):
        parse_arm(line, "some.toml")


def test_an_arm_of_too_many_joints() -> None:
    head, joint, rest = TEXTS[0].partition("[[joint]]")
    with pytest.raises(DescriptionError, match=r"length <= 64 - at `\$\.joint`"):
        parse_arm(head + (joint + rest.split("[[joint]]")[0]) * (MOST_JOINTS + 1), "some.toml")


@pytest.mark.parametrize("beyond", ["1e7", "-1e7", "1e300"])
def test_numbers_beyond_any_arms(beyond: str) -> None:
    text = TEXTS[0].replace("xyz = [0.0, 0.0, -0.10]", f"xyz = [0.0, 0.0, {beyond}]")
    with pytest.raises(DescriptionError, match="tip: xyz is beyond any arm's"):
        parse_arm(text, "some.toml")
