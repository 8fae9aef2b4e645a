"""Captures put on an arm: what is kept, what is rebuilt, what is refused."""

import dataclasses

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armsyn.arm import ArmDescription, load_arm
from armsyn.errors import CaptureError
from armsyn.motion import Motion
from armsyn.motion.captures import Capture
from armsyn.motion.rebuilding import rebuild_segments
from armsyn.synergy.training import as_captures, prepare


def changed(capture: Capture, landmarks: np.ndarray, names: tuple[str, ...] = ()) -> Capture:
    motion = dataclasses.replace(
        capture.motion,
        landmarks=landmarks,
        landmark_names=names or capture.motion.landmark_names,
    )
    return dataclasses.replace(capture, motion=motion)


def landmarks_of(capture: Capture) -> np.ndarray:
    assert capture.motion.landmarks is not None
    return np.array(capture.motion.landmarks)


def test_another_bodys_size_is_no_error(human7: ArmDescription, played: Capture) -> None:
    """Longer and shorter segments of the same directions give the same training."""
    own = prepare(human7, played, 120.0)
    assert own.start_residual < 1e-3
    np.testing.assert_allclose(own.start, human7.rest, atol=0.05)
    np.testing.assert_allclose(own.landmarks, landmarks_of(played), atol=1e-9)
    other = rebuild_segments(landmarks_of(played), np.array([0.36, 0.20, 0.13]))
    same = prepare(human7, changed(played, other), 120.0)
    np.testing.assert_allclose(same.landmarks, own.landmarks, atol=1e-9)
    np.testing.assert_allclose(same.start, own.start, atol=1e-6)


def test_another_place_of_the_shoulder_is_no_error(human7: ArmDescription, played: Capture) -> None:
    """An arm whose base is not at its shoulder follows the same motion, moved there."""
    place = np.array([0.05, -0.19, 0.8])
    first = msgspec.structs.replace(human7.joint[0], xyz=tuple(place.tolist()))
    moved = msgspec.structs.replace(human7, joint=(first, *human7.joint[1:]))
    own, there = prepare(human7, played, 120.0), prepare(moved, played, 120.0)
    np.testing.assert_allclose(there.landmarks, own.landmarks + place, atol=1e-9)
    np.testing.assert_allclose(there.start, own.start, atol=1e-6)


def test_it_is_brought_to_the_rate_from_its_own_first_stamp(
    human7: ArmDescription, played: Capture
) -> None:
    late = dataclasses.replace(played.motion, time=played.motion.time + 3.0)
    training = prepare(human7, dataclasses.replace(played, motion=late), 60.0)
    np.testing.assert_allclose(training.time, np.arange(90) / 60)
    np.testing.assert_allclose(training.landmarks, landmarks_of(played)[:-1:2], atol=1e-9)
    np.testing.assert_array_equal(training.target, training.landmarks[-1, -1])


def test_the_starts_residual_is_the_mean_distance_left(
    human7: ArmDescription, played: Capture
) -> None:
    """The shoulder cannot follow: of four landmarks one is 4 cm away, so the mean is 1 or more."""
    moved = landmarks_of(played)
    moved[:, 0] += [0.0, 0.04, 0.0]
    training = prepare(human7, changed(played, moved), 120.0)
    points = human7.chain.positions(training.start[None])[0, list(human7.landmark_frames)]
    left = np.linalg.norm(points - training.landmarks[0], axis=1).mean()
    assert training.start_residual == pytest.approx(left)
    assert 0.01 <= training.start_residual < 0.03


def refused(arm: ArmDescription, capture: Capture, said: str) -> None:
    with pytest.raises(CaptureError, match=said) as caught:
        prepare(arm, capture, 120.0)
    assert "\n" not in str(caught.value)


def test_gaps_are_refused_with_their_frame(human7: ArmDescription, played: Capture) -> None:
    gap = landmarks_of(played)
    gap[17, 2, 1] = np.nan
    refused(human7, changed(played, gap), "made:played: a landmark is missing at frame 17")


