"""Ticks and radians against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armsyn.arm import Calibration

CALIBRATION = Calibration(np.array([2048, 1000]), np.array([1, -1]))


@pytest.mark.parametrize(
    ("angles", "ticks"),
    [
        ([0.0, 0.0], [2048, 1000]),
        ([np.pi / 2, np.pi / 2], [3072, -24]),
        ([-np.pi, -np.pi], [0, 3048]),
        ([2 * np.pi / 4096 * 0.49, 2 * np.pi / 4096 * 0.51], [2048, 999]),
    ],
)
def test_known_angles(angles: list[float], ticks: list[int]) -> None:
    assert CALIBRATION.to_ticks(angles).tolist() == ticks


@given(st.lists(st.integers(-(2**20), 2**20), min_size=2, max_size=2))
def test_ticks_survive_the_way_through_radians(ticks: list[int]) -> None:
    assert CALIBRATION.to_ticks(CALIBRATION.to_radians(ticks)).tolist() == ticks


@given(st.lists(st.floats(-10.0, 10.0), min_size=2, max_size=2))
def test_an_angle_is_off_by_half_a_tick_at_most(angles: list[float]) -> None:
    back = CALIBRATION.to_radians(CALIBRATION.to_ticks(angles))
    assert np.abs(back - angles).max() <= np.pi / 4096 + 1e-12


def test_a_path_is_converted_row_by_row() -> None:
    path = np.array([[0.0, 0.0], [np.pi / 2, np.pi / 2]])
    assert CALIBRATION.to_ticks(path).tolist() == [[2048, 1000], [3072, -24]]
    assert CALIBRATION.to_radians([[2048, 1000]]).shape == (1, 2)
