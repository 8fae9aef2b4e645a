"""Linear regression of whole normalised motions on the target: the baseline to beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import CaptureError
from armsyn.kinematics import SerialChain
from armsyn.planning.ending import led_to
from armsyn.planning.examples import PHASES, Examples
from armsyn.planning.hull import Hull
from armsyn.planning.prediction import Predicted, checked_reaches

FloatArray = NDArray[np.float64]

FEWEST = 8
"""Examples, for a map of four coefficients that is more than their own copy."""


@dataclass(frozen=True)
class LinearPredictor:
    """Predicts by a linear map from the target, start and end corrected.

    Parameters
    ----------
    chain : SerialChain
    motions : array, shape (4, PHASES * n)
        Coefficients of joint angles on ``[1, x, y, z]``, rad (and rad/m).
    times : array, shape (4,)
        The same of movement times, s.
    shortest, longest : float
        Of the captured movement times, s: no prediction leaves them.
    hull : Hull
        Of the captured targets.
    """

    chain: SerialChain
    motions: FloatArray
    times: FloatArray
    shortest: float
    longest: float
    hull: Hull

    name: ClassVar[str] = "linear"

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict M reaches; see `armsyn.planning.prediction.Predictor`."""
        first, goals = checked_reaches(self.chain, starts, targets)
        X = with_one(goals)
        free = (X @ self.motions).reshape(len(goals), PHASES, self.chain.dof)
        angles, errors = led_to(self.chain, free, first, goals)
        durations = np.clip(X @ self.times, self.shortest, self.longest)
        return Predicted(angles, durations, self.hull.outside(goals), errors)


def learn_linear(examples: Examples) -> LinearPredictor:
    """Fit the map by least squares.

    Parameters
    ----------
    examples : Examples
        Eight at least, to targets that are not all in one plane.

    Returns
    -------
    LinearPredictor

    Raises
    ------
    CaptureError
        Too few of them, or all in one plane.
    """
    check_enough(examples)
    hull = Hull.of(examples.targets)
    X = with_one(examples.targets)
    inverse = np.asarray(np.linalg.pinv(X), dtype=np.float64)
    motions, times = (
        inverse @ examples.angles.reshape(examples.size, -1),
        inverse @ examples.durations,
    )
    shortest, longest = float(examples.durations.min()), float(examples.durations.max())
    return LinearPredictor(examples.chain, motions, times, shortest, longest, hull)


def check_enough(examples: Examples) -> None:
    """Raise CaptureError when there are too few reaches to learn from."""
    if examples.size < FEWEST:
        raise CaptureError(f"{examples.size} captured reaches: learning needs {FEWEST} at least")


def with_one(features: FloatArray) -> FloatArray:
    """Return features, shape (M, k), with a first column of ones."""
    return np.concatenate([np.ones((len(features), 1)), features], axis=1)
