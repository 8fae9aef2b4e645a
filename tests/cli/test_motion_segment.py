"""`armsyn motion segment`: what it says, writes and refuses."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from armsyn.arm.description import load_arm
from armsyn.driver import Ending, Recording, save_recording
from armsyn.motion import Motion
from armsyn.motion.formats import read_motion, write_motion
from tests.cli.commands import Outcome

Call = Callable[..., Outcome]


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """A reach of 0.4 m, 1 s of rest, its way back, and one of 0.1 m."""
    phase = np.linspace(0, 1, 101)
    reach = 10 * phase**3 - 15 * phase**4 + 6 * phase**5
    along = np.concatenate(
        [
            *(np.zeros(50), 0.4 * reach, np.full(100, 0.4), 0.4 * reach[::-1], np.zeros(100)),
            *(0.1 * reach, np.full(50, 0.1)),
        ]
    )
    landmarks = np.zeros((along.size, 2, 3))
    landmarks[:, 1, 0] = along
    landmarks[:, 0, 2] = 0.3
    motion = Motion(
        np.arange(along.size) / 100, landmark_names=("elbow", "hand"), landmarks=landmarks
    )
    write_motion(tmp_path / "made.csv", motion)
    return tmp_path / "made.csv"


def test_movements_and_reasons(call: Call, recording: Path, tmp_path: Path) -> None:
    out, plot = tmp_path / "out", tmp_path / "speed.png"
    outcome = call("motion", "segment", recording, "--json", "--out", out, "--plot", plot)
    assert outcome.status == 0, outcome.err
    document = outcome.document
    first, back, small = document["movements"]
    assert first["onset_s"] == pytest.approx(0.56, abs=0.02)
    assert first["duration_s"] == pytest.approx(0.881, abs=0.03)
    assert [one["usable"] for one in (first, back, small)] == [True, True, False]
    assert small["reason"] == "0.100 m from onset to offset, under 0.25"
    assert (document["usable"], document["landmark"]) == (2, ["hand"])
    assert plot.stat().st_size > 10_000
    assert document["written"] == [str(out / "made.csv-1.npz"), str(out / "made.csv-2.npz")]
    cut = read_motion(out / "made.csv-1.npz")
    assert cut.frames == first["last_frame"] - first["first_frame"] + 1
    assert np.ptp(cut.hand[:, 0]) == pytest.approx(0.4, abs=0.01)


def test_what_is_written_ends_with_the_landmark_that_was_asked_for(
    call: Call, recording: Path, tmp_path: Path
) -> None:
    motion = read_motion(recording)
    assert motion.landmarks is not None
    turned = Motion(motion.time, (), None, ("wrist", "elbow"), motion.landmarks[:, ::-1])
    write_motion(tmp_path / "turned.npz", turned)
    for landmark, names, half in (("wrist", ("elbow", "wrist"), 1), ("wrist+elbow", None, 2)):
        least = ("--least", "0.15", "--landmark", landmark)
        outcome = call(
            *("motion", "segment", tmp_path / "turned.npz", *least),
            *("--json", "--out", tmp_path / "out"),
        )
        cut = read_motion(outcome.document["written"][0])
        assert cut.landmark_names == (names or ("wrist", "elbow", "wrist+elbow"))
        assert np.ptp(cut.hand[:, 0]) == pytest.approx(0.4 / half, abs=0.01)


def test_takes_whose_names_end_alike_are_written_beside_each_other(
    call: Call, recording: Path, tmp_path: Path
) -> None:
    motion = read_motion(recording)
    root = motion.hand
    takes = ("first/reach", "second/reach", "second/Reach")
    arrays: dict[str, np.ndarray] = {
        "joint": np.array(["hand"]),
        "parent": np.array([-1]),
        "offset": np.zeros((1, 3)),
        "prerot_xyzw": np.array([[0.0, 0, 0, 1]]),
        "motions": np.array(takes),
    }
    for take in takes:
        arrays[f"{take}|t"] = motion.time
        arrays[f"{take}|expmap"] = np.zeros((motion.frames, 1, 3))
        arrays[f"{take}|root"] = root
    np.savez(tmp_path / "bodies.npz", allow_pickle=False, **arrays)
    out = tmp_path / "out"
    call("motion", "segment", tmp_path / "bodies.npz", "--out", out)
    assert sorted(path.name for path in out.iterdir()) == sorted(
        f"{name}-{number}.npz" for name in ("reach", "reach-2", "Reach-3") for number in (1, 2)
    )


def test_options_reach_the_search(call: Call, recording: Path) -> None:
    everything = call("motion", "segment", recording, "--least", "0.05").out
    assert "3 of 3 movements are usable" in everything
    wide = call("motion", "segment", recording, "--json", "--threshold", "0.3").document
    narrow = call("motion", "segment", recording, "--json").document
    assert wide["movements"][0]["duration_s"] < narrow["movements"][0]["duration_s"]


def test_a_robots_recording_is_cut_at_its_measured_speed(call: Call, tmp_path: Path) -> None:
    """Ticks of 4096 a turn at 200 Hz, with a lost reply; the arm goes out and, later, back."""
    arm = load_arm("human7")
    phase = np.linspace(0, 1, 241)
    reach = 10 * phase**3 - 15 * phase**4 + 6 * phase**5
    share = np.concatenate([np.zeros(60), reach, np.ones(100), reach[::-1], np.zeros(60)])
    commanded = arm.rest + share[:, None] * np.array([0.5, 0.4, 0.2, 0.6, 0.1, 0.1, 0.1])
    tick = 2 * np.pi / 4096
    ticks, joints = commanded.shape
    stale = np.zeros((ticks, joints), dtype=np.bool_)
    stale[150, 2] = True
    recording = Recording(
        arm="human7",
        port="/dev/ttyTEST",
        simulated=True,
        joint_names=arm.joint_names,
        rate_hz=200.0,
        time_s=np.arange(ticks) / 200.0,
        commanded_rad=commanded,
        measured_rad=np.round(commanded / tick) * tick,
        velocity_rad_s=np.zeros((ticks, joints)),
        current_a=np.zeros((ticks, joints)),
        stale=stale,
        hardware_error=np.zeros((ticks, joints), dtype=np.uint8),
        events=(),
        ticks=ticks,
        missed_ticks=0,
        dropped_rows=0,
        command_success_rate=1.0,
        ending=Ending.COMPLETED,
    )
    for name in ("recorded.npz", "recorded.csv"):
        save_recording(tmp_path / name, recording, arm)
        out, back = call("motion", "segment", tmp_path / name, "--json").document["movements"]
        assert out["usable"]
        assert back["usable"]
        assert out["speed_peaks"] == back["speed_peaks"] == 1
        assert out["onset_s"] == pytest.approx(0.3 + 1.2 * 0.06, abs=0.03)
        assert out["duration_s"] == pytest.approx(1.2 * 0.88, abs=0.06)
        assert back["onset_s"] == pytest.approx(2.0 + 1.2 * 0.06, abs=0.03)


def test_refusals(call: Call, recording: Path, tmp_path: Path) -> None:
    call("motion", "segment", recording, "--landmark", "toe").refused(2, "toe", "elbow, hand")
    call("motion", "segment", recording, "--landmark", "elbow").refused(2, "does not move")
    call("motion", "segment", tmp_path / "none.csv").refused(2, "none.csv")
    call("motion", "segment", recording, "--threshold", "1").refused(2, "threshold")
    call("motion", "segment", recording, "--out", recording).refused(2, "made.csv")
    call("motion", "segment", recording, "--plot", tmp_path / "x.nothing").refused(2, "plot")


def test_a_set_of_captures_and_all_takes(call: Call, captures: Path) -> None:
    reach = call("motion", "segment", "garza:ForwardHigh", "--json").document
    assert [one["motion"] for one in reach["movements"]] == ["garza:ForwardHigh"]
    whole = call(
        *("motion", "segment", captures / "reach" / "garza" / "reach.npz"),
        *("--landmark", "JtWristRt", "--json"),
    ).document
    assert len({one["motion"] for one in whole["movements"]}) == 35
    ulema = captures / "reach" / "ulema" / "HTH1.c3d"
    call("motion", "segment", ulema).refused(2, "which of its landmarks is the hand")
    middle = call("motion", "segment", ulema, "--landmark", "LRS+LUS", "--json").document
    assert len(middle["movements"]) == 8
    golf = f"{captures}/golf/gears.npz#swing01"  # its landmarks are markers
    joint = call("motion", "segment", golf, "--landmark", "left_wrist", "--cutoff", "20", "--json")
    back, _ = joint.document["movements"]
    assert abs(back["last_frame"] - 181) <= 1  # the table's top of the swing
    call("motion", "segment", "garza:all", "--plot", "x.png").refused(2, "70 motions")
    call("motion", "segment", "garza:all", "--rate", "100").refused(2, "options")
