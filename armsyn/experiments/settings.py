"""What an experiment may be asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from armsyn.experiments.selections import Prepared
from armsyn.synergy.models import parameter_names
from armsyn.synergy.options import LearningOptions

Budget = Literal["small", "full"]
ROLL_OUTS: dict[Budget, int] = {"small": 20, "full": 500}
"""For each parameter of a model, for each reach and optimiser: small shows that everything works,
full is what the figures are made with."""


@dataclass(frozen=True)
class Settings:
    """How much an experiment may learn, and with which random numbers.

    Parameters
    ----------
    budget : {"small", "full"}
    seed : int
    workers : int or None
        All cores when None; results do not depend on it.
    """

    budget: Budget = "full"
    seed: int = 0
    workers: int | None = None

    def options(
        self, prepared: Prepared, model: str = "A", *, stable: bool = False
    ) -> LearningOptions:
        """Return how synergies of a selection are learned.

        Parameters
        ----------
        prepared : Prepared
        model : str
            Whose number of parameters the budget goes by.
        stable : bool
            Positive gains, as arms that move get them, instead of the paper's bounds.

        Returns
        -------
        LearningOptions
            With lambda 6, 60 and 3 per second for SVD, J^T and NJ^T (10 for SVD when stable).
        """
        parameters = len(parameter_names(model, prepared.arm.joint_names))
        return LearningOptions(
            stable=stable,
            rate_hz=prepared.selection.rate_hz,
            seed=self.seed,
            workers=self.workers,
            budget=ROLL_OUTS[self.budget] * parameters,
        )
