"""Sines and cosines against the standard library's."""

import math

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from armsyn.kernels.trigonometry import sines_and_cosines

JOINT_ANGLE = 4 * math.pi


def sine_and_cosine(angle: float) -> tuple[float, float]:
    sines, cosines = np.empty(1), np.empty(1)
    sines_and_cosines(np.array([angle]), sines, cosines)
    return float(sines[0]), float(cosines[0])


@given(angle=st.floats(-JOINT_ANGLE, JOINT_ANGLE))
@example(angle=0.0)
@example(angle=math.pi / 4)
@example(angle=-math.pi / 2)
@example(angle=math.pi)
@example(angle=5e-324)
def test_angles_of_joints_to_rounding(angle: float) -> None:
    sine, cosine = sine_and_cosine(angle)
    assert abs(sine - math.sin(angle)) < 1e-15
    assert abs(cosine - math.cos(angle)) < 1e-15


@given(angle=st.floats(-1e5, 1e5))
def test_far_angles_to_their_own_rounding(angle: float) -> None:
    sine, cosine = sine_and_cosine(angle)
    allowed = 1e-15 + np.spacing(abs(angle))
    assert abs(sine - math.sin(angle)) < allowed
    assert abs(cosine - math.cos(angle)) < allowed


def test_every_quadrant_and_many_at_once() -> None:
    angles = np.linspace(-10.0, 10.0, 100_003)
    sines, cosines = np.empty_like(angles), np.empty_like(angles)
    sines_and_cosines(angles, sines, cosines)
    np.testing.assert_allclose(sines, np.sin(angles), rtol=0, atol=1e-15)
    np.testing.assert_allclose(cosines, np.cos(angles), rtol=0, atol=1e-15)
    np.testing.assert_allclose(sines**2 + cosines**2, 1.0, rtol=0, atol=1e-15)
