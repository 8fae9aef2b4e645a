"""`armsyn motion retarget`: what it puts on an arm, says and refuses."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from armsyn.arm.description import load_arm
from armsyn.kinematics.rotation import from_expmap
from armsyn.motion import FloatArray, Motion
from armsyn.motion.captures import load_captures
from armsyn.motion.formats import read_motion, write_motion
from armsyn.motion.rebuilding import rebuild_segments
from tests.cli.commands import Outcome

Call = Callable[..., Outcome]
ARM = load_arm("human7")
NAMES = tuple(ARM.landmarks)


def swing(frames: int, size: float) -> Motion:
    """The arm's joints alone, from rest and back."""
    angles = ARM.rest + size * np.sin(np.linspace(0, np.pi, frames))[:, None] * np.ones(7)
    angles = np.clip(angles, ARM.chain.lower, ARM.chain.upper)
    return Motion(np.arange(frames) / 50, ARM.joint_names, angles, source="swing")


def landmarks_of(motion: Motion) -> FloatArray:
    assert motion.angles is not None
    return ARM.chain.positions(motion.angles)[:, list(ARM.landmark_frames)]


@pytest.fixture
def person(tmp_path: Path) -> Callable[[str, Motion], Path]:
    """Write the arm's motion as of another body in another base."""

    def written(name: str, motion: Motion) -> Path:
        points = rebuild_segments(landmarks_of(motion), np.array([0.33, 0.24, 0.12]))
        points = points @ from_expmap([0.0, 0.0, np.pi / 3]).T + np.array([1.0, 2.0, 0.4])
        seen = Motion(motion.time, landmark_names=NAMES, landmarks=points)
        write_motion(tmp_path / name, seen)
        return tmp_path / name

    return written


def test_a_robots_joint_log_goes_onto_the_same_arm(call: Call, tmp_path: Path) -> None:
    own = swing(20, 0.3)
    write_motion(tmp_path / "log.csv", own)
    out = tmp_path / "out.npz"
    options = ("--arm", "human7", "--from", "human7", "--out", out, "--angles", "--json")
    document = call("motion", "retarget", tmp_path / "log.csv", *options).document
    assert document["fit_worst_m"] < 1e-3
    assert document["segments_m"] == pytest.approx([0.30, 0.26, 0.10], abs=1e-6)
    found = read_motion(out)
    assert found.joint_names == ARM.joint_names
    assert found.landmarks is not None
    np.testing.assert_allclose(found.landmarks, landmarks_of(own), atol=2e-3)


def test_a_session_is_aligned_by_its_calibration_poses(
    call: Call, tmp_path: Path, person: Callable[[str, Motion], Path]
) -> None:
    trial, poses = swing(20, 0.4), swing(6, 0.3)
    own = dataclasses.replace(poses, landmark_names=NAMES, landmarks=landmarks_of(poses))
    write_motion(tmp_path / "own.npz", own)
    out = tmp_path / "out.npz"
    files = person("trial.csv", trial), person("poses.csv", poses)
    command = ("motion", "retarget", files[0], "--arm", "human7", "--out", out)
    aligned = call(*command, "--align", files[1], tmp_path / "own.npz")
    assert "6 calibration poses" in aligned.out
    found = read_motion(out).landmarks
    assert found is not None
    assert np.linalg.norm(found - landmarks_of(trial), axis=2).max() < 0.02
    turned = call(*command, "--facing", "60", "--json").document
    assert turned["facts"]["base"] == "turned from 60 degrees to x"
    found = read_motion(out).landmarks
    assert found is not None
    np.testing.assert_allclose(found, landmarks_of(trial), atol=1e-9)
    copy = person("copy.csv", trial)
    for same in (files[0], copy):
        call(*command, "--align", same, tmp_path / "own.npz").refused(2, "hides")
    call(*command, "--align", files[1], copy).refused(2, "hides")
    call(*command, "--facing", "60", "--align", *files).refused(2, "one of them")


def test_captures_by_name_and_by_file(call: Call, tmp_path: Path, captures: Path) -> None:
    """The whole file's frames are those of the captured reach, wherever the trunk was."""
    cut, whole = tmp_path / "cut.npz", tmp_path / "whole.npz"
    take = "ChrGarza@IdleStand01_ReachForwardHigh01"
    assert call("motion", "retarget", "garza:ForwardHigh", "--arm", "human7", "--out", cut)
    file = f"{captures}/reach/garza/reach.npz#{take}"
    said = call("motion", "retarget", file, "--arm", "human7", "--out", whole).out
    assert "removed by the frame of JtSpineC" in said
    (capture,) = load_captures("garza:ForwardHigh")
    assert "frames 50-77" in capture.source
    part = read_motion(whole).between(50, 77)
    np.testing.assert_array_equal(part.landmarks, read_motion(cut).landmarks)


def test_markers_of_a_left_arm(call: Call, tmp_path: Path, captures: Path) -> None:
    file, out = captures / "reach" / "ulema" / "RF1.c3d", tmp_path / "out.csv"
    command = ("motion", "retarget", file, "--arm", "human7", "--out", out)
    said = call(*command, "--mirror").out
    assert "ulema, left arm (recognised)" in said
    assert "IJ+PX+C7+T8" in said
    right = read_motion(out)
    shoulder = right.landmarks
    assert shoulder is not None
    assert (shoulder[:, -1, 1] < shoulder[:, 0, 1]).all()
    named = call(*command, "--landmark", "shoulder=LGH", "--landmark", "hand=LMC3")
    named.refused(2, "needs shoulder, elbow, wrist, hand")


def test_refusals(call: Call, tmp_path: Path, person: Callable[[str, Motion], Path]) -> None:
    file = person("trial.csv", swing(8, 0.2))
    command = ("motion", "retarget", file, "--arm", "human7", "--out", tmp_path / "out.npz")
    call(*command, "--from", "human7").refused(2, "no joint")
    call(*command, "--landmark", "hand").refused(2, "NAME=POINT")
    call(*command, "--landmark", "hand=hand").refused(2, "at least")
    call(*command, "--chest", "x").refused(2, "--landmark, too")
    call(*command[:-1], tmp_path / "out.bvh").refused(2, "out.bvh")
    call(*command[:-1], tmp_path / "out.trc", "--angles").refused(2, "no place")
    call(*command[:-1], tmp_path / "none" / "out.npz").refused(2, "make it first")
    call(*command[:3], "--arm", "nobody", "--out", "x.npz").refused(2, "nobody")
    bare = tmp_path / "log.csv"
    write_motion(bare, swing(8, 0.2))
    call("motion", "retarget", bare, *command[3:]).refused(2, "--from ARM")
