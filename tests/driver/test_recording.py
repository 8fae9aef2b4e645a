"""Recordings: what they say of the motion, and that files give the same back."""

import dataclasses
import errno
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from armsyn.arm import ArmDescription
from armsyn.driver import (
    Ending,
    Recording,
    check_recording_path,
    fingerprint,
    load_recording,
    save_recording,
)
from armsyn.driver.joints import JointState
from armsyn.driver.log import Event, StreamLog
from armsyn.errors import FormatError, InputError
from armsyn.motion.formats import read_motion, write_motion

TICKS = 50


@pytest.fixture
def recording(human7: ArmDescription) -> Recording:
    rng = np.random.default_rng(7)
    commanded = human7.rest + np.linspace(0.0, 0.3, TICKS)[:, None]
    stale = np.zeros((TICKS, 7), dtype=np.bool_)
    measured = commanded - 0.01
    stale[20:23, 3] = True
    measured[20:23, 3] = measured[19, 3]  # the last known
    return Recording(
        arm="human7",
        port="/dev/ttyTEST",
        simulated=True,
        joint_names=human7.joint_names,
        rate_hz=200.0,
        time_s=np.arange(TICKS) / 200.0,
        commanded_rad=commanded,
        measured_rad=measured,
        velocity_rad_s=rng.normal(size=(TICKS, 7)),
        current_a=np.where(np.arange(7) == 2, np.nan, 0.1) * np.ones((TICKS, 7)),
        stale=stale,
        hardware_error=np.zeros((TICKS, 7), dtype=np.uint8),
        events=(Event(0.1, "asked to stop: decelerating"),),
        ticks=TICKS,
        missed_ticks=1,
        dropped_rows=0,
        command_success_rate=0.97,
        ending=Ending.STOPPED_HOLDING,
    )


def test_lost_replies_are_interpolated(recording: Recording, human7: ArmDescription) -> None:
    motion = recording.measured_motion(human7)
    assert motion.angles == pytest.approx(recording.commanded_rad - 0.01)
    assert motion.time.tolist() == recording.time_s.tolist()


def test_landmarks_are_forward_kinematics(recording: Recording, human7: ArmDescription) -> None:
    motion = recording.measured_motion(human7)
    assert motion.landmark_names == ("shoulder", "elbow", "wrist", "hand")
    assert motion.angles is not None
    for frame in (0, TICKS - 1):
        assert motion.hand[frame] == pytest.approx(human7.chain.forward(motion.angles[frame]).tip)


def test_tracking_error_leaves_lost_replies_out(recording: Recording) -> None:
    assert recording.tracking_rms() == pytest.approx(0.01)


def test_arrays_cannot_be_changed(recording: Recording) -> None:
    with pytest.raises(ValueError, match="read-only"):
        recording.measured_rad[0, 0] = 1.0


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_a_file_gives_the_measured_motion_back(
    recording: Recording, human7: ArmDescription, tmp_path: Path, suffix: str
) -> None:
    path = tmp_path / f"reach{suffix}"
    save_recording(path, recording, human7)
    motion, measured = read_motion(path), recording.measured_motion(human7)
    assert motion.joint_names == measured.joint_names
    assert np.array_equal(motion.angles, measured.angles)
    assert np.array_equal(motion.landmarks, measured.landmarks)
    assert "simulated human7 on /dev/ttyTEST" in motion.source
    assert [item.name for item in tmp_path.iterdir()] == [path.name]


def test_npz_holds_all_fields(recording: Recording, human7: ArmDescription, tmp_path: Path) -> None:
    save_recording(tmp_path / "reach.npz", recording, human7)
    with np.load(tmp_path / "reach.npz") as file:
        for name in ("commanded_rad", "velocity_rad_s", "stale", "hardware_error"):
            assert np.array_equal(file[name], getattr(recording, name))
        assert np.array_equal(file["current_a"], recording.current_a, equal_nan=True)
        assert file["ending"] == "STOPPED_HOLDING"
        assert file["event_text"].tolist() == ["asked to stop: decelerating"]
        assert (file["arm"], file["port"], bool(file["simulated"])) == (
            "human7",
            "/dev/ttyTEST",
            True,
        )
        assert float(file["command_success_rate"]) == 0.97


def test_csv_holds_what_was_commanded(
    recording: Recording, human7: ArmDescription, tmp_path: Path
) -> None:
    save_recording(tmp_path / "reach.csv", recording, human7)
    lines = (tmp_path / "reach.csv").read_text().splitlines()
    names, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    column = names.index("elbow_flexion:commanded_rad")
    assert [float(row[column]) for row in rows] == recording.commanded_rad[:, 3].tolist()
    assert "elbow_flexion:current_a" in names


