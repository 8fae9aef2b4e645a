"""Fields through values at places: exact where they should be, tame between and beyond."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator

from armsyn.planning.synergy_fitting import FIELDS
from armsyn.planning.workspace import (
    SMOOTHING,
    InverseDistance,
    Nearest,
    gaussian_process,
    thin_plate,
)

RANDOM = np.random.default_rng(11)
PLACES = RANDOM.uniform(-0.4, 0.4, (20, 3))
VALUES = np.column_stack([PLACES @ [1.0, -0.5, 0.2] + 2.0, np.sin(4.0 * PLACES[:, 0])])
BETWEEN = RANDOM.uniform(-0.3, 0.3, (50, 3))
INTERPOLATING = [name for name, make in FIELDS.items() if make is not None]


def test_nearest_and_inverse_distance_give_a_captured_place_its_own_value() -> None:
    assert (Nearest(PLACES, VALUES)(PLACES) == VALUES).all()
    assert InverseDistance(PLACES, VALUES)(PLACES) == pytest.approx(VALUES, abs=1e-9)


def test_inverse_distance_is_shepards_formula_over_the_four_nearest() -> None:
    found = InverseDistance(PLACES, VALUES)(BETWEEN)
    for place, value in zip(BETWEEN, found, strict=True):
        apart = np.linalg.norm(PLACES - place, axis=1)
        near = sorted(range(len(PLACES)), key=lambda row: apart[row])[:4]
        weights = [apart[row] ** -2 for row in near]
        assert value == pytest.approx(np.average(VALUES[near], axis=0, weights=weights))


def test_thin_plates_are_those_of_scipy() -> None:
    smoothing = SMOOTHING * ((PLACES - PLACES.mean(axis=0)) ** 2).sum(axis=1).mean()
    oracle = RBFInterpolator(PLACES, VALUES, kernel="thin_plate_spline", smoothing=smoothing)
    assert thin_plate(PLACES, VALUES)(BETWEEN) == pytest.approx(oracle(BETWEEN), abs=1e-8)


def test_thin_plates_through_places_in_a_plane_stay_tame() -> None:
    flat = PLACES * [1.0, 1.0, 0.0]
    found = thin_plate(flat, VALUES)(BETWEEN + np.array([0.0, 0.0, 0.5]))
    assert np.abs(found).max() < 10.0


def test_a_gaussian_process_finds_smooth_values_between_places() -> None:
    truth = np.column_stack([BETWEEN @ [1.0, -0.5, 0.2] + 2.0, np.sin(4.0 * BETWEEN[:, 0])])
    found = gaussian_process(PLACES, VALUES)(BETWEEN)
    plain = np.abs(truth - VALUES.mean(axis=0)).mean()
    assert np.abs(found - truth).mean() < 0.2 * plain


@pytest.mark.parametrize("name", INTERPOLATING)
def test_values_do_not_depend_on_what_else_is_asked(name: str) -> None:
    make = FIELDS[name]
    assert make is not None
    field = make(PLACES, VALUES)
    together: NDArray[np.float64] = field(BETWEEN)
    alone = np.concatenate([field(one[None]) for one in BETWEEN])
    assert together == pytest.approx(alone, abs=1e-12)
