"""Both papers joined: synergies roll motions out, and what they leave is added in latent space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain
from armsyn.planning.ending import ended_at
from armsyn.planning.examples import PHASES, Examples
from armsyn.planning.features import Kernel, Regression, regression
from armsyn.planning.prediction import Predicted
from armsyn.planning.synergy_atlas import SynergyPredictor, learn_synergies

FloatArray = NDArray[np.float64]

KERNEL = Kernel(linear=0.03)
VARIANCE = 0.999
"""Share of the variance of what synergies leave that its principal components keep."""


@dataclass(frozen=True)
class JoinedPredictor:
    """Predicts by synergies, corrected by what they leave of people's reaches thereabouts.

    As every roll-out starts where it is told, nothing is left there to be corrected.

    Parameters
    ----------
    synergy : SynergyPredictor
    fit : Regression
        Of coefficients, shape (m,), on the target.
    components : array, shape (m, PHASES * n)
        Principal components of what the roll-outs leave, rad a unit.
    """

    synergy: SynergyPredictor
    fit: Regression
    components: FloatArray

    name: ClassVar[str] = "joined"

    @property
    def chain(self) -> SerialChain:
        """What moves."""
        return self.synergy.chain

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict M reaches; see `armsyn.planning.prediction.Predictor`."""
        rolled = self.synergy.predict(starts, targets)
        goals = np.asarray(targets, dtype=np.float64)
        left = np.einsum("mi,ij->mj", self.fit(goals), self.components)
        free = rolled.angles + left.reshape(rolled.angles.shape)
        free[:, 0] = starts
        angles, errors = ended_at(self.chain, free, goals)
        return Predicted(angles, rolled.durations, rolled.outside, errors)


def learn_joined(
    examples: Examples, *, model: str = "D", ridge: float | None = None
) -> JoinedPredictor:
    """Learn synergies over the workspace, and what they leave.

    Parameters
    ----------
    examples : Examples
    model, ridge
        As `armsyn.planning.synergy_atlas.learn_synergies`.

    Returns
    -------
    JoinedPredictor

    Raises
    ------
    CaptureError, InputError
        As there.
    """
    synergy = learn_synergies(examples, model=model, ridge=ridge)
    rolled = synergy.predict(examples.starts, examples.targets).angles
    left = (examples.angles - rolled).reshape(examples.size, PHASES * examples.chain.dof)
    _, sizes, directions = np.linalg.svd(left, full_matrices=False)
    shares = np.cumsum(sizes**2) / max(float(np.sum(sizes**2)), np.finfo(float).tiny)
    components = directions[: int(np.searchsorted(shares, VARIANCE)) + 1]
    return JoinedPredictor(
        synergy, regression(examples.targets, left @ components.T, KERNEL), components
    )
