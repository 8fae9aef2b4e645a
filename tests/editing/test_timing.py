"""Time normalisation and branches of exponential maps."""

import numpy as np
import pytest

from armsyn.editing.pattern.branches import nearest_branch, unwrapped
from armsyn.editing.pattern.timing import normalised_poses, phases
from armsyn.kinematics import quaternion

TURNS = np.array([0])
AXES = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def rotation_between(first: np.ndarray, second: np.ndarray) -> float:
    """Angle between two rotations given as exponential maps, rad."""
    q, p = quaternion.from_expmap(first), quaternion.from_expmap(second)
    return float(2.0 * np.arccos(min(1.0, abs(float(q @ p)))))


@pytest.mark.parametrize(("degrees", "apart"), [(30, 0.24), (60, 2.0), (120, 16.7), (170, 45.7)])
def test_slerp_departs_from_interpolated_exponential_maps(degrees: float, apart: float) -> None:
    ends = AXES * np.radians(degrees)
    share = np.linspace(0.0, 1.0, 201)
    slerped = normalised_poses(np.array([0.0, 1.0]), ends, TURNS, 201)
    lerped = (1 - share)[:, None] * ends[0] + share[:, None] * ends[1]
    worst = max(rotation_between(a, b) for a, b in zip(slerped, lerped, strict=True))
    assert np.degrees(worst) == pytest.approx(apart, rel=0.04)


def test_the_ends_and_other_columns_stay() -> None:
    time = np.array([0.0, 0.1, 0.4, 1.0])
    poses = np.random.default_rng(0).normal(size=(4, 5))
    found = normalised_poses(time, poses, TURNS, 11)
    np.testing.assert_allclose(found[[0, -1]], poses[[0, -1]], atol=1e-12)
    np.testing.assert_allclose(found[:, 3], np.interp(np.linspace(0, 1, 11), time, poses[:, 3]))
    np.testing.assert_allclose(found[[1, 4]], poses[[1, 2]], atol=1e-12)


def test_uneven_stamps_have_their_phase() -> None:
    np.testing.assert_allclose(phases(np.array([2.0, 2.5, 4.0]), 101), [0.0, 25.0, 100.0])


def test_means_across_pi_stay_there() -> None:
    axis = np.array([0.0, 0.6, 0.8])
    w = quaternion.to_expmap(quaternion.from_expmap(np.radians([[175.0], [185.0]]) * axis))
    assert np.linalg.norm(w.mean(axis=0)) < 1e-12
    mean = np.array([w[0], nearest_branch(w[1], w[0])]).mean(axis=0)
    np.testing.assert_allclose(mean, np.pi * axis, atol=1e-12)


def test_unwrapping_follows_many_turns_through_the_identity() -> None:
    angles = np.linspace(0.5, 20.0, 200)
    path = angles[:, None, None] * np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0]])
    wrapped = quaternion.to_expmap(quaternion.from_expmap(path))
    assert np.abs(np.diff(wrapped, axis=0)).max() > 3.0
    np.testing.assert_allclose(unwrapped(wrapped), path, atol=1e-9)


def test_unwrapping_starts_where_it_is_told() -> None:
    path = np.radians([[-170.0], [-175.0], [175.0]]) * np.array([0.0, 0.0, 1.0])
    wanted = np.radians([[190.0], [185.0], [175.0]]) * np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(unwrapped(path, np.array([0.0, 0.0, 3.0])), wanted, atol=1e-12)


def test_what_needs_no_unwrapping_keeps_its_bits() -> None:
    path = np.cumsum(np.random.default_rng(2).normal(scale=0.05, size=(60, 4, 3)), axis=0)
    assert unwrapped(path).tobytes() == path.tobytes()


def test_a_motion_that_is_normalised_already_keeps_its_bits() -> None:
    poses = np.random.default_rng(3).normal(size=(7, 5))
    found = normalised_poses(np.linspace(0.2, 0.8, 7), poses, TURNS, 7)
    assert found.tobytes() == poses.tobytes()
