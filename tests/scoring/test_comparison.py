"""The whole score: what it says, how it says how it was taken, and captures scored for real."""

import dataclasses
import io
import json
import math
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from armsyn.motion import Motion
from armsyn.motion.captures import load_captures
from armsyn.motion.formats import read_motion, write_motion
from armsyn.scoring import compare, measure
from armsyn.scoring.comparison import Comparison
from armsyn.scoring.page import page
from armsyn.scoring.report import as_dict, profile_as_dict
from armsyn.scoring.score import Settings, score_motions
from armsyn.scoring.tables import distance_table, likeness_table

from .arms import reach


def printed(comparison: Comparison) -> str:
    text = io.StringIO()
    console = Console(file=text, width=100)
    console.print(distance_table(comparison))
    return text.getvalue()


def test_a_motion_against_itself_is_perfect() -> None:
    comparison = compare(reach(), reach())
    assert comparison.held_distance == comparison.paper_distance == 0
    assert comparison.normalised_distance == comparison.endpoint_error == 0
    assert comparison.log_time_ratio == 0
    assert comparison.coverage == 1
    assert comparison.refusal is None
    assert comparison.speed_r == pytest.approx(1)
    assert comparison.posture is not None
    assert comparison.posture.upper_arm == pytest.approx(0, abs=1e-7)
    assert comparison.posture.swivel == 0
    assert comparison.captured_profile == comparison.other_profile


def test_a_slower_motion_to_the_same_place() -> None:
    comparison = compare(reach(), reach(duration=2.0))
    assert comparison.log_time_ratio == pytest.approx(math.log(2), abs=0.01)
    assert comparison.normalised_distance < 2e-3 < comparison.held_distance
    assert comparison.refusal == "only 64% of the longer motion is compared"


def test_a_missed_target_is_no_verdict_and_is_said_in_unscaled_metres() -> None:
    captured, missed = reach(), reach(swing=0.7)
    comparison = compare(captured, missed)
    apart = float(np.linalg.norm(captured.hand[-1] - missed.hand[-1]))
    assert comparison.endpoint_error == pytest.approx(apart)
    assert comparison.refusal == f"the target is missed by {100 * apart:.1f} cm"
    assert comparison.coverage == 1


def test_posture_errors_of_a_turned_arm() -> None:
    captured = reach()
    assert captured.landmarks is not None
    turn = math.radians(20)
    turned = captured.landmarks @ np.array(
        [[math.cos(turn), math.sin(turn), 0], [-math.sin(turn), math.cos(turn), 0], [0, 0, 1.0]]
    )
    comparison = compare(captured, dataclasses.replace(captured, landmarks=turned))
    assert comparison.posture is not None
    # About the vertical, a direction at an angle p to it turns by 2 asin(sin p sin(turn / 2)).
    upper = captured.landmarks[:, 1] - captured.landmarks[:, 0]
    sine = np.hypot(upper[:, 0], upper[:, 1]) / np.linalg.norm(upper, axis=1)
    most = 2 * math.asin(sine.max() * math.sin(turn / 2))
    assert 0 < comparison.posture.upper_arm < most
    assert comparison.posture.forearm < turn + 1e-9
    # The swivel's reference is the vertical itself.
    assert comparison.posture.swivel == pytest.approx(0, abs=1e-9)
    assert comparison.posture.swivel_samples == 101


def test_the_elbow_raised_sideways_shows_in_the_swivel() -> None:
    lifted = compare(reach(), reach(side=-1.0))
    assert lifted.posture is not None
    assert math.degrees(lifted.posture.swivel) > 20
    assert lifted.posture.swivel_samples > 50


def test_only_an_arms_segments_are_rebuilt_unless_asked() -> None:
    captured, longer = reach(), reach()
    assert longer.landmarks is not None
    longer = dataclasses.replace(longer, landmarks=longer.landmarks * 1.2)
    assert compare(captured, longer).held_distance == pytest.approx(0, abs=1e-12)
    assert compare(captured, longer, rebuild=False).held_distance > 0.05
    markers = [
        dataclasses.replace(m, landmark_names=("a", "b", "c", "d")) for m in (captured, longer)
    ]
    score = compare(*markers)
    assert not score.rebuilt
    assert score.held_distance > 0.05
    assert compare(*markers, rebuild=True).rebuilt


