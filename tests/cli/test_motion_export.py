"""`armsyn motion convert` to other programs' formats, as a user meets it."""

import dataclasses
import json
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from armsyn.arm import load_arm
from armsyn.cli.motion_convert import convert
from armsyn.driver.recording import Ending, Recording
from armsyn.driver.recording_files import save_recording
from armsyn.motion import Motion
from armsyn.motion.formats import read_body, write_motion
from tests.cli.commands import refused_by, said_by

ARM = "koch"
FRAMES = 40

OF_SERVOS = "currents, temperatures, voltages, marks of lost replies, hardware errors"
BESIDE = (
    f"what was commanded, what the servos were sent, velocities, {OF_SERVOS}, events,"
    " the arm's name, the port, how it ended"
)

said, refused = partial(said_by, convert), partial(refused_by, convert)


def recording(observed: bool = False) -> Recording:
    """A run of a simulated arm whose ticks came a little late."""
    arm = load_arm(ARM, calibrated=False)
    random = np.random.default_rng(2)
    time = np.arange(FRAMES) / 100 + random.uniform(0, 1e-4, FRAMES)
    measured = arm.rest + 0.1 * np.sin(3 * time)[:, None]
    nothing = np.full_like(measured, np.nan)
    return Recording(
        arm=ARM,
        port="/dev/pts/7",
        simulated=True,
        joint_names=arm.joint_names,
        rate_hz=100.0,
        time_s=time,
        commanded_rad=nothing if observed else measured + 0.01,
        measured_rad=measured,
        velocity_rad_s=np.cos(measured),
        current_a=nothing,
        stale=np.zeros(measured.shape, dtype=np.bool_),
        hardware_error=np.zeros(measured.shape, dtype=np.uint8),
        events=(),
        ticks=FRAMES,
        missed_ticks=0,
        dropped_rows=0,
        command_success_rate=1.0,
        ending=Ending.OBSERVED if observed else Ending.COMPLETED,
    )


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """Recordings of an arm, driven (npz and CSV) and observed, a plan, and landmarks only."""
    arm = load_arm(ARM, calibrated=False)
    driven = recording()
    save_recording(tmp_path / "driven.npz", driven, arm)
    save_recording(tmp_path / "driven.csv", driven, arm)
    save_recording(tmp_path / "watched.npz", recording(observed=True), arm)
    measured = driven.measured_motion(arm)
    plan = Motion(
        np.arange(FRAMES) / 100, measured.joint_names, measured.angles, source=f"planned for {ARM}"
    )
    write_motion(tmp_path / "plan.npz", plan)
    hand = Motion(measured.time, (), None, measured.landmark_names, measured.landmarks, "hands")
    write_motion(tmp_path / "hand.npz", hand)
    return tmp_path


def states(path: Path) -> tuple[dict[str, str], list[list[float]], list[list[float]]]:
    """Facts, what was told and what was measured in a bag of one episode."""
    facts, told, measured = {}, [], []
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            if channel.topic == "/episode":
                facts = json.loads(message.data)
            elif channel.topic == "/joint_trajectory":
                told = [list(point.positions) for point in message.points]
            else:
                measured.append(list(message.position))
    return facts, told, measured


@pytest.mark.parametrize("suffix", ["npz", "csv"])
def test_a_recording_keeps_what_was_commanded(files: Path, suffix: str) -> None:
    text = said(files / f"driven.{suffix}", files / "a.mcap")
    assert f"1 episode (1 recorded), {FRAMES} frames, 5 joints" in text
    assert "left out: 1 landmarks" in text
    facts, told, measured = states(files / "a.mcap")
    np.testing.assert_array_equal(measured, recording().measured_rad)
    np.testing.assert_array_equal(told, recording().commanded_rad)
    assert facts["source"] == "recording of simulated koch on /dev/pts/7"
    if suffix == "npz":
        assert (facts["port"], facts["simulated"], facts["ending"]) == (
            *("/dev/pts/7", "yes"),
            "completed",
        )


@pytest.mark.parametrize(
    ("source", "out", "lost"),
    [
        ("driven.npz", "a.npz", [BESIDE]),
        ("driven.npz", "a.csv", [BESIDE]),
        ("driven.npz", "a.trc", [BESIDE, "5 joint angles"]),
        (
            *("driven.csv", "a.npz"),
            [f"what was commanded, what the servos were sent, velocities, {OF_SERVOS}"],
        ),
        (
            *("driven.csv", "a.mcap"),
            ["1 landmarks", f"what the servos were sent, velocities, {OF_SERVOS}"],
        ),
        (
            *("driven.npz", "a.mcap"),
            ["1 landmarks", f"what the servos were sent, {OF_SERVOS}, events"],
        ),
        ("driven.npz", "a.parquet", [f"what the servos were sent, {OF_SERVOS}, events"]),
        (
            *("driven.npz", "a.lerobot"),
            ["1 landmarks", f"what the servos were sent, velocities, {OF_SERVOS}, events"],
        ),
        (
            *("table.parquet", "a.csv"),
            ["what was commanded, velocities, the arm's name, the port, how it ended, the task"],
        ),
        ("table.parquet", "a.mcap", ["1 landmarks"]),
        ("table.parquet", "a.lerobot", ["1 landmarks", "velocities"]),
        ("plan.npz", "a.csv", []),
        ("plan.npz", "a.mcap", []),
    ],
)
def test_what_a_recording_loses_is_said(
    files: Path, source: str, out: str, lost: list[str]
) -> None:
    said(files / "driven.npz", files / "table.parquet", "--task", "wave")
    document = json.loads(said(files / source, files / out, "--json"))
    assert document["left_out"] == lost


