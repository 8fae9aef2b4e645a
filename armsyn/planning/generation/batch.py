"""A batch of reaches from targets to arrays: predicted, varied, paced and judged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.kernels import reaches
from armsyn.planning.checking import TOLERANCE_M
from armsyn.planning.generation.judging import judge, reason
from armsyn.planning.generation.pacing import Paced, pace
from armsyn.planning.generation.targets import Targets
from armsyn.planning.generation.variability import Variability
from armsyn.planning.prediction import Predictor

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

KINDS = {
    reaches.RANGE: "range",
    reaches.SPEED: "speed",
    reaches.ACCELERATION: "acceleration",
    reaches.JERK: "jerk",
    reaches.CONTACT: "collision",
}


@dataclass(frozen=True)
class Recipe:
    """All that a reach depends on, but its index.

    Parameters
    ----------
    arm : ArmDescription
    predictor : Predictor
        On that arm's chain.
    targets : Targets
    start : array, shape (n,)
        Where reaches start, unless the targets say, rad or m.
    rate_hz : float
    repeats : int
        Reaches to every target, one after another.
    seed : int
    variability : Variability or None
        How repeats differ; None for repeats that do not.
    """

    arm: ArmDescription
    predictor: Predictor
    targets: Targets
    start: FloatArray
    rate_hz: float
    repeats: int = 1
    seed: int = 0
    variability: Variability | None = None

    @property
    def size(self) -> int:
        """How many reaches there are."""
        return self.targets.size * self.repeats


@dataclass(frozen=True)
class Refusal:
    """A reach that is not made.

    Parameters
    ----------
    index : int
    target : 3-tuple of float
        m.
    kind : str
        ``unreachable``, or one of `KINDS`.
    reason : str
        One line.
    """

    index: int
    target: tuple[float, float, float]
    kind: str
    reason: str


@dataclass(frozen=True)
class Batch:
    """Reaches that may be driven, and those that are refused.

    Parameters
    ----------
    index : array of int, shape (M,)
        Of the reaches that are made.
    targets, hands : array, shape (M, 3)
        Where each was to end and where it does, m.
    durations : array, shape (M,)
        s that a person would take.
    outside : array, shape (M,)
        m from the captured workspace; 0 inside, NaN when nothing was captured.
    paced : Paced
        The reaches.
    refused : tuple of Refusal
    """

    index: IntArray
    targets: FloatArray
    hands: FloatArray
    durations: FloatArray
    outside: FloatArray
    paced: Paced
    refused: tuple[Refusal, ...]


def make_batch(recipe: Recipe, first: int, last: int) -> Batch:
    """Make the reaches `first` to `last`, which is not included.

    Parameters
    ----------
    recipe : Recipe
    first, last : int

    Returns
    -------
    Batch
    """
    index = np.arange(first, last)
    targets, starts = _asked(recipe, first, last)
    predicted = recipe.predictor.predict(starts, targets)
    if recipe.variability is not None:
        predicted = recipe.variability.vary(
            recipe.arm.chain, predicted, targets, recipe.seed, first
        )
    usable = np.isfinite(predicted.angles).all(axis=(1, 2)) & np.isfinite(predicted.durations)
    angles, durations = predicted.angles, predicted.durations
    if not usable.all():  # these rest, until they are refused
        angles = np.where(usable[:, None, None], angles, starts[:, None])
        durations = np.where(usable, durations, 1.0)
    paced = pace(recipe.arm, angles, durations, recipe.rate_hz)
    hands = recipe.arm.chain.positions(angles[:, -1])[:, -1]
    away = np.linalg.norm(hands - targets, axis=1)
    verdicts = judge(recipe.arm, paced)
    arrived = usable & (away <= TOLERANCE_M)
    good = arrived & (paced.lengths > 0) & (verdicts.kinds == reaches.ALLOWED)

    def refusal(row: int) -> Refusal:
        x, y, z = targets[row].tolist()
        if not usable[row]:
            kind, said = "unreachable", "the prediction is not finite"
        elif not arrived[row]:
            kind = "unreachable"
            said = f"the hand would end {away[row] * 100:.2f} cm from the target"
        elif not paced.lengths[row]:
            kind, said = "speed", "however slow, a joint's speed or acceleration does not hold"
        else:
            kind = KINDS[int(verdicts.kinds[row])]
            said = reason(recipe.arm, paced, verdicts, row)
        return Refusal(int(index[row]), (x, y, z), kind, said)

    return Batch(
        index[good],
        targets[good],
        hands[good],
        predicted.durations[good],
        predicted.outside[good],
        _kept(paced, good),
        tuple(refusal(row) for row in np.flatnonzero(~good).tolist()),
    )


def _asked(recipe: Recipe, first: int, last: int) -> tuple[FloatArray, FloatArray]:
    """Targets and starts of the reaches, a target's repeats one after another."""
    of = np.arange(first, last) // recipe.repeats
    targets, starts = recipe.targets.some(int(of[0]), int(of[-1]) + 1)
    rows = of - of[0]
    if starts is None:
        return targets[rows], np.tile(recipe.start, (len(rows), 1))
    return targets[rows], starts[rows]


def _kept(paced: Paced, good: NDArray[np.bool_]) -> Paced:
    """Some of the reaches, one after another."""
    if good.all():
        return paced
    lengths = paced.lengths
    first = np.concatenate([[0], np.cumsum(lengths[good])])
    return Paced(paced.paths[np.repeat(good, lengths)], first, paced.scales[good], paced.rate_hz)