def without(motion: Motion, name: str) -> Motion:
    assert motion.landmarks is not None
    place = motion.landmark_names.index(name)
    names = (*motion.landmark_names[:place], *motion.landmark_names[place + 1 :])
    landmarks = np.delete(motion.landmarks, place, axis=1)
    return dataclasses.replace(motion, landmark_names=names, landmarks=landmarks)


@pytest.mark.parametrize("mapped", [False, True])
@pytest.mark.parametrize("lacking", ["captured", "other"])
def test_no_segment_is_rebuilt_over_a_landmark_that_one_motion_lacks(
    lacking: str, mapped: bool
) -> None:
    whole = reach()
    assert whole.landmarks is not None
    longer = dataclasses.replace(whole, landmarks=whole.landmarks * 1.2)
    motions = [whole, longer]
    motions[lacking == "other"] = without(motions[lacking == "other"], "wrist")
    pairs = tuple((name, name) for name in ("shoulder", "elbow", "hand")) if mapped else ()
    settings = Settings(joint_map=pairs)
    score = score_motions(("a", motions[0]), ("b", motions[1]), settings)
    comparison = score.comparison
    assert comparison.rebuilt_segments == (True, False)
    # The upper arm's 6 cm are gone, the 6.8 cm from the elbow to the hand are left in the hand
    assert comparison.held_distance == pytest.approx(0.068 / 3, abs=1e-3)
    assert as_dict(comparison)["measured_how"]["segments"] == (
        "the other's shoulder-elbow rebuilt on the captured lengths along their directions;"
        " as given: elbow-hand, no single bone in both"
    )
    assert "as given: elbow-hand" in page(score)


def test_what_lengthens_on_the_way_is_no_bone() -> None:
    captured, other = without(reach(), "elbow"), without(reach(swing=0.7), "elbow")
    comparison = compare(captured, other)
    assert comparison.landmarks == ("shoulder", "wrist", "hand")
    assert comparison.rebuilt_segments == (False, False)
    assert comparison.no_bones == (True, False)
    said = as_dict(comparison)["measured_how"]["segments"]
    assert said == "as given; shoulder-wrist, no single bone in both"


def test_without_named_joints_there_is_no_posture() -> None:
    renamed = dataclasses.replace(reach(), landmark_names=("a", "b", "c", "d"))
    comparison = compare(renamed, renamed)
    assert comparison.posture is None
    assert "direction" not in printed(comparison)
    assert as_dict(comparison)["posture"] is None


def test_report_states_how_it_was_measured_and_is_json() -> None:
    comparison = compare(reach(rate=100.0), reach(rate=200.0, swing=0.85))
    document = json.loads(json.dumps(as_dict(comparison), allow_nan=False))
    assert document["measured_how"] == {
        "landmarks": ["shoulder", "elbow", "wrist", "hand"],
        "landmarks_left_out": [],
        "joint_map": {name: name for name in ("shoulder", "elbow", "wrist", "hand")},
        "alignment": "none: positions as given",
        "segments": "as given",
        "captured_segments_m": pytest.approx([0.30, 0.26, 0.08]),
        "other_segments_m": pytest.approx([0.30, 0.26, 0.08]),
        "paper_rate_hz": 200.0,
        "rate_hz": 200.0,
        "filter": "zero-lag second-order Butterworth low-pass on positions",
        "cutoff_hz": 6.0,
        "cut_fraction_of_peak": 0.05,
        "ldlj_duration": "N / fs",
    }
    assert document["held_distance_m"] == comparison.held_distance
    assert document["other_profile"]["speed_peaks"] == 1
    assert set(document["captured_profile"]) == set(document["other_profile"])


