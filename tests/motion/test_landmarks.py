"""Landmarks of an arm: whatever the trunk does, and wherever the laboratory's axes point."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.arm.description import load_arm
from armsyn.errors import CaptureError, InputError
from armsyn.kinematics.rotation import from_expmap
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion import FloatArray, Motion
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats import read_body, read_file, read_motion
from armsyn.motion.landmarks import (
    LAYOUTS,
    arm_of_angles,
    arm_of_body,
    arm_of_markers,
    known_layout,
)

TIME = np.arange(12) / 100
POINTS = {"shoulder": "S", "elbow": "E1+E2", "hand": "H"}
CHEST = "IJ+PX+C7+T8"
UPRIGHT = np.array([[0.1, 0, 0.2], [0.1, 0, 0.0], [-0.1, 0, 0.2], [-0.1, 0, 0.0]])
"""Front and back of a chest that faces x, from its own origin."""


def places(motion: Motion) -> FloatArray:
    assert motion.landmarks is not None
    return motion.landmarks


def moving_trunk(seed: int) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    return np.asarray(from_expmap(rng.normal(size=(12, 3)))), rng.normal(size=(12, 1, 3))


def markers(arm: FloatArray, turn: FloatArray, move: FloatArray) -> Motion:
    """Shoulder, elbow's two sides and hand, in the chest's frame, as the laboratory sees them."""
    rows = np.stack([arm[:, 0], arm[:, 1] + 0.03, arm[:, 1] - 0.03, arm[:, 2]], axis=1)
    points = np.concatenate([rows, np.broadcast_to(UPRIGHT, (12, 4, 3))], axis=1)
    seen = np.einsum("tij,tkj->tki", turn, points) + move
    return Motion(TIME, landmark_names=("S", "E1", "E2", "H", *CHEST.split("+")), landmarks=seen)


@given(seed=st.integers(0, 9999))
def test_markers_on_a_moving_trunk_give_the_arm_in_the_chests_frame(seed: int) -> None:
    arm = np.cumsum(np.random.default_rng(seed + 1).normal(size=(12, 3, 3)), axis=1)
    found = arm_of_markers(markers(arm, *moving_trunk(seed)), POINTS, CHEST)
    assert found.landmark_names == ("shoulder", "elbow", "hand")
    np.testing.assert_allclose(places(found), arm - arm[:, :1], atol=1e-9)


def test_without_a_chest_the_trunks_turn_stays() -> None:
    turn, move = moving_trunk(3)
    arm = np.cumsum(np.ones((12, 3, 3)), axis=1)
    found = arm_of_markers(markers(arm, turn, move), POINTS, None)
    turned = np.einsum("tij,tkj->tki", turn, arm - arm[:, :1])
    np.testing.assert_allclose(places(found), turned, atol=1e-9)


def test_gaps_stay_gaps() -> None:
    seen = markers(np.cumsum(np.ones((12, 3, 3)), axis=1), *moving_trunk(1))
    landmarks = np.array(places(seen))
    landmarks[4, 1] = np.nan
    landmarks[7, 5] = np.nan
    found = arm_of_markers(
        Motion(TIME, landmark_names=seen.landmark_names, landmarks=landmarks), POINTS, CHEST
    )
    unseen = np.asarray(np.isnan(places(found)).any(axis=2))
    assert unseen[4].tolist() == [False, True, False]
    assert unseen[7].all()
    assert unseen.sum() == 4


def test_what_is_no_chest_is_refused() -> None:
    seen = markers(np.cumsum(np.ones((12, 3, 3)), axis=1), *moving_trunk(1))
    with pytest.raises(InputError, match="four markers"):
        arm_of_markers(seen, POINTS, "IJ+PX")
    with pytest.raises(InputError, match="no landmark 'X'"):
        arm_of_markers(seen, POINTS, "IJ+PX+C7+X")
    with pytest.raises(CaptureError, match="on one line"):
        arm_of_markers(seen, POINTS, "IJ+IJ+IJ+IJ")


@given(seed=st.integers(0, 9999))
def test_a_skeletons_trunk_moves_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    skeleton = Skeleton(
        ("root", "chest", "leg", "shoulder", "elbow", "hand"),
        (-1, 0, 0, 1, 3, 4),
        rng.normal(size=(6, 3)),
        from_expmap(rng.normal(size=(6, 3))),
    )
    channels = rng.normal(size=(12, 6, 3))
    other = channels.copy()
    other[:, :3] = rng.normal(size=(12, 3, 3))
    joints = {"shoulder": "shoulder", "elbow": "elbow", "hand": "hand"}
    one, same = (
        places(
            arm_of_body(
                BodyMotion(TIME, skeleton, turns, rng.normal(size=(12, 3))), joints, "chest"
            )
        )
        for turns in (channels, other)
    )
    np.testing.assert_allclose(one, same, atol=1e-9)
    # In the frame of the zero pose: there the body itself is the arm in the chest's frame
    channels[:, :3] = 0.0
    still = BodyMotion(TIME, skeleton, channels, np.zeros((12, 3)))
    plain = still.positions()[:, 3:]
    np.testing.assert_allclose(one, plain - plain[:, :1], atol=1e-9)


def test_angles_give_the_landmarks_of_the_arms_chain() -> None:
    arm = load_arm("human7")
    angles = np.tile(arm.rest, (3, 1))
    shuffled = Motion(np.arange(3.0), arm.joint_names[::-1], angles[:, ::-1])
    found = arm_of_angles(shuffled, arm)
    assert found.joint_names == arm.joint_names
    expected = arm.chain.forward(arm.rest).positions[list(arm.landmark_frames)]
    np.testing.assert_allclose(places(found)[1], expected, atol=1e-12)
    with pytest.raises(InputError, match="no joint"):
        arm_of_angles(Motion(np.arange(3.0), ("a",), np.zeros((3, 1))), arm)


def test_known_captures_are_recognised(captures: Path) -> None:
    garza = read_body(f"{captures}/reach/garza/reach.npz#ChrGarza@IdleStand01_ReachForwardHigh01")
    assert known_layout(garza.skeleton.names) == "garza, right arm"
    golf = read_file(f"{captures}/golf/gears.npz#swing01").body
    assert golf is not None
    assert known_layout(golf.skeleton.names) == "golf, right arm"
    assert known_layout(("shoulder", "elbow")) is None


def test_ulema_segments_keep_their_lengths(captures: Path) -> None:
    """Of a seated left arm: the hand starts on the lap before the shoulder and reaches forward."""
    markers = read_motion(captures / "reach" / "ulema" / "RF1.c3d")
    kind = known_layout(markers.landmark_names)
    assert kind == "ulema, left arm"
    found = arm_of_markers(markers, *LAYOUTS[kind])
    lengths = np.linalg.norm(np.diff(places(found), axis=1), axis=2)
    assert (lengths.std(axis=0) < 0.004).all()
    assert lengths.mean(axis=0)[:2] == pytest.approx([0.19, 0.19], abs=0.005)
    hand = places(found)[:, -1]
    assert hand[0, 0] > 0.1
    assert hand[0, 2] < -0.2
    assert np.ptp(hand[:, 0]) > 0.1
    assert (hand[:, 1] > 0).all()  # of a left arm
