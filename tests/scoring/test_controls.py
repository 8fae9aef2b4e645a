"""On captured reaches: the controls that must lose, rebuilt segments, one transform a session.

The controls are made of a good stand-in: another repeat of the same person to the same target. What
is done to it must never score better than it does itself.
"""

import dataclasses
from functools import cache

import numpy as np
import pytest

from armsyn.errors import CaptureError
from armsyn.kinematics.rotation import from_expmap
from armsyn.motion import FloatArray, Motion
from armsyn.motion.base_transform import fit_base_transform
from armsyn.motion.captures import load_captures
from armsyn.motion.rebuilding import rebuild_segments, segment_lengths
from armsyn.motion.resample import interpolate
from armsyn.scoring import compare
from armsyn.scoring.floor import human_floor
from armsyn.scoring.repeats import repeats_in

pytestmark = pytest.mark.usefixtures("captures")
PAIRS = {
    "1.1.1:R-1": "3.1.1:R-1",
    "1.2.1:R-2": "7.2.1:R-2",
    "1.4.3:R-3": "3.4.3:R-3",
    "1.1.4:R-4": "4.1.4:R-4",
    "1.2.4:R-9": "7.2.4:R-9",
    "1.3.1:R-10": "10.3.1:R-10",
    "1.3.4:R-11": "2.3.4:R-11",
}
"""The first reach of S01 to each target, and the nearest to it (held distance) of its repeats."""


@cache
def reaches() -> dict[str, Motion]:
    return {capture.name: capture.motion for capture in load_captures("hug_mp:S01:all")}


def landmarks_of(motion: Motion) -> FloatArray:
    assert motion.landmarks is not None
    return motion.landmarks


def held(captured: Motion, other: Motion) -> float:
    return compare(captured, other).held_distance


def pairs() -> list[tuple[Motion, Motion]]:
    return [tuple(reaches()[f"hug_mp:S01:{name}"] for name in pair) for pair in PAIRS.items()]  # type: ignore[misc]


def test_a_reach_run_backwards_loses() -> None:
    for captured, repeat in pairs():
        backwards = dataclasses.replace(repeat, landmarks=landmarks_of(repeat)[::-1])
        assert held(captured, backwards) > 3 * held(captured, repeat)


def test_the_same_path_at_constant_speed_loses() -> None:
    for captured, repeat in pairs():
        landmarks = landmarks_of(captured)
        travelled = np.linalg.norm(np.diff(captured.hand, axis=0), axis=1).cumsum()
        travelled = np.concatenate([[0.0], travelled]) / travelled[-1]
        evenly = interpolate(travelled, landmarks, np.linspace(0, 1, captured.frames))
        score = compare(captured, dataclasses.replace(captured, landmarks=evenly))
        # The path is perfect, as is where it ends: only the speed tells.
        assert score.endpoint_error == pytest.approx(0, abs=1e-9)
        assert score.held_distance > 1.2 * held(captured, repeat)
        assert score.other_profile.peak_over_mean < 1.2 < score.captured_profile.peak_over_mean
        assert score.speed_r < 0.8


def test_the_elbow_mirrored_in_the_plane_of_shoulder_and_hand_loses() -> None:
    for captured, repeat in pairs():
        landmarks = landmarks_of(captured).copy()
        line = landmarks[:, 2] - landmarks[:, 0]
        upright = np.cross(line, np.cross([0.0, 0.0, 1.0], line))
        across = np.cross(line, upright)
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        elbow = landmarks[:, 1] - landmarks[:, 0]
        landmarks[:, 1] -= 2 * (elbow * across).sum(axis=1, keepdims=True) * across
        score = compare(captured, dataclasses.replace(captured, landmarks=landmarks))
        # The hand is perfect: only the arm's posture tells.
        assert score.endpoint_error == 0
        assert score.speed_r == pytest.approx(1)
        assert score.held_distance > 2 * held(captured, repeat)
        assert score.posture is not None
        assert np.rad2deg(score.posture.swivel) > 50


@pytest.mark.parametrize("share", [0.1, 0.25, 0.5])
def test_a_recording_cut_short_loses_and_its_paper_distance_is_refused(share: float) -> None:
    for captured, repeat in pairs():
        score = compare(captured, repeat.between(0, round(share * repeat.frames)))
        assert score.held_distance > 1.3 * held(captured, repeat)
        assert score.refusal is not None


def test_the_more_of_a_reach_is_missing_the_worse_it_scores() -> None:
    for captured, _ in pairs():
        shares = (1.0, 0.9, 0.75, 0.5, 0.25, 0.1)
        cuts = [captured.between(0, round(share * captured.frames) - 1) for share in shares]
        distances = [held(captured, cut) for cut in cuts]
        assert distances[0] == 0
        assert (np.diff(distances) > 0).all()