def test_what_is_not_defined_is_null_and_a_dash() -> None:
    captured = reach()
    assert captured.landmarks is not None
    hand = dataclasses.replace(
        captured, landmark_names=("hand",), landmarks=captured.landmarks[:, -1:]
    )
    comparison = compare(hand, hand)
    assert as_dict(comparison)["distance_per_arm_length"] is None
    assert "-" in printed(comparison).split("per arm length")[1].split("\n")[0]
    profile = dataclasses.replace(comparison.captured_profile, min_jerk_r=float("nan"))
    assert profile_as_dict(profile)["min_jerk_r"] is None


def test_table_shows_the_headline_and_the_refusal() -> None:
    text = printed(compare(reach(), reach(swing=0.7)))
    for part in (
        "held distance",
        "no verdict: the target is missed by",
        "swivel",
        "n/a: no repeats",
    ):
        assert part in text


def test_table_of_measures_says_how_they_were_taken() -> None:
    score = score_motions(("a", reach()), ("b", reach(swing=0.7)), Settings())
    text = io.StringIO()
    Console(file=text, width=100).print(likeness_table(score))
    assert "SPARC" in text.getvalue()
    assert "100 Hz, low-pass 6 Hz, cut at 5% of peak" in text.getvalue()
    assert "variance in" not in text.getvalue()  # of joint angles, which these have not


def test_a_file_scores_as_the_motion_it_was_written_from(tmp_path: Path) -> None:
    for suffix in (".csv", ".npz"):
        write_motion(tmp_path / f"reach{suffix}", reach(swing=0.8))
        from_file = compare(reach(), read_motion(tmp_path / f"reach{suffix}"))
        assert from_file == compare(reach(), reach(swing=0.8))


# The targets that the captures' README names as reached with a pelvis that rests.
STILL = [
    "BackHigh",
    "BackMediumNear",
    "ForwardHigh",
    "ForwardMediumFar",
    "ForwardMediumMid",
    "Left30MediumMid",
    "Left30MediumNear",
    "Left60MediumMid",
    "Left60MediumNear",
    "Right120High",
    "Right120Low",
    "Right120MediumFar",
    "Right120MediumMid",
    "Right120MediumNear",
    "Right30High",
    "Right30Low",
    "Right30MediumFar",
    "Right30MediumMid",
    "Right30MediumNear",
]


@pytest.mark.usefixtures("captures")
def test_free_captured_reaches_measure_as_their_readme_says() -> None:
    measures = [measure(c.motion) for c in load_captures(",".join(f"garza:{t}" for t in STILL))]
    assert all(0.6 < m.min_jerk_r <= 1 for m in measures)
    assert all(0.3 <= m.time_to_peak <= 0.7 for m in measures)
    assert np.mean([m.speed_peaks == 1 for m in measures]) > 0.8


@pytest.mark.usefixtures("captures")
def test_repeats_of_a_person_are_as_far_apart_as_published() -> None:
    # 2.73 cm between any two repeats of S01 on the mean; here one pair a target.
    reaches: dict[str, list[Motion]] = {}
    for capture in load_captures("hug_mp:S01"):
        reaches.setdefault(capture.name.rsplit("-", 1)[1], []).append(capture.motion)
    pairs = [tuple(pair) for pair in reaches.values()]
    assert len(pairs) == 7
    held = [compare(a, b).held_distance for a, b in pairs]
    assert 0.015 < np.mean(held) < 0.045


@pytest.mark.usefixtures("captures")
def test_on_captures_the_controls_lose() -> None:
    reaches = load_captures("hug_mp:S01:all")
    captured = reaches[0].motion
    same, wrong = [], []
    for capture in reaches[1:40]:
        to_same_target = capture.name.endswith(":R-1")
        (same if to_same_target else wrong).append(capture.motion)
    repeat = min(same, key=lambda motion: compare(captured, motion).held_distance)
    best = compare(captured, repeat).held_distance
    assert repeat.landmarks is not None
    backwards = dataclasses.replace(repeat, landmarks=repeat.landmarks[::-1])
    assert compare(captured, backwards).held_distance > 3 * best
    assert compare(captured, repeat.between(0, repeat.frames // 3)).held_distance > 2 * best
    assert min(compare(captured, motion).held_distance for motion in wrong) > best
