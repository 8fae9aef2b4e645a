"""`armsyn stream` and `armsyn record` on simulated arms, end to end."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from armsyn.arm import load_arm
from armsyn.driver import Ending, load_recording, straight_way
from armsyn.errors import InputError
from armsyn.motion import Motion
from armsyn.motion.formats import write_motion
from firmware_sim.testing import running
from tests.cli.commands import Outcome

Call = Callable[..., Outcome]
RATE = ("--rate", "50")
"""Slow enough for any machine that tests run on."""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A way of human7 that starts away from rest."""
    arm = load_arm("human7")
    start, goal = arm.rest.copy(), arm.rest.copy()
    start[3] += 0.2
    goal[3] += 0.5
    write_motion(tmp_path / "way.npz", straight_way(start, goal, arm, 200.0))
    return tmp_path / "way.npz"


def test_a_dry_run_says_what_to_expect_and_starts_nothing(call: Call, file: Path) -> None:
    said = call("stream", file, "--dry-run")
    assert said.status == 0, said.err
    lines = said.out.splitlines()
    assert lines[0].startswith(f"{file}: the file's angles, ")
    elbow = next(line for line in lines if line.startswith("  elbow_flexion: "))
    assert "43.7 to 60.8 degrees" not in lines[0]
    assert "% of its speed" in elbow
    assert lines[-1] == "all checks passed; nothing has moved (dry run)"
    assert "simulated" not in said.out


def test_a_dry_run_as_json_has_rates_and_the_nearest(call: Call, file: Path) -> None:
    slow = call("stream", file, "--dry-run", "--slower", "2", "--json").document
    fast = call("stream", file, "--dry-run", "--json").document
    assert slow["duration_s"] == pytest.approx(2 * fast["duration_s"], abs=0.02)
    elbow = [document["joints"]["elbow_flexion"]["speed_rad_s"] for document in (fast, slow)]
    assert elbow[1] == pytest.approx(0.5 * elbow[0], rel=0.02)
    assert set(fast["nearest"]) == {"first", "second", "distance_m"}
    long = call("stream", file, "--dry-run", "--duration", "3", "--json").document
    assert long["duration_s"] == pytest.approx(3.0, abs=0.01)


def test_a_dry_run_on_an_arm_looks_at_the_way_there(call: Call, file: Path) -> None:
    with running(arguments=("--arm", "human7")) as port:
        said = call("stream", file, "--dry-run", "--port", port, "--arm", "human7")
    assert said.status == 0, said.err
    assert "before it: a straight way of " in said.out


@pytest.mark.parametrize("where", [(), ("--own-process",)], ids=["here", "own process"])
def test_a_file_is_streamed_and_recorded(
    call: Call, file: Path, tmp_path: Path, where: tuple[str, ...]
) -> None:
    out = tmp_path / "out.npz"
    said = call("stream", file, *RATE, *where, "--record", out, "--json")
    assert said.status == 0, said.err
    document = said.document
    assert document["hand_error_m"] < 0.005
    assert document["ending"] == Ending.COMPLETED.value
    recording = load_recording(out)
    assert recording.simulated
    assert recording.commanded_rad[-1, 3] == pytest.approx(load_arm("human7").rest[3] + 0.5)
    again = call("stream", out, "--dry-run")
    assert "what was wanted of the arm" in again.out


def test_what_cannot_be_written_is_in_the_document(
    call: Call, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, *_: object) -> None:
        raise InputError(f"{path}: cannot be written: no space left on device")

    monkeypatch.setattr("armsyn.cli.stream_report.save_recording", full)
    said = call("stream", file, *RATE, "--record", tmp_path / "out.npz", "--json")
    assert said.status == 2
    assert said.document["ending"] == Ending.COMPLETED.value
    assert said.document["record"] is None
    assert "no space left" in said.document["error"]["message"]


def test_it_can_park(call: Call, file: Path) -> None:
    said = call("stream", file, *RATE, "--park", "--slower", "1.5")
    assert said.status == 0, said.err
    assert "ended: parked, torque off" in said.out


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        (("--duration", "0.1"), 4, "would have a speed of"),
        (("--slower", "0.5"), 2, "--slower must be at least 1"),
        (("--slower", "0"), 2, "--slower must be at least 1"),
        (("--slower", "1e200"), 2, "--slower must be at most 1000000, got 1e+200"),
        (("--slower", "2", "--duration", "2"), 2, "either --slower or --duration"),
        (("--duration", "-1"), 2, "times its time"),
        (("--arm", "koch"), 2, "joints are"),
        (("--record", "out.txt"), 2, "recordings are written as .npz or .csv"),
        (("--port", "/dev/none"), 2, "--port needs --arm"),
    ],
)
def test_what_is_refused(
    call: Call, file: Path, arguments: tuple[str, ...], status: int, said: str
) -> None:
    call("stream", file, *arguments).refused(status, said)


def test_files_that_cannot_be_streamed(call: Call, tmp_path: Path) -> None:
    call("stream", tmp_path / "none.npz").refused(2, "cannot read it")
    hand = Motion(np.arange(3) / 10.0, landmark_names=("hand",), landmarks=np.zeros((3, 1, 3)))
    write_motion(tmp_path / "hand.npz", hand)
    call("stream", tmp_path / "hand.npz").refused(2, "landmark positions only")


def test_record_writes_nothing_to_the_servos(call: Call, tmp_path: Path) -> None:
    out = tmp_path / "seen.npz"
    said = call("record", "--seconds", "0.5", *RATE, "--out", out, "--json")
    assert said.status == 0, said.err
    document = json.loads(said.out)
    assert document["simulated"] is True
    assert document["ticks"] + document["missed_ticks"] == 25
    recording = load_recording(out)
    assert recording.ending is Ending.OBSERVED
    assert recording.measured_rad[-1] == pytest.approx(load_arm("human7").rest, abs=0.01)
    assert "Nothing is written to the servos" in said.err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--out", "seen.txt"), "recordings are written as .npz or .csv"),
        (("--out", "no/seen.npz"), "does not exist"),
        (("--out", "seen.npz", "--seconds", "-1"), "is no time to record"),
    ],
)
def test_what_record_refuses(
    call: Call,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    found = call("record", *arguments)
    assert found.status == 2
    assert said in found.err
    assert list(tmp_path.iterdir()) == []
