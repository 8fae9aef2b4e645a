"""Recordings of several movements, and slow reaches whose joints stick and slip."""

import dataclasses

import numpy as np
import pytest

from armsyn.errors import CaptureError, InputError
from armsyn.motion import Motion
from armsyn.scoring import measure
from armsyn.scoring.movements import bouts, only_movement
from armsyn.scoring.score import Settings, score_as_dict, score_motions
from armsyn.scoring.tables import distance_rows

from .arms import NAMES, posture, reach


def there_and_back() -> Motion:
    out = reach()
    assert out.landmarks is not None
    landmarks = np.concatenate([out.landmarks, out.landmarks[::-1][1:]])
    return Motion(
        np.arange(len(landmarks)) / 100, landmark_names=NAMES, landmarks=landmarks, source="both"
    )


def sticking(duration: float, ticks: int) -> Motion:
    """Return a reach of one joint that moves only when it is off by so many ticks of 4096."""
    time = np.arange(round((duration + 1) * 200) + 1) / 200
    phase = np.clip((time - 0.5) / duration, 0, 1)
    wanted = 1.2 * (10 * phase**3 - 15 * phase**4 + 6 * phase**5)
    step = ticks * 2 * np.pi / 4096
    angle = np.empty_like(wanted)
    held = 0.0
    for row, value in enumerate(wanted.tolist()):
        held = value if abs(value - held) > step else held
        angle[row] = held
    upper = np.stack([np.sin(angle), np.zeros_like(angle), -np.cos(angle)], axis=1)
    return Motion(time, landmark_names=NAMES, landmarks=posture(upper, upper), source="sticking")


def test_a_reach_and_its_way_back_are_two() -> None:
    found = bouts(there_and_back())
    assert len(found) == 2
    out, back = found
    assert 0.4 <= out.onset < out.offset <= 1.4
    assert back.onset >= 2.2
    assert out.end == back.begin == pytest.approx(1.8, abs=0.02)
    assert (out.begin, back.end) == (0.0, pytest.approx(3.6))


def test_one_movement_scores_as_if_alone() -> None:
    first = only_movement(there_and_back(), 1)
    assert measure(first).movement_time == pytest.approx(measure(reach()).movement_time, abs=0.011)
    score = score_motions(("a", reach()), ("b", there_and_back()), Settings(movement=1))
    assert score.comparison.held_distance < 1e-3
    document = score_as_dict(score)
    assert document["a_movement"] == {"number": 1, "of": 1}
    assert document["b_movement"] == {"number": 1, "of": 2}
    assert document["paper_distance_of"] == "B: movement 1 of 2"
    remark = distance_rows(score.comparison)[1][2]
    assert "B: movement 1 of 2" in remark
    assert "whole" not in remark
    recording = there_and_back()
    time = np.where(recording.time > 1.8, 3 * recording.time - 3.6, recording.time)
    slow_back = dataclasses.replace(recording, time=time)
    fastest = score_motions(("a", reach()), ("b", slow_back), Settings())
    assert fastest.other_movement == (1, 2)
    assert fastest.comparison.held_distance == pytest.approx(0, abs=1e-3)
    assert fastest.comparison.endpoint_error == pytest.approx(0, abs=1e-6)
    alone = score_motions(("a", reach()), ("b", reach()), Settings())
    assert (alone.other_movement, alone.comparison.coverage) == ((1, 1), 1.0)
    assert score_as_dict(alone)["paper_distance_of"] == "whole motions"
    whole = distance_rows(alone.comparison)[1][2]
    assert whole == "coverage 1.00; whole motions, to the end of the shorter"
    back = score_motions(("a", reach()), ("b", there_and_back()), Settings(movement=2))
    assert back.comparison.held_distance > 0.1
    remark = distance_rows(back.comparison)[1][2]
    assert "no verdict: the target is missed" in remark
    assert remark.endswith("B: movement 2 of 2")


def test_movements_of_both_can_be_chosen() -> None:
    both = ("both", there_and_back())
    score = score_motions(both, both, Settings(captured_movement=2, movement=2))
    assert score.captured_movement == score.other_movement == (2, 2)
    assert score.comparison.cut_out == "A: movement 2 of 2, B: movement 2 of 2"
    assert score.comparison.held_distance == 0
    assert score_motions(both, both, Settings(movement=1)).comparison.held_distance > 0.1


def test_a_movement_that_is_not_there_is_refused_with_those_that_are() -> None:
    with pytest.raises(InputError, match=r"no movement 3; it holds 2: 0\.\d+-1\.\d+ s, "):
        only_movement(there_and_back(), 3)


def test_a_hand_that_rests_has_none() -> None:
    still = reach()
    assert still.landmarks is not None
    still = dataclasses.replace(still, landmarks=np.repeat(still.landmarks[:1], still.frames, 0))
    with pytest.raises(CaptureError, match="does not move"):
        measure(still)
    assert bouts(still) == []


@pytest.mark.parametrize(("duration", "ticks"), [(6.0, 4), (12.0, 4), (20.0, 4), (12.0, 10)])
def test_a_slow_reach_that_sticks_and_slips_is_measured_whole(duration: float, ticks: int) -> None:
    slow = sticking(duration, ticks)
    # Of minimum jerk 0.881 of the time lie above 5 % of the peak; slips raise the peak, so less.
    assert 0.7 * duration < measure(slow).movement_time < 0.9 * duration
    assert len(bouts(slow)) == 1
