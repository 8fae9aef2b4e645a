"""`armsyn score` on files and captures."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from armsyn.cli.motion_sources import load_motion
from armsyn.cli.score import score
from armsyn.errors import ArmsynError, CaptureError, FormatError
from armsyn.motion import Motion
from armsyn.motion.formats import write_motion


def motion(duration: float) -> Motion:
    time = np.arange(0, duration + 1, 0.01)
    phase = np.clip((time - 0.5) / duration, 0, 1)
    share = 10 * phase**3 - 15 * phase**4 + 6 * phase**5
    hand = np.array([0.2, -0.1, -0.4]) + np.outer(share, [0.2, 0.1, 0.2])
    elbow = np.broadcast_to([0.0, -0.1, -0.3], hand.shape)
    landmarks = np.stack([np.zeros_like(hand), elbow, hand], axis=1)
    names = ("shoulder", "elbow", "hand")
    return Motion(time=time, landmark_names=names, landmarks=landmarks, source=f"{duration} s")


@pytest.fixture
def files(tmp_path: Path) -> tuple[str, str]:
    write_motion(tmp_path / "a.csv", motion(1.0))
    write_motion(tmp_path / "b.npz", motion(1.2))
    return str(tmp_path / "a.csv"), str(tmp_path / "b.npz")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(score, arguments)


def test_json_is_one_document(files: tuple[str, str]) -> None:
    result = run(*files, "--json")
    assert result.exit_code == 0
    document = json.loads(result.stdout)
    assert (document["a"], document["b"]) == files
    assert (document["captured"], document["other"]) == ("1.0 s", "1.2 s")
    assert document["held_distance_m"] > 0.005
    assert document["log_movement_time_ratio"] == pytest.approx(np.log(1.2), abs=0.01)
    assert document["captured_profile"]["speed_peaks"] == 1


def test_the_table_is_for_people(files: tuple[str, str]) -> None:
    result = run(*files)
    assert result.exit_code == 0
    for text in ("held distance", "paper's distance", "time to peak", "1.2 s"):
        assert text in result.stdout


@pytest.mark.usefixtures("captures")
def test_captured_reaches_are_named() -> None:
    result = run("garza:ForwardHigh", "garza:ForwardHigh", "--json")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["held_distance_m"] == 0


@pytest.mark.usefixtures("captures")
@pytest.mark.parametrize("name", ["garza:Nowhere", "hug_mp:S01"])
def test_captures_that_are_not_one_are_refused(name: str) -> None:
    with pytest.raises(CaptureError):
        load_motion(name)


@pytest.mark.parametrize(
    ("name", "match"),
    [
        ("absent.csv", r"absent\.csv: cannot read it"),
        ("reach.xlsx", "neither a motion file .* nor a captured reach"),
        ("other:Place", "neither a motion file"),
    ],
)
def test_what_cannot_be_read_is_one_line_with_exit_status_2(name: str, match: str) -> None:
    with pytest.raises(FormatError, match=match) as caught:
        load_motion(name)
    assert caught.value.exit_status == 2
    assert "\n" not in str(caught.value)


def test_angles_alone_are_refused_with_what_to_do(tmp_path: Path, files: tuple[str, str]) -> None:
    path = tmp_path / "angles.csv"
    write_motion(path, Motion(np.arange(9.0), ("elbow",), np.zeros((9, 1)), source="angles"))
    error = run(files[0], str(path)).exception
    assert isinstance(error, ArmsynError)
    assert error.exit_status == 2
    assert "only joint angles" in str(error)
    assert "forward kinematics" in str(error)