def test_other_landmarks_are_refused(human7: ArmDescription, played: Capture) -> None:
    names = ("shoulder", "elbow", "wrist", "finger")
    refused(human7, changed(played, landmarks_of(played), names), "finger; human7 has shoulder")
    three = changed(played, landmarks_of(played)[:, [0, 1, 3]], ("shoulder", "elbow", "hand"))
    refused(human7, three, "has landmarks shoulder, elbow, hand; human7 has")
    angles = Motion(np.arange(9) / 9, ("elbow",), np.zeros((9, 1)))
    refused(human7, dataclasses.replace(played, motion=angles), "has landmarks none")


def test_a_start_that_the_arm_cannot_take_is_refused(
    human7: ArmDescription, played: Capture
) -> None:
    """A person whose shoulder is 40 cm beside the arm's."""
    aside = landmarks_of(played) + np.array([0.0, 0.4, 0.0])
    refused(human7, changed(played, aside), "human7 misses its first posture by .* cm")


def test_a_hand_that_rests_is_refused(human7: ArmDescription, played: Capture) -> None:
    still = np.repeat(landmarks_of(played)[:1], 180, axis=0)
    refused(human7, changed(played, still), "the hand stays within 2 cm of its start")


def test_a_segment_without_length_has_no_direction(human7: ArmDescription, played: Capture) -> None:
    flat = landmarks_of(played)
    flat[40, 2] = flat[40, 1]
    refused(human7, changed(played, flat), "landmarks that are apart")


@pytest.mark.parametrize("name", ["openmanipulator_x", "koch"])
@pytest.mark.parametrize("kind", ["reach", "return"])
def test_an_arm_with_a_hand_only_gets_the_hands_scaled_path(
    name: str, kind: str, played: Capture
) -> None:
    arm = load_arm(name)
    captured = dataclasses.replace(played, kind=kind)
    training = prepare(arm, captured, 120.0)
    assert training.landmarks.shape == (180, 1, 3)
    rest = arm.chain.forward(arm.rest).tip
    at_rest = training.landmarks[0 if kind == "reach" else -1, 0]
    np.testing.assert_allclose(at_rest, rest, atol=1e-9)
    scale = 0.5 * arm.chain.reach / 0.66  # the person's .30 + .26 + .10 m
    turned = Rotation.from_euler("z", arm.facing).apply(landmarks_of(played)[:, -1]) * scale
    np.testing.assert_allclose(
        training.landmarks[:, 0] - training.landmarks[0, 0], turned - turned[0], atol=1e-9
    )


def test_a_hand_alone_has_no_arm_to_scale_by(played: Capture) -> None:
    hand = changed(played, landmarks_of(played)[:, -1:], ("hand",))
    refused(load_arm("koch"), hand, "landmarks that are apart")


def test_reaches_are_stacked_for_the_kernels(human7: ArmDescription, played: Capture) -> None:
    short = dataclasses.replace(played, motion=played.motion.between(0, 100))
    trainings = [prepare(human7, capture, 120.0) for capture in (played, short)]
    stacked = as_captures(human7, trainings)
    assert stacked.frames.tolist() == [180, 101]
    assert stacked.landmarks.shape == (2, 180, 4, 3)
    assert not stacked.landmarks[1, 101:].any()
    for row, training in enumerate(trainings):
        np.testing.assert_array_equal(
            stacked.landmarks[row, : stacked.frames[row]], training.landmarks
        )
        np.testing.assert_array_equal(stacked.starts[row], training.start)
        np.testing.assert_array_equal(stacked.targets[row], training.target)
    positions = human7.chain.positions(stacked.starts[:1])[0, stacked.rows]
    np.testing.assert_allclose(positions, trainings[0].landmarks[0], atol=2e-3)