def test_plans_and_observed_arms_say_what_they_are(files: Path) -> None:
    said(files / "plan.npz", files / "a.mcap")
    facts, told, measured = states(files / "a.mcap")
    assert facts["kind"] == "planned"
    assert told == measured
    said(files / "watched.npz", files / "a.mcap")
    facts, told, measured = states(files / "a.mcap")
    assert facts["kind"] == "observed"
    assert told == []
    np.testing.assert_array_equal(measured, recording().measured_rad)


def test_the_target_of_a_recorded_reach_is_passed_on(files: Path) -> None:
    target = (0.2, -0.05, 0.1)
    reach = dataclasses.replace(recording(), target_m=target)
    save_recording(files / "reach.npz", reach, load_arm(ARM, calibrated=False))
    said(files / "reach.npz", files / "a.mcap", "--resample", 50)
    assert states(files / "a.mcap")[0]["target_m"] == list(target)
    said(files / "reach.npz", files / "a.parquet")
    for source in ("reach.npz", "a.parquet"):
        out = files / f"{source}.lerobot"
        said(files / source, out)
        frames = pq.read_table(out / "data/chunk-000/file-000.parquet")
        places = np.array(frames["observation.environment_state"].to_pylist())
        np.testing.assert_array_equal(places, np.tile(np.float32(target), (len(places), 1)))
    assert "events, the target, the arm's name" in said(files / "reach.npz", files / "a.csv")
    refusal = refused(files / "reach.npz", files / "driven.npz", files / "b.lerobot")
    assert "has no target, unlike the first motion" in refusal


def test_many_files_become_one_dataset(files: Path) -> None:
    out = files / "d.lerobot"
    text = said(
        files / "driven.npz", files / "watched.npz", files / "plan.npz", out, "--task", "wave"
    )
    assert "3 episodes (1 recorded, 1 observed, 1 planned), 120 frames, 5 joints" in text
    assert "100 frames a second, degrees; 2 interpolated to that rate" in text
    assert json.loads((out / "meta" / "info.json").read_text())["robot_type"] == ARM
    assert pq.read_table(out / "meta" / "tasks.parquet")["task"].to_pylist() == ["wave"]
    found = json.loads(
        said(
            *(files / "plan.npz", files / "n.lerobot", "--units", "normalised", "--arm", ARM),
            "--json",
        )
    )
    assert (found["kinds"], found["units"], found["fps"]) == ({"planned": 1}, "normalised", 100)
    ranges = json.loads((files / "n.lerobot" / "meta" / "armsyn.json").read_text())["ranges"]
    joint = load_arm(ARM, calibrated=False).joint[1]
    assert ranges[joint.name] == [joint.lower, joint.upper]


def test_what_a_file_leaves_open_is_said(files: Path) -> None:
    (files / "log.csv").write_text("time,shoulder_pan,shoulder_lift\n0.0,0.1,0.2\n0.1,0.2,0.3\n")
    out = files / "a.lerobot"
    assert "unit: rad (assumed)" in said(files / "log.csv", out, "--joints", ARM)
    found = json.loads(said(files / "log.csv", files / "b.mcap", "--joints", ARM, "--json"))
    assert found["assumed"]["unit"] == "rad (assumed)"
    facts, told, _ = states(files / "b.mcap")
    assert facts["unit"] == "rad (assumed)"
    assert (facts["kind"], told) == ("motion", [[0.1, 0.2], [0.2, 0.3]])
    with_degrees = said(files / "log.csv", files / "c.mcap", "--joints", ARM, "--unit", "deg")
    assert "assumed" not in with_degrees
    np.testing.assert_allclose(states(files / "c.mcap")[1], np.deg2rad(told))


def test_a_recording_knows_its_arm(files: Path) -> None:
    said(files / "driven.npz", files / "n.lerobot", "--units", "normalised")
    ranges = json.loads((files / "n.lerobot" / "meta" / "armsyn.json").read_text())["ranges"]
    assert set(ranges) == set(load_arm(ARM, calibrated=False).joint_names)
    own = dataclasses.replace(recording(), arm="garage")
    save_recording(files / "own.npz", own, load_arm(ARM, calibrated=False))
    text = said(files / "own.npz", files / "own.lerobot")
    assert "joints are taken to turn, not to slide: no garage.toml" in text
    assert json.loads((files / "own.lerobot/meta/info.json").read_text())["robot_type"] == "garage"
    assert "no garage.toml" in refused(
        files / "own.npz", files / "two.lerobot", "--units", "normalised"
    )


