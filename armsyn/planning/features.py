"""Ridge regression and Gaussian processes on standardised features, chosen on what is left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Kernel:
    """Prior variances of a Gaussian process, in units of the noise's variance.

    Parameters
    ----------
    linear : float
        Of a slope over one standard deviation of a feature; alone it makes ridge regression with
        the penalty ``1 / linear``.
    bumps : float
        Of what departs from the straight line, by a squared-exponential kernel.
    length : float
        Of that, in standard deviations of the features.

    References
    ----------
    Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, 2.2 and 2.7.
    """

    linear: float
    bumps: float = 0.0
    length: float = 1.0


@dataclass(frozen=True)
class Regression:
    """The mean of a Gaussian process given examples.

    Parameters
    ----------
    centre, scale : array, shape (k,)
        Mean and standard deviation of the features.
    mean : array, shape (m,)
        Of the outputs.
    slopes : array, shape (k, m)
        Of the outputs over standardised features.
    length : float
        Of the bumps.
    places : array, shape (N, k)
        Standardised features of the examples; none (N = 0) where there are no bumps.
    weights : array, shape (N, m)
        Of the bumps there.
    """

    centre: FloatArray
    scale: FloatArray
    mean: FloatArray
    slopes: FloatArray
    length: float
    places: FloatArray
    weights: FloatArray

    def __call__(self, features: FloatArray) -> FloatArray:
        """Return the outputs, shape (M, m), for features, shape (M, k)."""
        Z = (features - self.centre) / self.scale
        found = self.mean + Z @ self.slopes
        if len(self.places):
            found += _bumps(Z, self.places, self.length) @ self.weights
        return np.asarray(found)


def regression(features: FloatArray, outputs: FloatArray, kernel: Kernel) -> Regression:
    """Fit the mean of a Gaussian process.

    Parameters
    ----------
    features : array, shape (N, k)
    outputs : array, shape (N, m)
    kernel : Kernel

    Returns
    -------
    Regression
    """
    centre, scale = features.mean(axis=0), np.maximum(features.std(axis=0), 1e-9)
    Z, mean = (features - centre) / scale, outputs.mean(axis=0)
    K = kernel.linear * (Z @ Z.T)
    if kernel.bumps > 0:
        K += kernel.bumps * _bumps(Z, Z, kernel.length)
    weights = np.linalg.solve(K + np.eye(len(Z)), outputs - mean)
    slopes = kernel.linear * (Z.T @ weights)
    kept = len(Z) if kernel.bumps > 0 else 0
    return Regression(
        centre, scale, mean, slopes, kernel.length, Z[:kept], kernel.bumps * weights[:kept]
    )


def _bumps(A: FloatArray, B: FloatArray, length: float) -> FloatArray:
    squares = (A**2).sum(axis=1)[:, None] + (B**2).sum(axis=1) - 2 * A @ B.T
    return np.asarray(np.exp(-0.5 / length**2 * np.maximum(squares, 0.0)))


FEWEST_GROUPS = 12
"""For a choice: leaving out one of seven targets chose worse than no choice at all (HuG-MP)."""


def best_kernel(
    features: FloatArray,
    outputs: FloatArray,
    groups: tuple[str, ...],
    kernels: Sequence[Kernel],
    fewest: int = FEWEST_GROUPS,
) -> Kernel:
    """Return the kernel that predicts best what is left out, a group at a time.

    Parameters
    ----------
    features : array, shape (N, k)
    outputs : array, shape (N, m)
        Their squared errors are added up.
    groups : tuple of str
        Which examples are left out together.
    kernels : sequence of Kernel
        To choose from; with fewer than `fewest` groups, the first.
    fewest : int

    Returns
    -------
    Kernel
    """
    if len(set(groups)) < fewest:
        return kernels[0]
    errors = [(left_out_errors(features, outputs, groups, one) ** 2).sum() for one in kernels]
    return kernels[int(np.argmin(errors))]


def left_out_errors(
    features: FloatArray, outputs: FloatArray, groups: tuple[str, ...], kernel: Kernel
) -> FloatArray:
    """Return how far each example is missed by a fit without its group.

    Parameters
    ----------
    features : array, shape (N, k)
    outputs : array, shape (N, m)
    groups : tuple of str
        Which examples are left out together.
    kernel : Kernel

    Returns
    -------
    array, shape (N, m)
    """
    errors, owner = np.empty_like(outputs), np.array(groups)
    for group in sorted(set(groups)):
        out = owner == group
        fit = regression(features[~out], outputs[~out], kernel)
        errors[out] = fit(features[out]) - outputs[out]
    return errors
