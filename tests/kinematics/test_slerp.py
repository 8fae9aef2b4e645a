"""Quaternions of exponential maps, their signs along a path, and slerp, against scipy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from armsyn.kinematics import quaternion


def test_quaternions_of_exponential_maps_of_any_length() -> None:
    w = np.random.default_rng(0).normal(scale=3.0, size=(50, 3))
    w[0] = 0.0
    wanted = Rotation.from_rotvec(w).as_matrix()
    found = Rotation.from_quat(quaternion.from_expmap(w)).as_matrix()
    np.testing.assert_allclose(found, wanted, atol=1e-13)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.9, 1.0])
def test_slerp_is_scipys(share: float) -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        pair = Rotation.from_rotvec(rng.normal(scale=1.5, size=(2, 3)))
        q = quaternion.sign_continuous(pair.as_quat())
        found = Rotation.from_quat(quaternion.slerp(q[0], q[1], share))
        assert (found * Slerp([0, 1], pair)(share).inv()).magnitude() < 1e-12


def test_slerp_between_the_same_quaternions_is_exact() -> None:
    q = quaternion.from_expmap([0.1, 0.2, 0.3])
    np.testing.assert_allclose(quaternion.slerp(q, q, 0.3), q, atol=1e-16)


def test_signs_are_continuous_along_a_path() -> None:
    path = quaternion.from_expmap(np.linspace(0.0, 9.0, 40)[:, None] * [0.0, 0.6, 0.8])
    flipped = path.copy()
    flipped[[3, 4, 5, 17, 39]] *= -1.0
    np.testing.assert_array_equal(quaternion.sign_continuous(flipped), path)
