"""What an experiment may be asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from armsyn.experiments.selections import Selection
from armsyn.synergy.annealing import Schedule
from armsyn.synergy.options import LearningOptions

Budget = Literal["small", "full"]
SCHEDULES: dict[Budget, Schedule] = {
    "small": Schedule(population=12, generations=40, patience=20, max_generations=60),
    "full": Schedule(),
}
"""small shows that everything works; full is what the figures are made with."""


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

    def options(self, selection: Selection, *, stable: bool = False) -> LearningOptions:
        """Return how synergies of a selection are learned.

        Parameters
        ----------
        selection : Selection
        stable : bool
            Positive gains, as arms that move get them, instead of the paper's bounds.

        Returns
        -------
        LearningOptions
            With lambda 6, 60 and 3 per second for SVD, J^T and NJ^T.
        """
        return LearningOptions(
            stable=stable,
            rate_hz=selection.rate_hz,
            seed=self.seed,
            workers=self.workers,
            schedule=SCHEDULES[self.budget],
        )
