"""What learning is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from armsyn.errors import InputError
from armsyn.synergy.annealing import Schedule
from armsyn.synergy.controller import ARM_RATES, RATES


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
        Threads; all cores when None. The result does not depend on it.
    schedule : Schedule

    Raises
    ------
    InputError
        A lambda that is no positive rate.
    """

    iks: tuple[str, ...] = ("svd",)
    models: tuple[str, ...] = ("C",)
    stable: bool = True
    rate_hz: float = 120.0
    lambda_: float | None = None
    seed: int = 0
    workers: int | None = None
    schedule: Schedule = field(default_factory=Schedule)

    def __post_init__(self) -> None:
        if self.lambda_ is not None and not 0 < self.lambda_ < math.inf:
            raise InputError(f"lambda must be a positive rate in 1/s, got {self.lambda_:g}")

    def rate_of(self, ik: str) -> float:
        """Lambda of an optimiser, 1/s."""
        own = (ARM_RATES if self.stable else RATES)[ik]
        return own if self.lambda_ is None else self.lambda_
