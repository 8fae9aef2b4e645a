"""`armsyn score` on files and captures."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from armsyn.arm import load_arm
from armsyn.cli.bands import bands
from armsyn.cli.motion_sources import load_motion
from armsyn.cli.score import score
from armsyn.driver import Ending, Recording, save_recording
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


def test_every_item_of_a_score_is_published(files: tuple[str, str]) -> None:
    document = json.loads(run(*files, "--json").stdout)
    for key in (
        *("paper_distance_m", "paper_coverage", "paper_refusal", "held_distance_m"),
        *("normalised_distance_m", "log_movement_time_ratio", "distance_per_arm_length"),
        *("posture", "over_human_floor", "endpoint_error_m", "speed_r", "human_likeness"),
    ):
        assert key in document
    how = document["measured_how"]
    for key in ("rate_hz", "paper_rate_hz", "filter", "cutoff_hz", "cut_fraction_of_peak"):
        assert how[key] is not None
    assert how["joint_map"] == {"shoulder": "shoulder", "elbow": "elbow", "hand": "hand"}
    assert how["alignment"] == "none: positions as given"
    assert document["over_human_floor"] is None  # a file has no repeats


@pytest.mark.usefixtures("captures")
def test_a_repeat_of_a_captured_reach_is_set_over_the_human_floor() -> None:
    result = run("hug_mp:S01:1:R-3", "hug_mp:S01:2:R-3", "--json")
    document = json.loads(result.stdout)
    floor = document["human_floor"]
    assert floor["repeats"] == 9
    assert floor["distance_m"] < floor["repeat_distance_m"]
    assert document["over_human_floor"] == pytest.approx(
        document["held_distance_m"] / floor["distance_m"]
    )


def test_filter_and_cut_are_asked_for_and_said(files: tuple[str, str]) -> None:
    result = run(*files, "--json", "--cutoff", "none", "--cut", "0.1")
    how = json.loads(result.stdout)["measured_how"]
    assert (how["filter"], how["cutoff_hz"], how["cut_fraction_of_peak"]) == (None, None, 0.1)
    assert run(*files, "--cutoff", "-3").exit_code == 2
    assert run(*files, "--cut", "1").exit_code == 2


def test_landmarks_of_other_names_are_mapped_and_published(
    tmp_path: Path, files: tuple[str, str]
) -> None:
    path = str(tmp_path / "robot.csv")
    robot = dataclasses.replace(motion(1.0), landmark_names=("base", "j3", "gripper"))
    write_motion(path, robot)
    maps = ("--map", "shoulder=base", "--map", "elbow=j3", "--map", "hand=gripper")
    document = json.loads(run(files[0], path, *maps, "--json").stdout)
    assert document["held_distance_m"] == pytest.approx(0, abs=1e-6)
    assert document["measured_how"]["joint_map"] == {
        "shoulder": "base",
        "elbow": "j3",
        "hand": "gripper",
    }
    assert "hand (B: gripper)" in run(files[0], path, *maps).stdout
    for wrong, said in (
        (("--map", "hand"), "LANDMARK_OF_A=LANDMARK_OF_B"),
        (("--map", "hand=j9"), "no landmark j9"),
        (("--map", "palm=j3"), "no landmark palm"),
        (("--map", "hand=j3", "--map", "elbow=j3"), "twice"),
    ):
        assert said in str(run(files[0], path, *wrong).exception)


def test_a_robot_is_brought_home_by_calibration_poses_of_its_session(
    tmp_path: Path, files: tuple[str, str]
) -> None:
    turned = dataclasses.replace(motion(1.0), landmarks=_turned(motion(1.0)))
    poses = motion(1.0).between(60, 100)
    names = [str(tmp_path / name) for name in ("robot.npz", "ours.npz", "theirs.npz")]
    ours = dataclasses.replace(poses, source="ours")
    theirs = dataclasses.replace(poses, landmarks=_turned(poses), source="theirs")
    for name, one in zip(names, (turned, ours, theirs), strict=True):
        write_motion(name, one)
    raw = json.loads(run(files[0], names[0], "--json").stdout)
    home = json.loads(run(files[0], names[0], "--align", *names[1:], "--json").stdout)
    assert raw["held_distance_m"] > 0.3
    assert home["held_distance_m"] == pytest.approx(0, abs=1e-5)
    said = home["measured_how"]["alignment"]
    assert "one rigid transform for the session, from 41 calibration poses" in said
    trial = run(files[0], names[0], "--align", files[0], names[0]).exception
    assert "calibration poses must be others than the motion" in str(trial)
    for name in ("copy.npz", "copy.csv"):
        write_motion(tmp_path / name, turned)
        copied = run(files[0], names[0], "--align", names[1], str(tmp_path / name)).exception
        assert "hides where it went" in str(copied)


def _turned(one: Motion) -> np.ndarray:
    assert one.landmarks is not None
    quarter = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    return one.landmarks @ quarter + np.array([0.3, 0.2, -0.1])


def test_bands_are_made_and_scored_in(tmp_path: Path) -> None:
    names = []
    for number in range(6):
        names.append(str(tmp_path / f"m{number}.csv"))
        write_motion(names[-1], motion(1 + number / 10))
    out = tmp_path / "bands.json"
    made = CliRunner().invoke(
        bands, [*names, "--out", str(out), "--plot", str(tmp_path / "b.png"), "--json"]
    )
    assert made.exit_code == 0, made.exception
    document = json.loads(made.stdout)
    assert document["reaches"] == 6
    assert document["measures"]["movement_time_s"]["n"] == 6
    assert document["human_floor_m"] is None
    assert (tmp_path / "b.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((tmp_path / "bands.run.json").read_text())["schema"] == "armsyn-run-1"
    page = tmp_path / "page.html"
    result = run(names[0], names[5], "--bands", str(out), "--html", str(page))
    assert result.exit_code == 0, result.exception
    assert "within" in result.stdout
    assert f"page: {page}" in result.stdout
    assert page.read_text().startswith("<!doctype html>")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nothing", "--out", "b.json"], "neither a motion file"),
        (["--out", "b.json"], "Missing argument"),
        (["a.csv", "--out", "b.txt"], "is written as .json"),
        (["a.csv", "--out", "nowhere/b.json"], "does not exist"),
        (["a.csv", "--out", "b.json", "--plot", "b.gif"], "is written as .png"),
        (["a.csv", "a.csv", "--out", "b.json"], "named twice"),
        (["a.csv", "--out", "b.json"], "1 usable captures, a band needs 5"),
    ],
)
def test_bands_of_bad_input_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    write_motion(tmp_path / "a.csv", motion(1.0))
    result = CliRunner().invoke(bands, arguments)
    assert result.exit_code != 0
    assert said in (result.output + str(result.exception))
    assert not (tmp_path / "b.json").exists()


def test_a_drivers_recording_scores_its_measured_joints(tmp_path: Path) -> None:
    arm = load_arm("human7", calibrated=False)
    time = np.arange(0, 2, 0.005)
    phase = np.clip((time - 0.5) / 1.0, 0, 1)[:, None]
    share = 10 * phase**3 - 15 * phase**4 + 6 * phase**5
    measured = arm.rest + share * 0.4
    frames = measured.shape
    recording = Recording(
        arm="human7",
        port="/dev/ttyTEST",
        simulated=True,
        joint_names=arm.joint_names,
        rate_hz=200.0,
        time_s=time,
        commanded_rad=measured + 0.3,
        measured_rad=measured,
        velocity_rad_s=np.zeros(frames),
        current_a=np.zeros(frames),
        stale=np.zeros(frames, dtype=np.bool_),
        hardware_error=np.zeros(frames, dtype=np.uint8),
        events=(),
        ticks=time.size,
        missed_ticks=0,
        dropped_rows=0,
        command_success_rate=1.0,
        ending=Ending.COMPLETED,
    )
    save_recording(tmp_path / "run.npz", recording, arm)
    wanted = Motion(
        time,
        landmark_names=tuple(arm.landmarks),
        landmarks=arm.chain.positions(measured)[:, list(arm.landmark_frames)],
        source="wanted",
    )
    write_motion(tmp_path / "wanted.csv", wanted)
    result = run(str(tmp_path / "wanted.csv"), str(tmp_path / "run.npz"), "--json")
    assert result.exit_code == 0, result.exception
    document = json.loads(result.stdout)
    assert document["held_distance_m"] == pytest.approx(0, abs=1e-6)
    assert document["human_likeness"]["other"]["variance_1_component"] == pytest.approx(1)
