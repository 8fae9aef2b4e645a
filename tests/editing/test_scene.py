"""Scenes in TOML: everything they may say, and what is refused by its place."""

import contextlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.editing import Key, KeyFrame, KeyTrajectory, Orientation, Pin, SolverOptions
from armsyn.editing.scene import TEMPLATE, load_scene, parse_scene
from armsyn.errors import ArmsynError, ConstraintError, FormatError, InputError
from armsyn.kinematics.rotation import from_expmap

HEAD = 'schema = "armsyn-scene-1"\n'
KEY = '[[key_frame]]\nbody = "hand"\nframe = 3\nby = [0, 0.05, 0]\n'


def uncommented(text: str) -> str:
    """The template with its commented examples switched on."""
    lines = text.splitlines()
    names = (
        "[[ body point frame turned level axes by_deg relative keys ease tension continuity bias"
    )
    marks = tuple(f"# {name}" for name in names.split())
    return "\n".join(line[2:] if line.startswith(marks) else line for line in lines)


def test_the_template_is_a_scene_with_the_default_solver() -> None:
    scene = parse_scene(TEMPLATE)
    assert scene.options == SolverOptions()
    (key,) = scene.constraints
    assert isinstance(key, KeyFrame)
    assert (key.effector.body, key.frame, key.by) == ("hand", -1, (0.0, 0.05, 0.0))


def test_the_templates_examples_are_valid_too() -> None:
    kinds = [type(part) for part in parse_scene(uncommented(TEMPLATE)).constraints]
    assert kinds == [KeyFrame, Pin, Orientation, KeyTrajectory]


def test_every_part_arrives() -> None:
    scene = parse_scene(
        HEAD + "[solver]\niterations = 7\ndamping = 0.8\ndamping_unit = 'centimetre'\n"
        "[[key_frame]]\nbody = 'a'\npoint = [0.1, 0, 0]\nframe = 2\nto = [1, 2, 3]\naxes = 'z'\n"
        "[[pin]]\nbody = 'b'\nframes = [0, 1]\nturned = true\nlevel = 2\n"
        "[[orientation]]\nbody = 'c'\nframe = 4\nto_deg = [0, 0, 90]\n"
        "[[key_trajectory]]\nbody = 'd'\nkeys = [{frame = 1, at = [0, 0, 1]}]\nrelative = true\n"
        "ease_in = 3\nease_out = 4\ntension = 0.1\ncontinuity = 0.2\nbias = 0.3\n"
    )
    assert scene.options == SolverOptions(7, 0.8, "centimetre")
    key, pin, turn, path = scene.constraints
    assert isinstance(key, KeyFrame)
    assert (key.position, key.axes, key.effector.point) == ((1, 2, 3), "z", (0.1, 0, 0))
    assert isinstance(pin, Pin)
    assert (pin.frames, pin.turned, pin.level) == ((0, 1), True, 2)
    assert isinstance(turn, Orientation)
    assert turn.rotation is not None
    np.testing.assert_allclose(turn.rotation, from_expmap(np.array([0, 0, np.pi / 2])))
    assert isinstance(path, KeyTrajectory)
    assert path.keys == (Key(1, (0, 0, 1)),)
    assert (path.ease_in, path.ease_out, path.relative) == (3, 4, True)
    assert (path.tension, path.continuity, path.bias) == (0.1, 0.2, 0.3)


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("", FormatError, "schema"),
        ('schema = "armsyn-scene-2"', FormatError, "schema"),
        (HEAD, ConstraintError, "asks for nothing"),
        (HEAD + KEY + "colour = 1\n", FormatError, "colour"),
        (HEAD + KEY.replace("3", "3.5"), FormatError, r"key_frame\[0\].frame"),
        (HEAD + KEY + "to = [1, 2, 3]\n", ConstraintError, r"\[\[key_frame\]\] 1: hand: give"),
        (HEAD + KEY.replace("0.05", "nan"), ConstraintError, "three finite numbers"),
        (HEAD + KEY + "axes = 'w'\n", ConstraintError, "axes 'w'"),
        (HEAD + KEY + "level = 0\n", ConstraintError, "first priority is 1"),
        (HEAD + "[[pin]]\nbody = 'a'\nframes = []\n", ConstraintError, r"\[\[pin\]\] 1: .*frames"),
        (HEAD + KEY + "[solver]\npull = 2.0\n", ArmsynError, "pull"),
        ("= 3", FormatError, "not a scene"),
    ],
)
def test_what_is_wrong_is_one_line(
    tmp_path: Path, text: str, error: type[ArmsynError], words: str
) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(text or "\n")
    with pytest.raises(error, match=words) as refused:
        load_scene(path)
    assert str(refused.value).startswith(str(path))
    assert refused.value.exit_status == 2
    assert "\n" not in str(refused.value)


def test_a_missing_or_binary_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="cannot read it"):
        load_scene(tmp_path / "none.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FormatError, match="cannot read it"):
        load_scene(tmp_path / "binary.toml")


@given(st.text(max_size=60))
def test_any_text_is_a_scene_or_refused(text: str) -> None:
    for whole in (text, HEAD + text, HEAD + KEY + text):
        with contextlib.suppress(InputError):
            parse_scene(whole)
