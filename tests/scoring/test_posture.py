"""Directions and swivel against angles worked out by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from armsyn.scoring.posture import angles_between, swivel_angles, swivel_differences

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
