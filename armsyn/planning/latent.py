"""Whole motions in their latent space: from the target, then on to the exact start and end.

What a target says about a motion is learned by a Gaussian process; what repeats do beside that is
a Gaussian around it. Given the start posture and the target, the likeliest motion is found in the
principal components of that spread by damped steps (latent inverse kinematics: Carvalho, Boulic and
Thalmann, 4.2): the corrections are shared between joints and over time as people's own deviations
are. What the damping leaves is closed by `armsyn.planning.ending.carried_to`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain
from armsyn.planning.ending import carried_to
from armsyn.planning.examples import PHASES, Examples
from armsyn.planning.features import FEWEST_GROUPS, Kernel, Regression, best_kernel, regression
from armsyn.planning.hull import Hull
from armsyn.planning.leading import deviate_each
from armsyn.planning.linear import check_enough
from armsyn.planning.movement_time import MovementTime, learn_movement_time
from armsyn.planning.prediction import Predicted, checked_reaches

FloatArray = NDArray[np.float64]

KERNELS = (
    *(Kernel(linear) for linear in (0.1, 0.03, 0.3, 1.0)),
    *(Kernel(linear, bumps) for linear in (0.1, 1.0) for bumps in (0.1, 1.0)),
)
"""Straight lines first: they are taken where too few targets leave nothing to choose by."""
DAMPING = 1.0
METRES_PER_RADIAN = 0.5
"""What a spread of joint angles at the end counts for the hand."""
VARIANCE = 0.999
"""Share of the motions' variance that their principal components keep."""
MOST_SIGMA = 4.0
"""Norm of the deviation, in standard deviations of people's own: a start or target that asks for
more is none that they would vary to, and the rest of the way is not theirs."""
LEAST_START_RAD = 0.02
LEAST_END_M = 0.005
"""Captures that all start alike (hands laid on an arm's own at rest) say nothing about what another
start changes: their deviations are not stretched to meet it."""
_STEPS = 4


@dataclass(frozen=True)
class LatentPredictor:
    """Predicts the likeliest motion through the start and to the target.

    Parameters
    ----------
    chain : SerialChain
    fit : Regression
        Of coefficients, shape (m,), on the target.
    components : array, shape (m, PHASES * n)
        Principal components of the motions, rad a unit.
    mean : array, shape (PHASES * n,)
        Mean motion, rad.
    deviations : array, shape (k, PHASES * n)
        Principal components of what the fit leaves, each one standard deviation long, rad.
    damping : array, shape (n + 3,)
        Standard deviations to which start posture (rad) and end (m) are met by deviating.
    time : MovementTime
    hull : Hull
        Of the captured targets.
    """

    chain: SerialChain
    fit: Regression
    components: FloatArray
    mean: FloatArray
    deviations: FloatArray
    damping: FloatArray
    time: MovementTime
    hull: Hull

    name: ClassVar[str] = "latent"

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict M reaches; see `armsyn.planning.prediction.Predictor`."""
        first, goals = checked_reaches(self.chain, starts, targets)
        coefficients = self.fit(goals)
        deviation = self.deviation(coefficients, first, goals)
        free = self.mean + np.concatenate([coefficients, deviation], axis=1) @ self._basis
        free = free.reshape(len(goals), PHASES, self.chain.dof)
        angles, errors = carried_to(self.chain, free, first, goals)
        durations = self.time(self.chain, first, goals)
        return Predicted(angles, durations, self.hull.outside(goals), errors)

    @property
    def _basis(self) -> FloatArray:
        return np.concatenate([self.components, self.deviations])

    def deviation(
        self, coefficients: FloatArray, starts: FloatArray, goals: FloatArray
    ) -> FloatArray:
        """Return the likeliest deviations from what targets say.

        They minimise |x|^2 and the squared misses of start posture and target, each over its
        `damping`.

        Parameters
        ----------
        coefficients : array, shape (M, m)
            Of `fit`.
        starts : array, shape (M, n)
        goals : array, shape (M, 3)

        Returns
        -------
        array, shape (M, k)
            In standard deviations, no longer than `MOST_SIGMA`.
        """
        n = self.chain.dof
        x = np.empty((len(goals), len(self.deviations)))
        deviate_each(
            self.chain.arrays,
            np.ascontiguousarray(self.deviations[:, :n]),
            np.ascontiguousarray(self.deviations[:, -n:]),
            starts,
            goals,
            self.damping,
            self.mean[:n] + coefficients @ self.components[:, :n],
            self.mean[-n:] + coefficients @ self.components[:, -n:],
            _STEPS,
            MOST_SIGMA,
            x,
        )
        return x


def learn_latent(
    examples: Examples,
    *,
    kernel: Kernel | None = None,
    damping: float = DAMPING,
    fewest: int = FEWEST_GROUPS,
) -> LatentPredictor:
    """Learn the map from targets to motions and the spread around it.

    Parameters
    ----------
    examples : Examples
        Eight at least, to targets that are not all in one plane.
    kernel : Kernel
        Of the map; by default the one of `KERNELS` that predicts best the motions to a target left
        out.
    damping : float
        Of the deviation that meets the start posture and the end, as a share of the examples' own
        deviations there; 0 would meet them by the pattern alone, however unlikely.
    fewest : int
        Targets that choosing kernels, of motions and of movement times, takes; with fewer they are
        the first of each list.

    Returns
    -------
    LatentPredictor

    Raises
    ------
    CaptureError
        Too few of them, or all in one plane.
    """
    check_enough(examples)
    motions = examples.angles.reshape(examples.size, -1)
    mean = motions.mean(axis=0)
    components = _principal(motions - mean)
    components /= np.linalg.norm(components, axis=1, keepdims=True)
    scores = (motions - mean) @ components.T
    if kernel is None:
        kernel = best_kernel(examples.targets, scores, examples.places, KERNELS, fewest)
    fit = regression(examples.targets, scores, kernel)
    deviations = _principal(motions - mean - fit(examples.targets) @ components)
    return LatentPredictor(
        examples.chain,
        fit,
        components,
        mean,
        deviations,
        _softness(deviations, examples.chain.dof, damping),
        learn_movement_time(examples, fewest),
        Hull.of(examples.targets),
    )


def _softness(deviations: FloatArray, n: int, damping: float) -> FloatArray:
    """Return how firmly start posture and end are met, shape (n + 3,), rad and m."""
    start, end = (
        damping * float(np.sqrt((part**2).sum(axis=0).mean()))
        for part in (deviations[:, :n], deviations[:, -n:])
    )
    return np.array(
        [max(start, LEAST_START_RAD)] * n + [max(METRES_PER_RADIAN * end, LEAST_END_M)] * 3
    )


def _principal(X: FloatArray) -> FloatArray:
    """Return the principal directions of rows, as long as their standard deviations along them."""
    _, singular, E = np.linalg.svd(X, full_matrices=False)
    shares = np.cumsum(singular**2) / np.sum(singular**2)
    kept = int(np.searchsorted(shares, VARIANCE)) + 1
    return np.asarray(singular[:kept, None] / np.sqrt(len(X)) * E[:kept])
