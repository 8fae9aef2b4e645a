"""`armsyn reach` on simulated arms, end to end."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread

from armsyn.arm import load_arm
from armsyn.driver import Ending, load_recording
from armsyn.motion.formats import read_motion
from tests.cli.commands import Outcome, run
from tests.kinematics.oracle import Oracle

pytestmark = pytest.mark.usefixtures("compiled")

Call = Callable[..., Outcome]
TARGET = ("--target", "0.35", "-0.1", "-0.15")
KEYS = (
    *("arm", "port", "simulated", "target_m", "hand_error_m", "movement_time_s", "speed_peaks"),
    *("time_to_peak", "peak_over_mean", "min_jerk_r", "sparc", "captured", "captured_r"),
    *("plan", "outside_m", "predicted_time_s", "planned_time_s", "planned_error_m"),
    *("time_scale", "tracking_rms_rad", "ticks", "missed_ticks", "command_success_rate", "record"),
)


def in_time(reach: Callable[[], Outcome]) -> dict[str, Any]:
    """Return the document of a reach that the host kept time in.

    The stream runs on the real clock: on a machine that is busy elsewhere ticks are skipped, the
    arm slows, and what is measured is the machine. Up to three attempts; then that is said.
    """
    for _ in range(3):
        said = reach()
        assert said.status == 0, said.err
        document = said.document
        assert document["hand_error_m"] < 0.005  # in time or not
        if document["missed_ticks"] <= 0.01 * document["ticks"]:
            return document
    pytest.skip("this machine is too busy to stream in time: 3 reaches missed over 1 % of ticks")


def test_the_main_job() -> None:
    said = run("reach", *TARGET, "--json")
    assert said.status == 0, said.err
    document = said.document
    assert set(KEYS) <= set(document)
    assert None not in [document[key] for key in KEYS if key != "record"]
    assert said.err.splitlines()[0].startswith(f"simulated human7 on {document['port']} ")
    told = [f"the target lies {document['outside_m'] * 100:.1f} cm outside the captured workspace"]
    assert said.err.splitlines()[1:] == told * (document["outside_m"] > 0.001)
    assert (document["arm"], document["simulated"], document["record"]) == ("human7", True, None)
    assert document["target_m"] == [0.35, -0.1, -0.15]
    assert document["hand_error_m"] < 0.005
    assert document["captured"].startswith("garza:")
    assert document["time_scale"] >= 1
    assert 0 < document["tracking_rms_rad"] < 0.1
    assert document["ticks"] + document["missed_ticks"] >= 200 * document["movement_time_s"]
    assert 0 <= document["command_success_rate"] <= 1
    assert document["ending"] == Ending.COMPLETED.value


def test_the_measured_reach_is_a_persons(call: Call) -> None:
    document = in_time(lambda: call("reach", *TARGET, "--json"))
    assert document["speed_peaks"] == 1
    assert 0.25 < document["time_to_peak"] < 0.65
    assert document["min_jerk_r"] > 0.6
    assert document["captured_r"] > 0.85


def test_a_plan_without_captures_with_the_hand_turned(call: Call, calibration: Path) -> None:
    """By an arm that has learned nothing."""
    for file in calibration.glob("*.json"):
        file.unlink()
    asked = ("--plan", "minjerk", "--pointing", "1", "0", "-1", "--calibration", calibration)
    said = call("reach", *TARGET, *asked, "--rate", "50", "--json")
    assert said.status == 0, said.err
    document = said.document
    assert (document["plan"], document["outside_m"], document["captured"]) == (
        "minjerk",
        None,
        None,
    )
    assert document["hand_error_m"] < 0.005
    assert document["orientation_error_rad"] < np.radians(3.0)
    pointing = document["orientation"]["pointing"]
    np.testing.assert_allclose(pointing, np.array([1.0, 0.0, -1.0]) / np.sqrt(2.0))
    assert document["planned_error_m"] < 0.001
    assert document["predicted_time_s"] * document["time_scale"] < document["planned_time_s"] + 0.02
    assert json.dumps(document, allow_nan=False)
    assert document["planned_speed_peaks"] >= 1
    assert "refused" not in document
    assert "first_refused" in document


def test_the_raw_controller_needs_nothing_learned(call: Call, calibration: Path) -> None:
    for file in calibration.glob("*.json"):
        file.unlink()
    said = call("reach", *TARGET, "--raw", "--calibration", calibration, "--rate", "50", "--json")
    assert said.status == 0, said.err
    assert (said.document["model"], said.document["captured"]) == ("A", None)
    assert said.document["hand_error_m"] < 0.005


def test_the_arm_is_moved_by_a_process_of_its_own(call: Call, tmp_path: Path) -> None:
    record = tmp_path / "reach.npz"
    said = call("reach", *TARGET, "--own-process", "--rate", "50", "--record", record, "--json")
    assert said.status == 0, said.err
    document = said.document
    assert document["hand_error_m"] < 0.005
    assert document["ending"] == Ending.COMPLETED.value
    recording = load_recording(record)
    assert recording.ticks == document["ticks"]
    assert recording.target_m == (0.35, -0.1, -0.15)


def test_there_and_back_with_recording_and_plot(call: Call, tmp_path: Path) -> None:
    record, plot = tmp_path / "reach.npz", tmp_path / "reach.png"
    said = call("reach", *TARGET, "--return", "--record", record, "--plot", plot)
    assert said.status == 0, said.err
    unusual = ("outside the captured workspace", "of every joint's way by minimum jerk")
    assert all(any(text in line for text in unusual) for line in said.err.splitlines())
    lines = said.out.splitlines()
    assert lines[0].startswith("simulated human7 on /dev/")
    assert [line.split(":")[0] for line in lines if not line.startswith(" ")][1:] == [
        *("reach", "return", "stream", "ended", "recording", "plot")
    ]
    arm, recording = load_arm("human7"), read_motion(record)
    assert recording.angles is not None
    assert recording.joint_names == arm.joint_names
    oracle = Oracle(arm.chain)
    hand = np.array([oracle.frames(q)[0][-1] for q in recording.angles])
    np.testing.assert_allclose(recording.hand, hand, atol=1e-6)
    rest = oracle.frames(arm.rest)[0][-1]
    assert np.linalg.norm(hand - [0.35, -0.1, -0.15], axis=1).min() < 0.005
    assert np.linalg.norm(hand[-1] - rest) < 0.005
    assert "simulated human7" in recording.source
    with np.load(record) as file:
        assert file["commanded_rad"].shape == recording.angles.shape
        assert np.abs(file["commanded_rad"] - recording.angles).max() < 0.2
        assert file["target_m"].tolist() == [0.35, -0.1, -0.15]
    picture = imread(plot)
    assert picture.shape[:2] == (540, 960)
    assert np.ptp(picture[..., :3]) > 0.9
    colours = {tuple(pixel) for pixel in (picture[..., :3].reshape(-1, 3) * 255).astype(int)}
    for drawn in ((31, 119, 180), (214, 39, 40), (153, 153, 153), (0, 0, 0)):
        assert drawn in colours  # planned, measured, captured, raw
    assert sorted(file.name for file in tmp_path.iterdir()) == ["reach.npz", "reach.png"]
    again = call("score", record, record, "--json")
    assert again.status == 0, again.err
    assert again.document["held_distance_m"] == 0


def test_parking_and_a_recording_as_text(call: Call, tmp_path: Path) -> None:
    record = tmp_path / "reach.csv"
    said = call("reach", *TARGET, "--park", "--record", record, "--json")
    assert said.status == 0, said.err
    assert said.document["ending"] == "parked, torque off"
    assert said.document["record"] == str(record)
    assert said.document["hand_error_m"] < 0.005
    recording = read_motion(record)
    assert recording.angles is not None
    np.testing.assert_allclose(recording.angles[-1], load_arm("human7").rest, atol=0.01)
    assert np.linalg.norm(recording.hand - [0.35, -0.1, -0.15], axis=1).min() < 0.005
    assert call("score", record, record, "--json").document["held_distance_m"] == 0


@pytest.mark.parametrize(
    ("arm", "target"),
    [("openmanipulator_x", (0.20, 0.08, 0.15)), ("koch", (-0.20, 0.08, 0.15))],
)
def test_the_other_arms(call: Call, arm: str, target: tuple[float, float, float]) -> None:
    said = call("reach", "--arm", arm, "--target", *target, "--return", "--json")
    assert said.status == 0, said.err
    document = said.document
    assert document["arm"] == arm
    for leg in (document, document["return"]):
        assert leg["hand_error_m"] < 0.005
        assert leg["speed_peaks"] >= 1


@pytest.mark.slow
def test_the_raw_controller_is_no_person(call: Call) -> None:
    said = call("reach", *TARGET, "--raw", "--json")
    assert said.status == 0, said.err
    assert said.document["model"] == "A"
    assert said.document["hand_error_m"] < 0.005
    assert said.document["captured_r"] < 0.4


def test_a_hand_that_is_there_already(call: Call, tmp_path: Path) -> None:
    arm, plot = load_arm("human7"), tmp_path / "still.png"
    rest = arm.chain.forward(arm.rest).tip
    said = call("reach", "--target", *rest, "--plot", plot, "--json")
    assert said.status == 0, said.err
    assert said.document["hand_error_m"] < 0.005
    assert imread(plot).shape[:2] == (540, 960)
    assert json.dumps(said.document, allow_nan=False)
