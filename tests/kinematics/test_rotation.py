"""Rotations against scipy and closed forms, at their delicate places too."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from armsyn.kinematics.rotation import (
    from_expmap,
    from_quaternion_xyzw,
    from_rpy,
    skew,
    to_rpy,
    turning_z_to,
)

angles = st.floats(-2 * np.pi, 2 * np.pi)
triples = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1))
directions = triples.filter(lambda axis: np.linalg.norm(axis) > 1e-3)
CLOSE = {"rtol": 0, "atol": 4e-15}


@given(rpy=st.tuples(angles, angles, angles))
def test_rpy_is_fixed_axis(rpy: tuple[float, float, float]) -> None:
    expected = Rotation.from_euler("xyz", rpy).as_matrix()  # lower case: fixed axes
    np.testing.assert_allclose(from_rpy(rpy), expected, **CLOSE)


def test_rpy_turns_in_order() -> None:
    # roll takes z to -y, yaw then takes -y to x
    np.testing.assert_allclose(from_rpy([np.pi / 2, 0, np.pi / 2])[:, 2], [1, 0, 0], **CLOSE)


@given(rpy=st.tuples(angles, angles | st.sampled_from([np.pi / 2, -np.pi / 2]), angles))
@example(rpy=(0.3, np.pi / 2, 0.4))
@example(rpy=(0.3, -np.pi / 2 + 1e-9, -2.0))
@example(rpy=(0.0, np.pi / 2 - 1e-16, np.pi))
def test_to_rpy_gives_the_matrix_back(rpy: tuple[float, float, float]) -> None:
    R = from_rpy(rpy)
    np.testing.assert_allclose(from_rpy(to_rpy(R)), R, **CLOSE)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_to_rpy_of_products_that_rounding_has_blurred(pitch: float) -> None:
    for A in Rotation.random(50, rng=np.random.default_rng(4)).as_matrix():
        R = A @ A.T @ from_rpy([0.3, pitch, 0.4])
        np.testing.assert_allclose(from_rpy(to_rpy(R)), R, **CLOSE)


@given(
    roll=st.floats(-3.1, 3.1),
    pitch=st.floats(-1.5, 1.5),
    yaw=st.floats(-3.1, 3.1),
)
def test_to_rpy_gives_the_angles_back(roll: float, pitch: float, yaw: float) -> None:
    np.testing.assert_allclose(
        to_rpy(from_rpy([roll, pitch, yaw])), [roll, pitch, yaw], rtol=0, atol=1e-13
    )


sizes = st.floats(0, 7) | st.sampled_from(
    [0.0, 1e-300, 1e-12, 1e-8, 1e-4, np.pi, np.pi - 1e-9, np.pi + 1e-9, 2 * np.pi]
)


@given(axis=directions, angle=sizes)
def test_expmap_agrees_with_scipy(axis: tuple[float, float, float], angle: float) -> None:
    w = angle * np.array(axis) / np.linalg.norm(axis)
    np.testing.assert_allclose(from_expmap(w), Rotation.from_rotvec(w).as_matrix(), **CLOSE)


def test_expmap_at_its_ends() -> None:
    np.testing.assert_array_equal(from_expmap([0, 0, 0]), np.eye(3))
    half_turn = from_expmap(np.pi * np.array([0.6, 0.0, 0.8]))
    n = np.array([0.6, 0.0, 0.8])
    np.testing.assert_allclose(half_turn, 2 * np.outer(n, n) - np.eye(3), **CLOSE)
    small = np.array([1e-9, -2e-9, 3e-9])
    np.testing.assert_allclose(from_expmap(small) - np.eye(3), skew(small), rtol=0, atol=1e-16)


def test_expmap_in_batches() -> None:
    w = np.random.default_rng(1).normal(size=(4, 5, 3))
    expected = Rotation.from_rotvec(w.reshape(-1, 3)).as_matrix().reshape(4, 5, 3, 3)
    np.testing.assert_allclose(from_expmap(w), expected, **CLOSE)


def test_skew_is_the_cross_product() -> None:
    v, u = np.random.default_rng(2).normal(size=(2, 6, 3))
    np.testing.assert_allclose(np.einsum("kij,kj->ki", skew(v), u), np.cross(v, u), **CLOSE)


def test_quaternions_agree_with_scipy_whatever_their_length() -> None:
    q = np.random.default_rng(3).normal(size=(50, 4))
    np.testing.assert_allclose(from_quaternion_xyzw(q), Rotation.from_quat(q).as_matrix(), **CLOSE)


nearly_opposite = st.tuples(
    st.sampled_from([0.0, 1e-160, 1e-16, 1e-9, 1e-7, -2e-6, 1e-3]),
    st.sampled_from([0.0, 1e-12, -1e-6, 1e-4]),
    st.just(-1.0),
)


@given(axis=directions | nearly_opposite)
def test_turning_z_is_the_smallest_rotation_to_an_axis(axis: tuple[float, float, float]) -> None:
    n = np.array(axis) / np.linalg.norm(axis)
    R = turning_z_to(axis)
    np.testing.assert_allclose(R[:, 2], n, **CLOSE)
    np.testing.assert_allclose(R @ R.T, np.eye(3), **CLOSE)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=1e-14)
    # the smallest rotation turns about an axis across z: no twist
    assert R[1, 0] == pytest.approx(R[0, 1], abs=4e-15)
    assert np.trace(R) == pytest.approx(1.0 + 2.0 * n[2], abs=1e-14)
