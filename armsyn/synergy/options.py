"""What learning is asked for."""

from __future__ import annotations

from dataclasses import dataclass, field

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
    """

    iks: tuple[str, ...] = ("svd",)
    models: tuple[str, ...] = ("C",)
    stable: bool = True
    rate_hz: float = 120.0
    lambda_: float | None = None
    seed: int = 0
    workers: int | None = None
    schedule: Schedule = field(default_factory=Schedule)

    def rate_of(self, ik: str) -> float:
        """Lambda of an optimiser, 1/s."""
        return self.lambda_ or (ARM_RATES if self.stable else RATES)[ik]
