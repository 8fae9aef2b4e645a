"""Captured arms on an arm's link lengths, by one base transform a session."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.arm import ArmDescription
from armsyn.arm.description import load_arm
from armsyn.errors import CaptureError
from armsyn.kinematics.rotation import from_expmap
from armsyn.motion import FloatArray, Motion
from armsyn.motion.base_transform import fit_base_transform
from armsyn.motion.captures import load_captures
from armsyn.motion.rebuilding import rebuild_segments, segment_lengths
from armsyn.motion.retargeting import fit_angles, mirrored, retarget

NAMES = ("shoulder", "elbow", "wrist", "hand")


@pytest.fixture(scope="module")
def human7() -> ArmDescription:
    return load_arm("human7")


def played(arm: ArmDescription, frames: int = 12) -> Motion:
    """The arm's own motion from rest, with its landmarks."""
    swing = np.sin(np.linspace(0, np.pi, frames))[:, None]
    angles = arm.rest + swing * np.array([0.3, 0.2, 0.2, 0.4, 0.1, 0.1, 0.1])
    landmarks = arm.chain.positions(angles)[:, list(arm.landmark_frames)]
    return Motion(np.arange(frames) / 30, arm.joint_names, angles, NAMES, landmarks, "played")


def places(motion: Motion) -> FloatArray:
    assert motion.landmarks is not None
    return motion.landmarks


@given(seed=st.integers(0, 9999), marks=st.integers(2, 5))
def test_rebuilding_keeps_directions_and_sets_lengths(seed: int, marks: int) -> None:
    rng = np.random.default_rng(seed)
    landmarks = np.cumsum(rng.normal(size=(6, marks, 3)), axis=1)
    lengths = rng.uniform(0.05, 0.5, marks - 1)
    rebuilt = rebuild_segments(landmarks, lengths)
    np.testing.assert_array_equal(rebuilt[:, 0], landmarks[:, 0])
    before, after = np.diff(landmarks, axis=1), np.diff(rebuilt, axis=1)
    size = np.linalg.norm(after, axis=2)
    np.testing.assert_allclose(size, np.broadcast_to(lengths, size.shape), rtol=1e-12)
    cosine = (before * after).sum(axis=2) / np.linalg.norm(before, axis=2) / size
    np.testing.assert_allclose(cosine, 1.0, atol=1e-12)


def test_another_body_at_another_place_comes_back_onto_the_arm(human7: ArmDescription) -> None:
    own = played(human7)
    person = rebuild_segments(places(own), np.array([0.36, 0.20, 0.13]))
    person = person + np.array([1.0, -2.0, 0.5])
    found = retarget(dataclasses.replace(own, landmarks=person), human7)
    np.testing.assert_allclose(places(found), places(own), atol=1e-9)
    np.testing.assert_allclose(segment_lengths(places(found)), [0.30, 0.26, 0.10], atol=1e-9)
    assert found.angles is None


def test_marks_of_what_was_filled_come_along(human7: ArmDescription) -> None:
    own = played(human7)
    marks = np.zeros((own.frames, 4), dtype=np.bool_)
    marks[3, 1] = marks[5, 3] = True
    found = retarget(dataclasses.replace(own, filled=marks), human7)
    assert found.filled is not None
    # A rebuilt landmark stands on the one before it
    assert np.argwhere(found.filled).tolist() == [[3, 1], [3, 2], [3, 3], [5, 3]]
    assert fit_angles(human7, found).motion.filled is not None


def test_fitted_angles_play_the_landmarks(human7: ArmDescription) -> None:
    own = played(human7)
    seen: list[int] = []
    track = fit_angles(human7, retarget(own, human7), seen.append)
    assert track.residuals.max() < 2e-3
    np.testing.assert_allclose(places(track.motion), places(own), atol=5e-3)
    assert track.motion.joint_names == human7.joint_names
    assert seen == list(range(1, own.frames + 1))


def test_one_transform_of_a_session_undoes_its_base(human7: ArmDescription) -> None:
    poses, trial = played(human7, 5), played(human7, 20)
    turn, move = from_expmap([0.2, -0.4, 1.3]), np.array([0.4, 2.0, -0.3])

    def moved(motion: Motion) -> Motion:
        person = rebuild_segments(places(motion), np.array([0.33, 0.28, 0.09]))
        return dataclasses.replace(motion, landmarks=person @ turn.T + move)

    transform = fit_base_transform(poses, moved(poses))
    found = retarget(transform.apply(moved(trial)), human7)
    # What the other build leaves in the fit
    assert np.linalg.norm(places(found) - places(trial), axis=2).max() < 0.02
    wrong = retarget(moved(trial), human7)
    assert np.linalg.norm(places(wrong) - places(trial), axis=2).max() > 0.3


def test_poses_without_a_landmark_in_common_are_refused(human7: ArmDescription) -> None:
    own = played(human7, 5)
    other = dataclasses.replace(own, landmark_names=("a", "b", "c", "d"), source="other")
    with pytest.raises(CaptureError, match=r"no landmark of played \(shoulder.*of other \(a, b"):
        fit_base_transform(own, other)


def test_mirrored_twice_is_the_same(human7: ArmDescription) -> None:
    own = played(human7)
    np.testing.assert_array_equal(places(mirrored(mirrored(own))), places(own))
    assert mirrored(own).angles is None


def test_an_arm_that_names_its_hand_only_gets_its_path() -> None:
    arm, own = load_arm("koch"), played(load_arm("human7"))
    found = retarget(own, arm)
    assert found.landmark_names == ("hand",)
    start = arm.chain.forward(arm.rest).tip
    np.testing.assert_allclose(places(found)[0, 0], start, atol=1e-12)
    back = retarget(own, arm, is_return=True)
    np.testing.assert_allclose(places(back)[-1, 0], start, atol=1e-12)


def test_what_cannot_be_put_on_an_arm(human7: ArmDescription) -> None:
    own = played(human7)
    less = dataclasses.replace(own, landmark_names=("shoulder", "elbow", "wrist", "tip"))
    with pytest.raises(CaptureError, match=r"human7 needs shoulder, elbow, wrist, hand"):
        retarget(less, human7)
    gap = np.array(places(own))
    gap[3, 1] = np.nan
    with pytest.raises(CaptureError, match="frame 3"):
        retarget(dataclasses.replace(own, landmarks=gap), human7)
    with pytest.raises(CaptureError, match="landmarks none"):
        retarget(Motion(own.time, own.joint_names, own.angles), human7)


@pytest.mark.usefixtures("captures")
def test_a_captured_reach_keeps_its_directions(human7: ArmDescription) -> None:
    (reach,) = load_captures("garza:ForwardHigh")
    found = places(retarget(reach.motion, human7))
    before, after = (np.diff(points, axis=1) for points in (places(reach.motion), found))
    size = np.linalg.norm(after, axis=2)
    cosine = (before * after).sum(axis=2) / np.linalg.norm(before, axis=2) / size
    np.testing.assert_allclose(cosine, 1.0, atol=1e-12)
    np.testing.assert_allclose(size, np.broadcast_to([0.30, 0.26, 0.10], size.shape), atol=1e-12)
