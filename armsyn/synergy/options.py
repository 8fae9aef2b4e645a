"""What learning is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from armsyn.errors import InputError
from armsyn.synergy.annealing import Schedule
from armsyn.synergy.controller import ARM_RATES, RATES

LEARNERS = ("least-squares", "annealing", "cma", "evolution")
BUDGET = 1000
"""Roll-outs a reach: at three times as many, least squares finds nothing better."""


@dataclass(frozen=True)
class LearningOptions:
    """What is learned and how.

    Parameters
    ----------
    iks, models : tuple of str
        Optimisers and synergy models; every pair is learned.
    stable : bool
        Bound gains below (arms that move); else the paper's bounds.
    rate_hz : float
        Frame rate of the roll-outs.
    lambda_ : float or None
        1/s; each optimiser's own when None.
    seed : int
    workers : int or None
        Processes; as many as cores when None and there is work for them. The result does not
        depend on it.
    learner : str
        One of `LEARNERS`.
    budget : int or None
        Roll-outs for each reach, optimiser and model. When None: `BUDGET`, or for annealing what
        its schedule asks for.
    schedule : Schedule
        How annealing anneals; fitted to the budget when None.

    Raises
    ------
    InputError
        A lambda that is no positive rate, an unknown learner or a budget below one.
    """

    iks: tuple[str, ...] = ("svd",)
    models: tuple[str, ...] = ("C",)
    stable: bool = True
    rate_hz: float = 120.0
    lambda_: float | None = None
    seed: int = 0
    workers: int | None = None
    learner: str = LEARNERS[0]
    budget: int | None = None
    schedule: Schedule = field(default_factory=Schedule)

    def __post_init__(self) -> None:
        if self.lambda_ is not None and not 0 < self.lambda_ < math.inf:
            raise InputError(f"lambda must be a positive rate in 1/s, got {self.lambda_:g}")
        if self.learner not in LEARNERS:
            raise InputError(f"no learner {self.learner!r}; known: {', '.join(LEARNERS)}")
        if self.budget is not None and self.budget < 1:
            raise InputError(f"a budget is at least one evaluation, got {self.budget}")

    @property
    def annealing(self) -> Schedule:
        """The schedule of annealing: fitted to the budget where there is one."""
        return self.schedule if self.budget is None else Schedule.within(self.budget)

    @property
    def evaluations(self) -> int:
        """Roll-outs that may be made for each reach, optimiser and model."""
        if self.budget is not None:
            return self.budget
        return self.schedule.evaluations if self.learner == "annealing" else BUDGET

    def rate_of(self, ik: str) -> float:
        """Lambda of an optimiser, 1/s."""
        own = (ARM_RATES if self.stable else RATES)[ik]
        return own if self.lambda_ is None else self.lambda_
