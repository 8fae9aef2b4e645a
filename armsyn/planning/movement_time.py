"""How long a person takes for a reach: regression on the target and how far away it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain
from armsyn.planning.examples import Examples
from armsyn.planning.features import FEWEST_GROUPS, Kernel, Regression, best_kernel, regression
from armsyn.planning.postures import tips

FloatArray = NDArray[np.float64]

KERNELS = tuple(Kernel(linear) for linear in (0.03, 0.003, 0.01, 0.1, 1.0))


@dataclass(frozen=True)
class MovementTime:
    """Predicts movement times.

    Parameters
    ----------
    fit : Regression
        Of seconds on x, y and z of the target and the hand's distance to it, m.
    shortest, longest : float
        Of the captured movement times, s: no prediction leaves them.
    """

    fit: Regression
    shortest: float
    longest: float

    def __call__(self, chain: SerialChain, starts: FloatArray, targets: FloatArray) -> FloatArray:
        """Return the movement times of reaches from postures to targets, shape (M,), s."""
        features = _features(tips(chain, starts), targets)
        return np.clip(self.fit(features)[:, 0], self.shortest, self.longest)


def learn_movement_time(examples: Examples, fewest: int = FEWEST_GROUPS) -> MovementTime:
    """Fit movement times by ridge regression.

    The penalty is the one that predicts best what is left out, a target at a time.

    Parameters
    ----------
    examples : Examples
    fewest : int
        Targets that such a choice takes; with fewer it is the first of `KERNELS`.

    Returns
    -------
    MovementTime
    """
    features = _features(tips(examples.chain, examples.starts), examples.targets)
    durations = examples.durations[:, None]

    kernel = best_kernel(features, durations, examples.places, KERNELS, fewest)
    return MovementTime(
        regression(features, durations, kernel),
        float(examples.durations.min()),
        float(examples.durations.max()),
    )


def _features(hands: FloatArray, targets: FloatArray) -> FloatArray:
    distance = np.linalg.norm(targets - hands, axis=1, keepdims=True)
    return np.concatenate([targets, distance], axis=1)
