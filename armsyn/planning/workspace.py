"""Parameters over the workspace: what was found at captured places, at any place.

A place is where the hand ends, and where captures begin at several, where it starts: 3 or 6 numbers
of metres. What a field gives for one place does not depend on the others that are asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from armsyn.planning.features import Kernel, Regression, left_out_errors, regression

FloatArray = NDArray[np.float64]

POWER = 2.0
"""Of the inverse distance."""
NEIGHBOURS = 4
SMOOTHING = 1e-3
"""Of thin plates, as a share of the places' spread, squared."""
KERNELS = tuple(
    Kernel(linear=0.0, bumps=bumps, length=length)
    for length in (1.0, 2.0, 4.0)
    for bumps in (0.1, 0.3, 1.0, 3.0, 10.0)
)
"""What Gaussian processes are tried with."""
_TINY, _FLAT = 1e-12, 1e-9


class Field(Protocol):
    """Values over places."""

    def __call__(self, places: FloatArray, /) -> FloatArray:
        """Return the values, shape (M, P), at places, shape (M, k)."""


@dataclass(frozen=True)
class LinearField:
    """A mean, and slopes over places.

    Parameters
    ----------
    centre : array, shape (k,)
    mean : array, shape (P,)
        The value there.
    slopes : array, shape (k, P)
        1/m; zero for one set everywhere.
    """

    centre: FloatArray
    mean: FloatArray
    slopes: FloatArray

    def __call__(self, places: FloatArray, /) -> FloatArray:
        """See `Field`."""
        return np.asarray(self.mean + np.einsum("mk,kp->mp", places - self.centre, self.slopes))


@dataclass(frozen=True)
class Nearest:
    """The value at the nearest captured place.

    Parameters
    ----------
    places : array, shape (N, k)
    values : array, shape (N, P)
    """

    places: FloatArray
    values: FloatArray

    def __call__(self, places: FloatArray, /) -> FloatArray:
        """See `Field`."""
        return np.asarray(self.values[_distances(places, self.places).argmin(axis=1)])


@dataclass(frozen=True)
class InverseDistance:
    """Mean of the four nearest, weighted by 1 / distance^2 (Shepard 1968).

    Parameters
    ----------
    places : array, shape (N, k)
    values : array, shape (N, P)
    """

    places: FloatArray
    values: FloatArray

    def __call__(self, places: FloatArray, /) -> FloatArray:
        """See `Field`."""
        apart = _distances(places, self.places)
        near = np.argsort(apart, axis=1, kind="stable")[:, :NEIGHBOURS]
        weights = np.maximum(np.take_along_axis(apart, near, axis=1), _TINY) ** -POWER
        weights /= weights.sum(axis=1, keepdims=True)
        return np.asarray(np.einsum("mn,mnp->mp", weights, self.values[near]))


@dataclass(frozen=True)
class ThinPlate:
    """A thin-plate spline.

    Parameters
    ----------
    places : array, shape (N, k)
    weights : array, shape (N, P)
    centre : array, shape (k,)
    polynomial : array, shape (1 + k, P)
        Value at the centre, and slopes.
    """

    places: FloatArray
    weights: FloatArray
    centre: FloatArray
    polynomial: FloatArray

    def __call__(self, places: FloatArray, /) -> FloatArray:
        """See `Field`."""
        plates = np.einsum("mn,np->mp", _plates(_distances(places, self.places)), self.weights)
        plane = np.einsum("mk,kp->mp", places - self.centre, self.polynomial[1:])
        return np.asarray(plates + plane + self.polynomial[0])


def thin_plate(places: FloatArray, values: FloatArray) -> ThinPlate:
    """Return the spline ``sum w_i r_i^2 log r_i + c + s x`` through values, a little smoothed.

    Its weights sum to 0, with and without the places as factors (Duchon 1977). Places in one plane
    leave slopes open, of which the least are taken.

    Parameters
    ----------
    places : array, shape (N, k)
    values : array, shape (N, P)

    Returns
    -------
    ThinPlate
    """
    centre, (count, k) = places.mean(axis=0), places.shape
    away = places - centre
    spread = (away**2).sum(axis=1).mean()
    system = np.zeros((count + 1 + k, count + 1 + k))
    system[:count, :count] = _plates(_distances(places, places)) + SMOOTHING * spread * np.eye(
        count
    )
    system[:count, count], system[:count, count + 1 :] = 1.0, away
    system[count:, :count] = system[:count, count:].T
    wanted = np.concatenate([values, np.zeros((1 + k, values.shape[1]))])
    found = np.linalg.lstsq(system, wanted, rcond=_FLAT)[0]
    return ThinPlate(places, found[:count], centre, found[count:])


def gaussian_process(places: FloatArray, values: FloatArray) -> Regression:
    """Return the mean of a Gaussian process about a constant.

    Its kernel, one for all parameters, is the one of `KERNELS` that predicts best each value that
    is left out.

    Parameters
    ----------
    places : array, shape (N, k)
    values : array, shape (N, P)
        In units in which they count alike.

    Returns
    -------
    Regression
    """
    each = tuple(str(row) for row in range(len(places)))

    def error(kernel: Kernel) -> float:
        return float((left_out_errors(places, values, each, kernel) ** 2).mean())

    return regression(places, values, min(KERNELS, key=error))


def _distances(places: FloatArray, others: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(places[:, None] - others, axis=2))


def _plates(apart: FloatArray) -> FloatArray:
    return np.asarray(apart**2 * np.log(np.maximum(apart, _TINY)))
