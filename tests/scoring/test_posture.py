"""Directions and swivel against angles worked out by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from armsyn.motion import FloatArray, Motion
from armsyn.scoring import compare
from armsyn.scoring.human_likeness import How, human_likeness
from armsyn.scoring.posture import angles_between, swivel_angles, swivel_differences
from armsyn.scoring.report import as_dict

from .arms import posture

SHOULDER, ELBOW = np.zeros((1, 3)), np.array([[0.2, -0.1, -0.2]])
WRIST = np.array([[0.4, 0.0, -0.1]])


def test_swivel_of_the_oracle_posture() -> None:
    angle = np.degrees(swivel_angles(SHOULDER, ELBOW, WRIST))
    assert angle == pytest.approx(-34.496, abs=5e-4)


@given(turn=st.floats(-3, 3))
def test_turning_the_elbow_about_shoulder_and_wrist_turns_the_swivel(turn: float) -> None:
    axis = WRIST[0] / np.linalg.norm(WRIST)
    turned = Rotation.from_rotvec(turn * axis).apply(ELBOW)
    before = swivel_angles(SHOULDER, ELBOW, WRIST)
    difference = swivel_differences(before, swivel_angles(SHOULDER, turned, WRIST))
    assert difference == pytest.approx(turn, abs=1e-9)


def test_swivel_means_nothing_for_a_straight_or_a_hanging_arm() -> None:
    straight = np.array([[0.2, 0.0, -0.05]])
    assert np.isnan(swivel_angles(SHOULDER, straight, WRIST))
    hanging = np.array([[0.0, 0.0, -0.5]])
    assert np.isnan(swivel_angles(SHOULDER, np.array([[0.1, 0.1, -0.3]]), hanging))
    assert np.isnan(swivel_angles(SHOULDER, ELBOW, SHOULDER))


def test_swivel_differences_go_the_short_way_round() -> None:
    first, second = np.array([3.0, -3.0, np.nan]), np.array([-3.0, 3.0, 1.0])
    short = 2 * np.pi - 6
    np.testing.assert_allclose(swivel_differences(first, second), [short, -short, np.nan])


def test_angles_between_directions() -> None:
    first = np.array([[1.0, 0, 0], [2.0, 0, 0], [1.0, 0, 0], [1.0, 1, 0]])
    second = np.array([[0.0, 5, 0], [3.0, 0, 0], [-1.0, 0, 0], [1.0, 1, 1e-9]])
    np.testing.assert_allclose(angles_between(first, second), [np.pi / 2, 0, np.pi, 0], atol=1e-8)


def carried(arm: FloatArray, turn: float = 0.0, end: float = 0.0) -> Motion:
    """Carry an arm 0.3 m forward, its elbow turned about shoulder and wrist; degrees."""
    time = np.arange(181) / 100
    phase = np.clip((time - 0.4) / 1.0, 0, 1)
    share = (10 * phase**3 - 15 * phase**4 + 6 * phase**5)[:, None]
    axis = (arm[2] - arm[0]) / np.linalg.norm(arm[2] - arm[0])
    turns = Rotation.from_rotvec(np.radians(turn + share * (end - turn)) * axis)
    landmarks = np.repeat(arm[None], time.size, axis=0)
    landmarks[:, 1] = arm[0] + turns.apply(arm[1] - arm[0])
    landmarks += (share * [0.3, 0, 0])[:, None]
    names = ("shoulder", "elbow", "wrist", "hand")
    return Motion(time, landmark_names=names, landmarks=landmarks, source="carried")


ORACLE = np.array([SHOULDER[0], ELBOW[0], WRIST[0], WRIST[0] + [0.08, 0, 0]])


def test_a_forearm_up_instead_of_forward_is_90_degrees_off() -> None:
    forward, up = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    straight, bent = carried(posture(forward, forward)), carried(posture(forward, up))
    errors = as_dict(compare(straight, bent))["posture"]
    assert errors["forearm_direction_deg"] == pytest.approx(90)
    assert errors["upper_arm_direction_deg"] == pytest.approx(0, abs=1e-5)
    assert errors["swivel_end_deg"] is None  # a straight arm has none


def test_swivels_difference_at_the_end_is_the_others_minus_the_captured_ones() -> None:
    errors = as_dict(compare(carried(ORACLE), carried(ORACLE, -10, 25)))["posture"]
    # 35 degrees on the way, of which the cuts at 5 % of the peak speed leave 0.19 % at each end
    assert errors["swivel_end_deg"] == pytest.approx(25, abs=0.1)
    assert 7 < errors["swivel_deg"] < 20
    back = as_dict(compare(carried(ORACLE, -10, 25), carried(ORACLE)))["posture"]
    assert back["swivel_end_deg"] == pytest.approx(-25, abs=0.1)


def test_swivel_at_the_end_and_its_change_are_those_of_the_oracle_posture() -> None:
    held = human_likeness(carried(ORACLE), How())
    assert held["swivel_end_deg"] == pytest.approx(-34.496, abs=5e-4)
    assert held["swivel_change_deg"] == pytest.approx(0, abs=1e-9)
    turned = human_likeness(carried(ORACLE, 40), How())
    assert turned["swivel_end_deg"] == pytest.approx(-34.496, abs=0.2)
    assert turned["swivel_change_deg"] == pytest.approx(-40, abs=0.3)
    # From 175 to -175 degrees it is 10 degrees, not 350
    short = human_likeness(carried(ORACLE, 175 + 34.496, 185 + 34.496), How())
    assert short["swivel_change_deg"] == pytest.approx(10, abs=0.1)
