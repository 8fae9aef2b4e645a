"""A batch leaves nothing behind but what it returns."""

from __future__ import annotations

import gc
import weakref
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import load_arm
from armsyn.planning.generation.batch import Recipe, make_batch
from armsyn.planning.generation.targets import ListedTargets
from armsyn.planning.minimum_jerk import MinimumJerkPredictor
from armsyn.planning.prediction import Predicted

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Watched(MinimumJerkPredictor):
    """Predicts, and keeps an eye on the motions."""

    seen: list[weakref.ref[FloatArray]] = field(default_factory=list)

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        predicted = super().predict(starts, targets)
        self.seen.append(weakref.ref(predicted.angles))
        return predicted


def test_motions_of_refused_reaches_are_not_kept_until_garbage_is_collected() -> None:
    arm = load_arm("human7", calibrated=False)
    chain, rng = arm.chain, np.random.default_rng(5)
    goals = chain.positions(rng.uniform(chain.lower, chain.upper, (20, chain.dof)))[:, -1]
    goals[3] = 9.0
    starts = rng.uniform(chain.lower, chain.upper, (20, chain.dof))
    starts[5, 0] = chain.upper[0] + 0.5
    recipe = Recipe(arm, Watched(chain), ListedTargets(goals, starts), arm.rest, 200.0)
    make_batch(recipe, 0, 20)
    gc.collect()
    gc.disable()
    try:
        refused = make_batch(recipe, 0, 20).refused
        kinds = {refusal.kind for refusal in refused}
        assert {"unreachable", "limit"} < kinds
        assert recipe.predictor.seen[-1]() is None  # type: ignore[attr-defined]
    finally:
        gc.enable()