@pytest.mark.parametrize("name", ["reach.txt", "reach", "no/reach.npz"])
def test_paths_that_no_recording_goes_to(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        check_recording_path(tmp_path / name)
    assert name in str(caught.value)


def test_another_arm_is_an_error(recording: Recording, human7: ArmDescription) -> None:
    other = replace(human7, joint=human7.joint[:4])
    with pytest.raises(FormatError, match="not a recording of human7"):
        recording.measured_motion(other)


@pytest.mark.fault(29)
def test_a_full_log_drops_and_counts() -> None:
    log = StreamLog(2, 1)
    one = np.ones(1)
    state = JointState(one, one, one, np.array([True]), np.array([False]))
    for tick in range(5):
        log.append(tick * 0.1, one, one, state, np.zeros(1, dtype=np.uint8))
    assert (log.rows, log.dropped) == (2, 3)


def test_a_file_reads_back_whole(
    recording: Recording, human7: ArmDescription, tmp_path: Path
) -> None:
    whole = dataclasses.replace(
        recording,
        sent_rad=recording.commanded_rad + 0.02,
        temperature_c=np.full((TICKS, 7), 31.0),
        voltage_v=np.full((TICKS, 7), 11.9),
        events=(Event(0.1, "asked to stop"), Event(0.2, "it sags", "warning")),
        description_sha256=fingerprint(human7),
        target_m=(0.35, -0.1, -0.15),
    )
    save_recording(tmp_path / "reach.npz", whole, human7)
    again = load_recording(tmp_path / "reach.npz")
    for item in dataclasses.fields(Recording):
        first, second = getattr(whole, item.name), getattr(again, item.name)
        if isinstance(first, np.ndarray):
            assert np.array_equal(first, second, equal_nan=first.dtype.kind == "f"), item.name
            assert first.dtype == second.dtype
        else:
            assert first == second, item.name


def test_a_file_of_before_reads_back_with_what_it_has(
    recording: Recording, human7: ArmDescription, tmp_path: Path
) -> None:
    save_recording(tmp_path / "new.npz", recording, human7)
    later = {
        *("sent_rad", "temperature_c", "voltage_v", "measured_rad", "event_level"),
        *("description_sha256", "driver_version"),
    }
    with np.load(tmp_path / "new.npz") as file:
        np.savez(tmp_path / "old.npz", **{k: file[k] for k in file.files if k not in later})
    old = load_recording(tmp_path / "old.npz")
    assert np.array_equal(old.sent_rad, recording.commanded_rad)
    assert np.isnan(old.temperature_c).all()
    assert old.events == (Event(0.1, "asked to stop: decelerating"),)
    assert (old.description_sha256, old.driver_version) == ("", "")
    assert old.target_m is None
    # an older file has the motion's angles only, where lost replies are interpolated
    measured = recording.measured_motion(human7).angles
    assert np.array_equal(old.measured_rad, measured)


@pytest.mark.parametrize("wrong", [[0.1, 0.2], [0.1, 0.2, np.nan], 0.1, ["a", "b", "c"]])
def test_a_damaged_target_is_a_format_error(
    recording: Recording, human7: ArmDescription, tmp_path: Path, wrong: object
) -> None:
    save_recording(tmp_path / "good.npz", recording, human7)
    with np.load(tmp_path / "good.npz") as file:
        np.savez(tmp_path / "bad.npz", **(dict(file) | {"target_m": np.array(wrong)}))
    with pytest.raises(FormatError, match=r"bad\.npz: 'target_m' is not "):
        load_recording(tmp_path / "bad.npz")


@pytest.mark.parametrize("key", ["commanded_rad", "stale", "ending", "event_text", "rate_hz"])
@pytest.mark.parametrize("wrong", [np.array([[1.0]]), np.array("x"), np.array(["a", "b", "c"])])
def test_a_damaged_file_is_a_format_error(
    recording: Recording, human7: ArmDescription, tmp_path: Path, key: str, wrong: np.ndarray
) -> None:
    save_recording(tmp_path / "good.npz", recording, human7)
    with np.load(tmp_path / "good.npz") as file:
        arrays = {name: file[name] for name in file.files} | {key: wrong}
    np.savez(tmp_path / "bad.npz", **arrays)
    with pytest.raises(FormatError, match=r"bad\.npz: "):
        load_recording(tmp_path / "bad.npz")


@pytest.mark.fault(37)
def test_objects_are_never_built_from_a_file(
    recording: Recording, human7: ArmDescription, tmp_path: Path
) -> None:
    save_recording(tmp_path / "good.npz", recording, human7)
    with np.load(tmp_path / "good.npz") as file:
        arrays = {name: file[name] for name in file.files}
    arrays["stale"] = np.array([[object()]], dtype=object)
    np.savez(tmp_path / "bad.npz", **arrays)
    with pytest.raises(FormatError, match="'stale' is missing or damaged"):
        load_recording(tmp_path / "bad.npz")


def test_a_motion_is_no_recording(
    recording: Recording, human7: ArmDescription, tmp_path: Path
) -> None:
    write_motion(tmp_path / "motion.npz", recording.measured_motion(human7))
    with pytest.raises(FormatError, match="not a recording"):
        load_recording(tmp_path / "motion.npz")
    with pytest.raises(FormatError, match=r"only \.npz"):
        load_recording(tmp_path / "motion.csv")


def test_the_fingerprint_is_of_what_the_driver_uses(human7: ArmDescription) -> None:
    first = human7.servo[0]
    moved = replace(human7, servo=(replace(first, zero_tick=2050), *human7.servo[1:]))
    assert fingerprint(human7) == fingerprint(replace(human7))
    assert len({fingerprint(human7), fingerprint(moved)}) == 2


@pytest.mark.fault(29)
def test_a_full_disk_is_said_and_leaves_nothing(
    recording: Recording, human7: ArmDescription, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(InputError, match=r"reach\.npz: cannot write it: No space left"):
        save_recording(tmp_path / "reach.npz", recording, human7)
    assert list(tmp_path.iterdir()) == []