def test_a_wrong_target_cut_at_once_fools_the_paper_but_not_the_headline() -> None:
    captured = pairs()[0][0]
    wrong = pairs()[4][0].between(0, 15)
    score = compare(captured, wrong)
    assert score.paper_distance < 0.2 * score.held_distance
    assert score.refusal is not None


@pytest.mark.parametrize("rest", [0.3, 1.0, 3.0])
def test_appended_rest_never_pays(rest: float) -> None:
    for captured, repeat in pairs():
        still = np.repeat(landmarks_of(repeat)[-1:], round(rest * 100), axis=0)
        landmarks = np.concatenate([landmarks_of(repeat), still])
        rested = Motion(
            time=np.arange(len(landmarks)) / 100,
            landmark_names=repeat.landmark_names,
            landmarks=landmarks,
        )
        assert held(captured, rested) >= held(captured, repeat) - 1e-12


def test_two_people_of_other_proportions_differ_by_nothing_once_rebuilt() -> None:
    for captured, _ in pairs():
        robot = _with_lengths(captured, np.array([0.20, 0.30]))
        scale = 0.68 / 0.50
        scaled = dataclasses.replace(robot, landmarks=landmarks_of(robot) * scale)
        raw = compare(captured, robot, rebuild=False)
        rebuilt = compare(captured, robot)
        assert raw.held_distance > 0.05
        assert 0.005 < compare(captured, scaled, rebuild=False).held_distance < 0.05
        assert rebuilt.held_distance == pytest.approx(0, abs=2e-3)  # onset is of another hand
        assert rebuilt.rebuilt
        assert not raw.rebuilt
        assert rebuilt.normalised_distance < 2e-3
        # Rebuilding hides no miss: the endpoint is that of the arm as it is.
        assert rebuilt.endpoint_error == raw.endpoint_error > 0.1


def _with_lengths(motion: Motion, lengths: FloatArray) -> Motion:
    landmarks = rebuild_segments(landmarks_of(motion), lengths)
    assert segment_lengths(landmarks) == pytest.approx(lengths)
    return dataclasses.replace(motion, landmarks=landmarks)


TURN = from_expmap([0.2, -0.1, 0.7])
SHIFT = np.array([0.4, -0.2, 0.9])


def _elsewhere(motion: Motion) -> Motion:
    """Return the motion as a base sees it that is turned and moved."""
    return dataclasses.replace(motion, landmarks=(landmarks_of(motion) - SHIFT) @ TURN)


def _poses() -> Motion:
    rows = [landmarks_of(motion)[-1] for motion, _ in pairs()]
    return Motion(
        np.arange(7.0), landmark_names=("shoulder", "elbow", "hand"), landmarks=rows, source="poses"
    )


def test_one_transform_from_calibration_poses_brings_a_whole_session_home() -> None:
    fitted = fit_base_transform(_poses(), _elsewhere(_poses()))
    np.testing.assert_allclose(fitted.rotation, TURN, atol=1e-9)
    np.testing.assert_allclose(fitted.translation, SHIFT, atol=1e-9)
    assert fitted.residual < 1e-9
    assert fitted.poses == 7
    for captured, repeat in pairs():
        home = fitted.apply(_elsewhere(repeat))
        assert held(captured, home) == pytest.approx(held(captured, repeat), abs=1e-9)


def test_a_transform_fitted_to_the_trial_would_forgive_the_wrong_target() -> None:
    captured, wrong = pairs()[0][0], pairs()[4][0]
    frames = min(captured.frames, wrong.frames)
    trial = fit_base_transform(captured.between(0, frames - 1), wrong.between(0, frames - 1))
    assert held(captured, trial.apply(wrong)) < 0.9 * held(captured, wrong)


def test_poses_that_fix_no_transform_are_refused() -> None:
    poses = _poses()
    with pytest.raises(CaptureError, match=r"7 frames, .* 6: the same postures"):
        fit_base_transform(poses, poses.between(0, 5))
    hand = dataclasses.replace(
        poses.between(0, 1), landmark_names=("hand",), landmarks=landmarks_of(poses)[:2, 2:]
    )
    with pytest.raises(CaptureError, match="on one line"):
        fit_base_transform(hand, hand)


def test_repeats_of_a_person_score_about_one_human_floor() -> None:
    of_name = dict(repeats_in(list(reaches().items())))
    name = next(name for name in of_name if name.endswith(":R-3"))
    floor = human_floor(*of_name[name])
    scores = [compare(of_name[name].captured, m, floor=floor) for m in of_name[name].others]
    ratios = [score.over_floor for score in scores]
    assert 0.7 < np.median(ratios) < 3
    wrong = compare(of_name[name].captured, pairs()[4][0], floor=floor)
    assert wrong.over_floor > 3
