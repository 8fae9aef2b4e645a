"""The compiled chain: its Jacobian is the derivative of its positions."""

import numpy as np
import pytest

from armsyn.kernels import chain as kernels
from armsyn.kinematics import Joint, SerialChain
from tests.kinematics.oracle import angular_differences, differences

STANFORD = SerialChain(
    (
        Joint("turn", xyz=(0.0, 0.1, 0.4)),
        Joint("tilt", xyz=(0.0, 0.15, 0.0), rpy=(0.3, -0.2, 0.9), axis=(0.0, 1.0, 0.0)),
        Joint("slide", "prismatic", axis=(0.0, 0.6, -0.8), lower=0.1, upper=0.5),
        Joint("roll", xyz=(0.0, 0.0, 0.2), axis=(-1.0, 0.0, 0.0)),
        Joint("bend", rpy=(np.pi, 0.0, 0.0), axis=(0.0, 0.0, -1.0)),
    ),
    tip_xyz=(0.05, -0.02, 0.08),
    tip_rpy=(0.1, 0.2, 0.3),
).arrays


def forward(q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    n = q.size
    origins, axes, tip = np.empty((n + 1, 3)), np.empty((n, 3)), np.empty((3, 3))
    kernels.forward(
        STANFORD.rotation,
        STANFORD.translation,
        STANFORD.prismatic,
        q,
        np.empty(n),
        np.empty(n),
        origins,
        axes,
        tip,
    )
    return origins, axes, tip


@pytest.mark.parametrize("seed", range(10))
def test_jacobian_is_the_derivative(seed: int) -> None:
    q = np.random.default_rng(seed).uniform(-2.0, 2.0, 5)
    J = np.empty((6, 5))
    kernels.jacobian_at(STANFORD, q, J)
    moved = differences(lambda at: forward(at)[0][-1], q)
    turned = angular_differences(lambda at: forward(at)[2], q)
    np.testing.assert_allclose(J, np.concatenate([moved, turned]), rtol=0, atol=1e-8)
    position_only = np.empty((3, 5))
    kernels.jacobian_at(STANFORD, q, position_only)
    np.testing.assert_array_equal(position_only, J[:3])


@pytest.mark.parametrize("seed", range(5))
def test_axes_and_tip_are_orthonormal(seed: int) -> None:
    q = np.random.default_rng(seed).uniform(-2.0, 2.0, 5)
    _, axes, tip = forward(q)
    np.testing.assert_allclose(np.linalg.norm(axes, axis=1), 1.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(tip @ tip.T, np.eye(3), rtol=0, atol=1e-14)
    assert np.linalg.det(tip) == pytest.approx(1.0)


def test_positions_along_a_path_are_those_of_its_postures() -> None:
    path = np.random.default_rng(3).uniform(-2.0, 2.0, (12, 5))
    expected = [forward(q)[0] for q in path]
    np.testing.assert_array_equal(kernels.positions_along(STANFORD, path), expected)
