"""Eight doubles side by side, against the same written for arrays."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

from armsyn.kernels.vectors import WIDTH, eight, greater, less, load, magnitude, store

FloatArray = NDArray[np.float64]


@numba.njit
def reckoned(one: FloatArray, other: FloatArray, found: FloatArray) -> None:
    x, y = load(one, 3), load(other, 1)
    store(found[0], 0, x + y * 2.0)
    store(found[1], 0, 1.0 - x * y)
    store(found[2], 0, magnitude(x))
    store(found[3], 0, greater(x, y))
    store(found[4], 0, less(x, eight(0.25)))


def test_lanes_are_reckoned_with_as_arrays() -> None:
    rng = np.random.default_rng(4)
    one, other = rng.normal(size=(2, WIDTH + 3))
    found = np.empty((5, WIDTH))
    reckoned(one, other, found)
    x, y = one[3 : 3 + WIDTH], other[1 : 1 + WIDTH]
    wanted = [x + 2.0 * y, 1.0 - x * y, abs(x), np.maximum(x, y), np.minimum(x, 0.25)]
    np.testing.assert_allclose(found, wanted, rtol=1e-15, atol=1e-15)


def test_what_is_no_number_gives_way_to_the_second() -> None:
    one, other, found = np.full(16, np.nan), np.arange(16.0), np.empty((5, WIDTH))
    reckoned(one, other, found)
    np.testing.assert_array_equal(found[3], other[1 : 1 + WIDTH])
    np.testing.assert_array_equal(found[4], 0.25)
    assert np.isnan(found[:3]).all()


def test_rows_apart_are_not_taken_for_neighbours() -> None:
    with pytest.raises(numba.TypingError, match="contiguous"):
        reckoned(np.zeros((16, 2))[:, 0], np.zeros(16), np.empty((5, WIDTH)))
