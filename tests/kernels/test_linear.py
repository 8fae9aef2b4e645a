"""Small symmetric systems against numpy.linalg."""

import numpy as np
import pytest

from armsyn.kernels.linear import eigen_symmetric, gram, solve_positive


def symmetric(size: int, eigenvalues: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    Q, _ = np.linalg.qr(rng.normal(size=(size, size)))
    return (Q * eigenvalues) @ Q.T


@pytest.mark.parametrize("shape", [(3, 4), (3, 7), (6, 7), (6, 5)])
def test_gram(shape: tuple[int, int]) -> None:
    J = np.random.default_rng(1).normal(size=shape)
    B = np.full((shape[0], shape[0]), np.nan)
    gram(J, B)
    np.testing.assert_allclose(B, J @ J.T, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(B, B.T)


@pytest.mark.parametrize("size", [1, 2, 3, 6, 9])
@pytest.mark.parametrize("spread", [0.0, 1.0, 6.0, 12.0])
def test_eigenvalues_and_vectors(size: int, spread: float) -> None:
    rng = np.random.default_rng(size)
    for _ in range(20):
        B = symmetric(size, 10.0 ** rng.uniform(-spread, 0.0, size), rng)
        B = 0.5 * (B + B.T)
        D, V = B.copy(), np.empty((size, size))
        eigen_symmetric(D, V)
        values = np.diag(D)
        np.testing.assert_allclose(np.sort(values), np.linalg.eigvalsh(B), rtol=0, atol=1e-14)
        np.testing.assert_allclose(V @ V.T, np.eye(size), rtol=0, atol=1e-13)
        np.testing.assert_allclose((V * values) @ V.T, B, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("B", "values"),
    [
        (np.zeros((3, 3)), [0.0, 0.0, 0.0]),
        (np.eye(3), [1.0, 1.0, 1.0]),
        (np.ones((3, 3)), [0.0, 0.0, 3.0]),
        (np.diag([3.0, -2.0, 0.0]), [-2.0, 0.0, 3.0]),
        (np.array([[1.0, 1e-200], [1e-200, 2.0]]), [1.0, 2.0]),
    ],
)
def test_eigenvalues_in_closed_form(B: np.ndarray, values: list[float]) -> None:
    D, V = B.copy(), np.empty_like(B)
    eigen_symmetric(D, V)
    np.testing.assert_allclose(np.sort(np.diag(D)), values, rtol=0, atol=1e-15)
    np.testing.assert_allclose((V * np.diag(D)) @ V.T, B, rtol=0, atol=1e-15)


@pytest.mark.parametrize("size", [1, 3, 6])
def test_a_positive_system_is_solved(size: int) -> None:
    rng = np.random.default_rng(size)
    B = symmetric(size, 10.0 ** rng.uniform(-4.0, 0.0, size), rng)
    y = rng.normal(size=size)
    wanted = np.linalg.solve(B, y)
    solve_positive(B.copy(), y)
    np.testing.assert_allclose(y, wanted, rtol=1e-10)
