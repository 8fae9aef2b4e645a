"""The function O in its four forms against numpy and closed forms."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armsyn.arm import load_arm
from armsyn.ik import optimiser_settings
from armsyn.kernels.optimisers import OptimiserSettings, change_of_posture, weigh_orientation
from armsyn.kernels.rollout import task_error
from armsyn.kinematics import SerialChain
from tests.kinematics.oracle import random_posture

SHAPES = [(3, 4), (3, 7), (6, 7), (6, 5), (3, 2)]


@pytest.fixture(scope="module")
def human7() -> SerialChain:
    return load_arm("human7").chain


def change(settings: OptimiserSettings, J: np.ndarray, dX: np.ndarray) -> np.ndarray:
    m, n = J.shape
    dq = np.full(n, np.nan)
    change_of_posture(settings, J, dX, np.empty((m, m)), np.empty((m, m)), np.empty(m), dq)
    return dq


def with_singular_values(
    values: list[float], joints: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return a Jacobian of given singular values, and its left singular vectors in columns."""
    U, _ = np.linalg.qr(rng.normal(size=(len(values), len(values))))
    V, _ = np.linalg.qr(rng.normal(size=(joints, joints)))
    return (U * values) @ V[:, : len(values)].T, U


@pytest.mark.parametrize("shape", SHAPES)
def test_svd_is_the_pseudo_inverse(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        J, dX = rng.normal(size=shape), rng.normal(size=shape[0])
        expected = np.linalg.pinv(J, rcond=1e-3) @ dX
        np.testing.assert_allclose(change(optimiser_settings("svd"), J, dX), expected, atol=1e-9)


def test_svd_of_an_arm_is_exact(human7: SerialChain) -> None:
    rng = np.random.default_rng(2)
    for pose in (False, True):
        for _ in range(50):
            J = human7.jacobian(random_posture(human7, rng), pose=pose)
            if np.linalg.cond(J) > 200:
                continue
            dX = rng.normal(size=J.shape[0])
            dq = change(optimiser_settings("svd"), J, dX)
            np.testing.assert_allclose(J @ dq, dX, rtol=0, atol=1e-9)
            np.testing.assert_allclose(dq, np.linalg.pinv(J) @ dX, rtol=0, atol=1e-8)


@pytest.mark.parametrize("weakest", [1.1e-3, 0.9e-3, 1e-5, 0.0])
@pytest.mark.parametrize("others", [[1.0, 0.8], [1.0, 0.7, 0.5, 0.3, 0.1], [1.0, 0.002]])
def test_svd_is_truncated_below_its_cut_off_and_nowhere_else(
    weakest: float, others: list[float]
) -> None:
    rng = np.random.default_rng(3)
    J, U = with_singular_values([*others, weakest], 7, rng)
    dX = rng.normal(size=len(others) + 1)
    dq = change(optimiser_settings("svd", cut_off=1e-3), J, dX)
    np.testing.assert_allclose(dq, np.linalg.pinv(J, rcond=1e-3) @ dX, rtol=1e-6, atol=1e-9)
    lost = U[:, -1] @ (J @ dq - dX)
    gone = abs(lost) == pytest.approx(abs(U[:, -1] @ dX))
    assert gone == (weakest < 1e-3)


def test_svd_without_cut_off_still_ends_at_rounding() -> None:
    rng = np.random.default_rng(4)
    J, _ = with_singular_values([1.0, 0.5, 0.0], 7, rng)
    dq = change(optimiser_settings("svd", cut_off=0.0), J, rng.normal(size=3))
    assert np.linalg.norm(dq) < 100


def test_a_straight_arm_is_not_asked_to_lengthen(human7: SerialChain) -> None:
    J = human7.jacobian(np.zeros(7))
    np.testing.assert_array_equal(
        change(optimiser_settings("svd"), J, np.array([0.0, 0.0, -0.1])), np.zeros(7)
    )
    across = change(optimiser_settings("svd"), J, np.array([0.01, -0.02, -0.1]))
    np.testing.assert_allclose(J @ across, [0.01, -0.02, 0.0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("damping", [0.05, 0.5])
def test_dls_is_its_formula(shape: tuple[int, int], damping: float) -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        J, dX = 0.3 * rng.normal(size=shape), rng.normal(size=shape[0])
        B = J @ J.T + damping**2 * np.eye(shape[0])
        dq = change(optimiser_settings("dls", damping=damping), J, dX)
        np.testing.assert_allclose(dq, J.T @ np.linalg.solve(B, dX), rtol=0, atol=1e-11)


@pytest.mark.parametrize("values", [[1.0, 0.5, 0.0], [1.0, 0.6, 0.4, 0.2, 0.1, 0.0]])
def test_dls_in_singular_values(values: list[float]) -> None:
    rng = np.random.default_rng(6)
    mu = 0.05
    J, U = with_singular_values(values, 7, rng)
    dX = rng.normal(size=len(values))
    moved = J @ change(optimiser_settings("dls", damping=mu), J, dX)
    kept = np.square(values) / (np.square(values) + mu**2)
    np.testing.assert_allclose(U.T @ moved, kept * (U.T @ dX), rtol=0, atol=1e-11)


@pytest.mark.parametrize("shape", SHAPES)
def test_jt_and_njt(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(7)
    for slowing in (0.5, 2.0):
        J, dX = rng.normal(size=shape), rng.normal(size=shape[0])
        plain = change(optimiser_settings("jt"), J, dX)
        np.testing.assert_allclose(plain, J.T @ dX, rtol=0, atol=1e-14)
        normalised = change(optimiser_settings("njt", slowing=slowing), J, dX)
        assert np.linalg.norm(normalised) == pytest.approx(np.linalg.norm(dX) / slowing)
        np.testing.assert_allclose(
            normalised / np.linalg.norm(normalised), plain / np.linalg.norm(plain), atol=1e-14
        )


@pytest.mark.parametrize("name", ["svd", "jt", "njt", "dls"])
def test_nothing_to_do_or_nothing_that_helps(name: str, human7: SerialChain) -> None:
    J = human7.jacobian(np.full(7, 0.4), pose=True)
    np.testing.assert_array_equal(change(optimiser_settings(name), J, np.zeros(6)), np.zeros(7))
    dq = change(optimiser_settings(name), np.zeros((3, 7)), np.ones(3))
    np.testing.assert_array_equal(dq, np.zeros(7))


@pytest.mark.parametrize("name", ["svd", "jt", "njt", "dls"])
def test_inputs_stay_as_they_are(name: str) -> None:
    rng = np.random.default_rng(8)
    J, dX = rng.normal(size=(6, 7)), rng.normal(size=6)
    kept = J.copy(), dX.copy()
    change(optimiser_settings(name), J, dX)
    np.testing.assert_array_equal(J, kept[0])
    np.testing.assert_array_equal(dX, kept[1])


def test_radius_turns_radians_into_metres() -> None:
    rng = np.random.default_rng(9)
    J, dX = rng.normal(size=(6, 7)), rng.normal(size=6)
    weighed, error = J.copy(), dX.copy()
    weigh_orientation(0.2, weighed, error)
    weights = np.array([1, 1, 1, 0.2, 0.2, 0.2])
    np.testing.assert_allclose(weighed, weights[:, None] * J, rtol=1e-15)
    np.testing.assert_allclose(error, weights * dX, rtol=1e-15)
    position = J[:3].copy()
    weigh_orientation(0.2, position, dX[:3].copy())
    np.testing.assert_array_equal(position, J[:3])


ANGLES = [0.0, 1e-12, 1e-8, 1e-5, 0.3, 2.0, 3.0, np.pi - 1e-5, np.pi - 1e-8, np.pi - 1e-12, np.pi]


@pytest.mark.parametrize("angle", ANGLES)
def test_pose_error_is_the_rotation_vector_to_the_target(angle: float) -> None:
    rng = np.random.default_rng(10)
    for _ in range(10):
        axis = rng.normal(size=3)
        w = angle * axis / np.linalg.norm(axis)
        present = Rotation.random(rng=rng).as_matrix()
        wanted = Rotation.from_rotvec(w).as_matrix() @ present
        dX = np.empty(6)
        distance = task_error(np.array([0.3, 0.2, 0.1]), wanted, np.zeros(3), present, dX)
        assert distance == pytest.approx(np.sqrt(0.14))
        np.testing.assert_allclose(dX[:3], [0.3, 0.2, 0.1], rtol=0, atol=1e-15)
        assert np.linalg.norm(dX[3:]) == pytest.approx(angle, abs=1e-7)
        # at half a turn either sense is right, so the turned frame is compared
        turned = Rotation.from_rotvec(dX[3:]).as_matrix() @ present
        np.testing.assert_allclose(turned, wanted, rtol=0, atol=1e-7)
        if 1e-4 < angle < 3.1:
            np.testing.assert_allclose(dX[3:], w, rtol=0, atol=1e-12)
