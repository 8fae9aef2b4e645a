"""Distances: the paper's oracle values, and the controls that must never score better."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armsyn.errors import CaptureError, FormatError, InputError
from armsyn.motion import Motion
from armsyn.motion.resample import at_times, resample
from armsyn.scoring.distance import (
    arm_length,
    coverage,
    distance_per_arm_length,
    held_distance,
    held_errors,
    mean_distance,
    normalised_distance,
    paper_distance,
)
from armsyn.scoring.pairing import pair_up, trim

from .arms import NAMES, posture, reach, still, with_landmarks

FORWARD, DOWN, UP = np.array([1.0, 0, 0]), np.array([0, 0, -1.0]), np.array([0, 0, 1.0])


def held(captured: Motion, other: Motion) -> float:
    return held_distance(trim(pair_up(captured, other)))


def landmarks_of(motion: Motion) -> np.ndarray:
    assert motion.landmarks is not None
    return motion.landmarks


@pytest.mark.parametrize(
    ("other", "expected"),
    [(posture(DOWN, FORWARD), 0.318198), (posture(FORWARD, UP), 0.2121)],
)
def test_paper_distance_of_two_postures(other: np.ndarray, expected: float) -> None:
    straight = still(posture(FORWARD, FORWARD))
    assert paper_distance(straight, still(other)) == pytest.approx(expected, abs=5e-5)
    assert paper_distance(still(other), straight) == pytest.approx(expected, abs=5e-5)


def test_paper_distance_is_the_mean_over_frames_to_the_shorter() -> None:
    first = still(np.zeros((4, 3)), duration=1.0)
    moving = np.zeros((151, 4, 3))
    moving[:, :, 0] = np.arange(151)[:, None]
    assert paper_distance(first, with_landmarks(first, moving)) == pytest.approx(50)


def test_paper_distance_brings_rates_together() -> None:
    slow, fast = reach(rate=30.0), reach(rate=240.0)
    assert paper_distance(slow, fast) < 1e-3
    left_uncorrected = mean_distance(landmarks_of(slow), landmarks_of(fast))
    assert left_uncorrected > 0.01
    assert paper_distance(slow, fast, rate=60.0) < 1e-3


def test_stopping_early_games_the_paper_but_not_the_held_distance() -> None:
    captured, wrong = reach(rest=0.0), reach(rest=0.0, swing=-0.5)
    stopped = wrong.between(0, 15)
    assert paper_distance(captured, stopped) < 0.02 * paper_distance(captured, wrong)
    assert coverage(pair_up(captured, stopped)) == pytest.approx(0.15)
    assert held(captured, stopped) > 0.5 * held(captured, reach(rest=0.0, swing=0.0001))
    assert held(captured, stopped) > 20 * paper_distance(captured, stopped)


def test_held_distance_of_a_motion_to_itself_is_zero_however_it_is_cut_or_sampled() -> None:
    captured = reach()
    assert held(captured, captured) == 0
    assert held(captured, reach(rate=200.0)) < 2e-4
    assert held(captured, reach(rest=2.0)) < 2e-4


def test_held_distance_divides_by_the_captured_frames() -> None:
    # Twice as slow to the same place: the sum runs over the longer in both directions.
    fast, slow = reach(duration=1.0), reach(duration=2.0)
    assert held(fast, slow) == pytest.approx(2 * held(slow, fast), rel=0.02)


def candidates() -> st.SearchStrategy[Motion]:
    return st.builds(
        reach,
        duration=st.floats(0.6, 1.6),
        rest=st.floats(0.0, 0.5),
        rate=st.sampled_from([60.0, 100.0, 200.0]),
        swing=st.floats(0.7, 1.1),
        skew=st.floats(0.8, 1.3),
    )


@settings(max_examples=40, deadline=None)
@given(other=candidates(), seconds=st.floats(0.05, 3))
def test_appended_rest_never_scores_better(other: Motion, seconds: float) -> None:
    captured = reach()
    marks = landmarks_of(other)
    added = marks[-1:].repeat(round(seconds * other.rate), axis=0)
    idling = with_landmarks(other, np.concatenate([marks, added]), other.rate)
    assert held(captured, idling) >= held(captured, other) * (1 - 1e-5)


@settings(max_examples=40, deadline=None)
@given(
    duration=st.floats(0.95, 1.05),
    swing=st.floats(0.85, 0.9),
    skew=st.floats(0.9, 1.1),
    share=st.floats(0.2, 0.6),
)
def test_a_truncated_reach_to_the_target_scores_worse(
    duration: float, swing: float, skew: float, share: float
) -> None:
    captured = reach()
    other = reach(duration=duration, swing=swing, skew=skew)
    stopped = other.between(0, round((0.4 + share * duration) * other.rate))
    assert held(captured, stopped) > held(captured, other)


@pytest.mark.parametrize("swing", [0.8, 0.9, 1.0])
def test_controls_lose_to_the_reach_they_are_made_from(swing: float) -> None:
    captured, other = reach(), reach(duration=1.1, swing=swing)
    best = held(captured, other)
    marks = landmarks_of(other)
    backwards = with_landmarks(other, marks[::-1])
    mirrored = reach(duration=1.1, swing=swing, side=-1.0)
    assert held(captured, backwards) > 2 * best
    assert held(captured, mirrored) > 1.2 * best
    assert held(captured, constant_speed(other)) > best


def constant_speed(motion: Motion) -> Motion:
    """Return the same path in the same time, at one speed of the hand."""
    travelled = np.concatenate(
        [[0], np.cumsum(np.linalg.norm(np.diff(motion.hand, axis=0), axis=1))]
    )
    moving = np.flatnonzero(np.diff(travelled) > 1e-12)
    first, last = int(moving[0]), int(moving[-1]) + 1
    wanted = np.linspace(travelled[first], travelled[last], last - first + 1)
    kept = slice(first, last + 1)
    times = np.interp(wanted, travelled[kept], motion.time[kept])
    return with_landmarks(motion, landmarks_of(at_times(motion, np.unique(times))))


def test_normalised_distance_is_blind_to_speed_and_delay() -> None:
    captured = reach()
    for other in (reach(duration=2.0), reach(rest=1.5), reach(duration=0.5)):
        assert normalised_distance(trim(pair_up(captured, other))) < 3e-3
    assert paper_distance(captured, reach(rest=0.5)) > 0.01


def test_a_static_joint_dilutes_the_distance_but_not_that_per_arm_length() -> None:
    captured, other = reach(), reach(swing=0.8)
    # The shoulder, already static, makes 3 moving landmarks of 4.
    plain = trim(pair_up(captured, other))
    moving_only = held_errors(plain)[1:].mean()
    assert held_distance(plain) == pytest.approx(0.75 * moving_only)
    assert distance_per_arm_length(plain) == pytest.approx(moving_only / 0.64, rel=1e-3)
    wider = trim(pair_up(with_static(captured), with_static(other)))
    assert held_distance(wider) == pytest.approx(held_distance(plain) * 4 / 5)


def with_static(motion: Motion) -> Motion:
    marks = landmarks_of(motion)
    return dataclasses.replace(
        motion,
        landmark_names=("clavicle", *motion.landmark_names),
        landmarks=np.concatenate([marks[:, :1], marks], axis=1),
    )


def test_moving_other_joints_does_not_dilute_the_distance_per_arm_length() -> None:
    captured, other = reach(), reach(swing=0.8)
    shaken = landmarks_of(other).copy()
    shaken[:, 0, 1] += 0.05 * np.sin(other.time)
    before = distance_per_arm_length(trim(pair_up(captured, other)))
    shaking = dataclasses.replace(other, landmarks=shaken)
    assert distance_per_arm_length(trim(pair_up(captured, shaking))) == pytest.approx(before)


def test_arm_length_and_a_hand_alone() -> None:
    captured = reach()
    assert arm_length(landmarks_of(captured)) == pytest.approx(0.64, rel=1e-9)
    hand = dataclasses.replace(
        captured, landmark_names=("hand",), landmarks=landmarks_of(captured)[:, -1:]
    )
    trimmed = trim(pair_up(captured, hand))
    assert held_distance(trimmed) == 0
    assert np.isnan(distance_per_arm_length(trimmed))


def test_landmarks_are_matched_by_name_and_the_rest_is_named() -> None:
    captured = reach()
    places = [0, 3, 1]
    shuffled = dataclasses.replace(
        captured,
        landmark_names=("shoulder", "gripper", "elbow"),
        landmarks=landmarks_of(captured)[:, places],
    )
    ends_in_hand = dataclasses.replace(
        shuffled,
        landmark_names=("elbow", "shoulder", "gripper"),
        landmarks=landmarks_of(captured)[:, [1, 0, 3]],
    )
    pair = pair_up(captured, ends_in_hand)
    assert (pair.names, pair.left_out) == (("shoulder", "elbow", "hand"), ("wrist",))
    assert paper_distance(captured, ends_in_hand) == 0
    # The last landmark is the effector, whatever it is called.
    assert paper_distance(captured, shuffled) > 0.1


def test_refusals() -> None:
    captured = reach()
    angles = Motion(captured.time, ("elbow",), np.zeros((captured.frames, 1)), source="file.csv")
    with pytest.raises(FormatError, match=r"file\.csv: only joint angles.*forward kinematics"):
        paper_distance(captured, angles)
    gap = landmarks_of(captured).copy()
    gap[7, 2, 0] = np.nan
    with pytest.raises(CaptureError, match="'wrist' has a gap at frame 7"):
        paper_distance(dataclasses.replace(captured, landmarks=gap), captured)
    with pytest.raises(CaptureError, match="does not move"):
        trim(pair_up(captured, still(posture(FORWARD, FORWARD))))
    with pytest.raises(InputError, match="do not compare"):
        mean_distance(np.zeros((5, 4, 3)), np.zeros((5, 3, 3)))
    with pytest.raises(InputError, match="one frame"):
        mean_distance(np.zeros((0, 4, 3)), np.zeros((5, 4, 3)))


def test_the_paper_distance_ignores_time_stamp_jitter() -> None:
    captured = resample(reach(rest=0.1), 120.0)
    stamps = captured.time.copy()
    stamps[1:-1] += np.random.default_rng(5).uniform(-0.003, 0.003, stamps.size - 2)
    assert paper_distance(captured, at_times(captured, stamps)) < 2e-4
    assert captured.landmark_names == NAMES