def test_a_table_of_a_recording_and_back(files: Path) -> None:
    said(files / "driven.npz", files / "a.parquet")
    table = pq.read_table(files / "a.parquet")
    assert "elbow_flex:commanded_rad" in table.column_names
    said(files / "a.parquet", files / "back.npz")
    said(files / "driven.npz", files / "same.npz")
    assert (files / "back.npz").read_bytes() == (files / "same.npz").read_bytes()
    said(files / "a.parquet", files / "again.parquet")
    assert (files / "again.parquet").read_bytes() == (files / "a.parquet").read_bytes()
    said(files / "a.parquet", files / "a.mcap", "--resample", 50, "--task", "wave")
    facts, told, measured = states(files / "a.mcap")
    assert (facts["kind"], facts["port"], facts["task"]) == ("recorded", "/dev/pts/7", "wave")
    np.testing.assert_allclose(np.subtract(told, measured), 0.01, atol=1e-9)


def test_changes_reach_what_was_commanded(files: Path) -> None:
    said(files / "driven.npz", files / "a.mcap", "--resample", 50)
    _, told, measured = states(files / "a.mcap")
    assert len(told) == len(measured) == 20
    np.testing.assert_allclose(np.subtract(told, measured), 0.01, atol=1e-9)


def test_an_arm_becomes_a_skeleton(files: Path) -> None:
    text = said(files / "driven.npz", files / "a.bvh", "--resample", 100)
    assert "8 landmarks" in text
    (left_out,) = (line for line in text.splitlines() if "left out" in line)
    assert left_out == f"{files / 'a.bvh'}: left out: {BESIDE}"
    body = read_body(files / "a.bvh")
    chain = load_arm(ARM, calibrated=False).chain
    expected = chain.positions(recording().measured_rad[:1])
    assert np.abs(body.positions()[:1, 1:-1] - expected).max() < 1e-6
    said(files / "plan.npz", files / "b.bvh", "--arm", ARM)
    assert read_body(files / "b.bvh").skeleton.names == body.skeleton.names


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("hand.npz", "a.mcap"), "no joint angles in it, only landmarks"),
        (
            ("driven.npz", "hand.npz", "a.parquet"),
            "has the joints none; the first has shoulder_pan",
        ),
        (("driven.npz", "absent.npz", "a.lerobot"), "absent.npz: cannot read it"),
        (("driven.npz", "plan.npz", "a.csv"), "holds one motion: name one file"),
        (("driven.npz", "a.csv", "--task", "wave"), "--task and --units are for .lerobot"),
        (("driven.npz", "a.mcap", "--units", "degrees"), "--units and --arm are for .lerobot"),
        (("driven.npz", "a.mcap", "--arm", ARM), "--units and --arm are for .lerobot"),
        (("driven.npz", "a.csv", "--arm", ARM), "--arm is for .bvh and .lerobot"),
        (("plan.npz", "a.lerobot", "--units", "normalised"), "need the range of every joint"),
        (("plan.npz", "a.lerobot", "--arm", "nobody"), "nobody.toml"),
        (("driven.npz", "a.lerobot", "--arm", "human7"), "has joints that human7 has not: elbow_"),
        (("driven.npz", "a.bvh"), "resample the motion to an even rate"),
        (("plan.npz", "a.bvh"), "--arm NAME makes one"),
        (("plan.npz", "a.bvh", "--arm", "human7"), "no angles of shoulder_flexion"),
        (("plan.npz", "a.bvh", "--arm", "nobody"), "nobody.toml"),
        (("hand.npz", "a.bvh", "--arm", ARM), "no angles of shoulder_pan"),
        (("driven.npz", "absent/a.mcap"), "cannot write it"),
        (("driven.npz", "a.xyz"), "no motion format has the suffix '.xyz'"),
        (("plan.npz", "a.lerobot", "--resample", "7.5"), "7.5 Hz is no whole number"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(
    files: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], words: str
) -> None:
    monkeypatch.chdir(files)
    before = sorted(files.iterdir())
    assert words in refused(*arguments)
    assert sorted(files.iterdir()) == before


@pytest.mark.parametrize("out", ["driven.npz", "./driven.npz", "link.npz", "link.mcap"])
def test_what_is_read_is_never_written_over(
    files: Path, monkeypatch: pytest.MonkeyPatch, out: str
) -> None:
    monkeypatch.chdir(files)
    for link in ("link.npz", "link.mcap"):
        (files / link).symlink_to("driven.npz")
    before = {path: path.read_bytes() for path in files.iterdir()}
    sources = ("plan.npz", "driven.npz") if out.endswith(".mcap") else ("driven.npz",)
    assert f"{Path(out)}: is a file to read" in refused(*sources, out)
    assert {path: path.read_bytes() for path in files.iterdir()} == before
    assert (files / "link.npz").is_symlink()


def test_a_take_is_never_written_over_its_file(
    files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(files)
    said("driven.npz", "a.parquet")
    assert "a.parquet: is a file to read" in refused("a.parquet#0", "a.parquet")
