"""Skeletons in archives: the captures' layouts against what they hold, and there and back."""

from pathlib import Path

import numpy as np
import pytest

from armsyn.errors import FormatError
from armsyn.kinematics.rotation import from_quaternion_xyzw
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion import Motion
from armsyn.motion.body import BodyMotion
from armsyn.motion.captures import load_captures
from armsyn.motion.formats import read_body, read_file, read_motion, takes_in, write_body
from armsyn.motion.formats.hug_mp import read_hug_mp
from armsyn.motion.glitches import find_glitches

GARZA = "reach/garza/reach.npz"
FORWARD = "ChrGarza@IdleStand01_ReachForwardHigh01"


def test_garza_has_the_arm_that_learning_uses(captures: Path) -> None:
    path = captures / GARZA
    assert len(takes_in(path)) == 35
    body = read_body(f"{path}#{FORWARD}")
    motion = body.as_motion(["JtShoulderRt", "JtElbowRt", "JtWristRt", "JtMiddleARt"])
    (capture,) = load_captures("garza:ForwardHigh")
    used = capture.motion.landmarks
    assert used is not None
    assert motion.landmarks is not None
    # distances from the shoulder are the same in the chest's frame, where learning has them
    first = int(np.argmin(np.abs(body.time - _start(capture.source))))
    part = motion.landmarks[first : first + len(used)]
    there = np.linalg.norm(part - part[:, :1], axis=2)
    np.testing.assert_allclose(there, np.linalg.norm(used - used[:, :1], axis=2), atol=1e-6)
    assert (body.positions()[:, body.skeleton.index("JtSkullA"), 2] > 1.4).all()  # z is up


def _start(source: str) -> float:
    frames = source.rsplit("frames ", 1)[1].split(" at ", maxsplit=1)[0]
    return int(frames.split("-")[0]) / 30


def test_golf_joints_follow_their_markers(captures: Path) -> None:
    reading = read_file(f"{captures / 'golf/gears.npz'}#swing01")
    assert reading.body is not None
    assert reading.facts["moving offsets"] == "spine, chest, neck, left_wrist, right_wrist"
    joints, markers = reading.body.as_motion().landmarks, reading.motion.landmarks
    assert joints is not None
    assert markers is not None
    pairs = {
        **{"LAnkleOut": "left_ankle", "RAnkleOut": "right_ankle", "LKneeOut": "left_knee"},
        **{"RKneeOut": "right_knee", "LElbowOut": "left_elbow", "RElbowOut": "right_elbow"},
        **{"LShoulderTop": "left_shoulder", "RShoulderTop": "right_shoulder"},
        **{"LToeIn": "left_toe", "RToeIn": "right_toe", "HeadTop": "head"},
    }
    for marker, joint in pairs.items():
        path = joints[:, reading.body.skeleton.index(joint)]
        apart = np.linalg.norm(
            markers[:, reading.motion.landmark_names.index(marker)] - path, axis=1
        )
        # a marker sits on the skin beside its joint: near it, and at nearly one distance
        assert np.nanmax(apart) < 0.25, marker
        assert np.nanstd(apart) < 0.035, marker


def test_glitches_of_golf_are_found_and_reaches_have_none(captures: Path) -> None:
    def frames(swing: int) -> set[int]:
        body = read_body(f"{captures / 'golf/gears.npz'}#swing{swing:02d}")
        return {glitch.frame for glitch in find_glitches(body.as_motion())}

    # the captures' README: mid-swing at 104-106, 45-46 and 88-90, counted from 0 or 1
    assert frames(3) & {105, 106, 107}
    assert frames(7) & {45, 46, 47}
    assert frames(10) & {89, 90, 91}
    for take in takes_in(captures / GARZA)[::6]:
        assert find_glitches(read_motion(f"{captures / GARZA}#{take}")) == []


def test_a_single_step_out_of_line_is_a_glitch_a_fast_move_is_not() -> None:
    time = np.arange(60) / 100
    smooth = np.stack([np.sin(5 * time), 0 * time, 0 * time], axis=1)  # up to 5 m/s
    spiked = smooth.copy()
    spiked[30, 1] = 0.2
    names = ("smooth", "spiked")
    motion = Motion(time, landmark_names=names, landmarks=np.stack([smooth, spiked], axis=1))
    found = find_glitches(motion)
    assert [(glitch.landmark, glitch.frame) for glitch in found] == [("spiked", 30), ("spiked", 31)]
    assert found[0].speed == pytest.approx(20, abs=1)


def test_bodies_come_back_from_npz_to_the_last_bits(tmp_path: Path) -> None:
    random = np.random.default_rng(7)
    turns = random.normal(size=(3, 4))
    turns[0] = [1, 0, 0, 1e-9]  # half a turn
    before = from_quaternion_xyzw(turns)
    skeleton = Skeleton(("a", "b", "c"), (-1, 0, 0), random.normal(size=(3, 3)), before)
    values = random.normal(size=(2, 5, 3, 3))
    body = BodyMotion(np.arange(5) / 3, skeleton, values[0], values[1, :, 0], values[1], "s")
    write_body(tmp_path / "a.npz", body)
    again = read_body(tmp_path / "a.npz")
    np.testing.assert_array_equal(again.rotations, body.rotations)
    np.testing.assert_array_equal(again.time, body.time)
    np.testing.assert_allclose(again.positions(), body.positions(), atol=1e-12)
    assert again.skeleton.names == body.skeleton.names


def test_files_of_several_motions_name_them(captures: Path) -> None:
    path = captures / GARZA
    with pytest.raises(FormatError, match=r"holds 35 motions: name one, as FILE#TAKE: ChrGarza"):
        read_motion(path)
    with pytest.raises(FormatError, match="no motion 'nothing' in it; there are ChrGarza"):
        read_motion(f"{path}#nothing")


def test_hug_mp_by_take(captures: Path) -> None:
    path = captures / "reach/hug_mp/S01_trajs.mat"
    direct = read_hug_mp(path)
    assert len(takes_in(path)) == len(direct)
    motion = read_motion(f"{path}#2.4.5")
    assert motion.angles is not None
    np.testing.assert_array_equal(motion.angles, direct[2, 4, 5].angles)
