"""Kochanek-Bartels splines against values worked out by hand, and the ease curve."""

import numpy as np
import pytest

from armsyn.editing import KochanekBartels, ease
from armsyn.errors import ConstraintError

POINTS = [0.0, 1.0, 3.0, 4.0]


@pytest.mark.parametrize(
    ("shape", "middle"),
    [((0.0, 0.0, 0.0), 2.0), ((0.0, 0.0, 0.5), 1.9375), ((0.0, 0.5, 0.0), 2.0)],
)
def test_the_middle_of_the_middle_segment(shape: tuple[float, float, float], middle: float) -> None:
    spline = KochanekBartels(np.arange(4.0), np.array(POINTS), *shape)
    assert spline.at([1.5])[0] == pytest.approx(middle, abs=1e-15)


def test_full_tension_goes_straight_and_stops_at_keys() -> None:
    spline = KochanekBartels(np.arange(4.0), np.array(POINTS), tension=1.0)
    np.testing.assert_allclose(spline.at([1.25]), 1.0 + 2.0 * ease(0.25))


def test_keys_are_met_and_held_outside() -> None:
    keys, values = np.array([2.0, 5.0, 6.0]), np.random.default_rng(0).normal(size=(3, 3))
    spline = KochanekBartels(keys, values, 0.2, -0.3, 0.4)
    np.testing.assert_allclose(spline.at(keys), values, atol=1e-14)
    np.testing.assert_array_equal(spline.at([0.0, 9.0]), values[[0, -1]])


def test_uneven_keys_keep_one_speed_through_a_key() -> None:
    spline = KochanekBartels(np.array([0.0, 1.0, 4.0, 6.0]), np.array([0.0, 2.0, 3.0, -1.0]))
    for key in (1.0, 4.0):
        before, at, after = spline.at([key - 1e-6, key, key + 1e-6])
        assert (at - before) == pytest.approx(after - at, rel=1e-4)
    even = KochanekBartels(np.array([0.0, 1.0, 4.0]), np.array([0.0, 1.0, 4.0]))
    np.testing.assert_allclose(even.at([0.5, 2.0, 3.0]), [0.5, 2.0, 3.0], atol=1e-12)


def test_one_key_holds() -> None:
    np.testing.assert_array_equal(KochanekBartels([3.0], [[1.0, 2.0]]).at([0, 3, 7]), [[1, 2]] * 3)


def test_the_ease_curve() -> None:
    np.testing.assert_allclose(ease([-1.0, 0.0, 0.25, 0.5, 1.0, 2.0]), [0, 0, 0.15625, 0.5, 1, 1])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"keys": [0.0, 0.0]}, "increase"),
        ({"keys": [0.0]}, "as many values as keys"),
        ({"values": [0.0, np.nan]}, "finite"),
        ({"bias": 1.5}, "bias 1.5 is not in"),
    ],
)
def test_what_is_no_spline_is_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(ConstraintError, match=words):
        KochanekBartels(**({"keys": [0.0, 1.0], "values": [0.0, 1.0]} | change))
