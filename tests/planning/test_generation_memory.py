"""A batch leaves nothing behind but what it returns."""

from __future__ import annotations

import ctypes
import gc
import weakref
from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from armsyn.arm import load_arm
from armsyn.planning.generation import memory
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


@dataclass
class Allocator:
    """glibc's mallopt(3), which says 1 for what it takes: before 2.35, no mapping above 32 MB."""

    largest: int
    taken: list[tuple[int, int]] = field(default_factory=list)

    def mallopt(self, parameter: int, value: int) -> int:
        if parameter == -3 and value > self.largest:
            return 0
        self.taken.append((parameter, value))
        return 1


@pytest.mark.parametrize(
    ("largest", "taken"),
    [
        (2**31 - 1, [(-3, 2**30), (-1, 2**30)]),
        (2**25, [(-3, 2**25), (-1, 2**30)]),
        (0, []),  # a threshold for trimming alone would have it map every array
    ],
)
def test_an_allocator_is_told_what_it_takes(
    largest: int, taken: list[tuple[int, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    allocator = Allocator(largest)
    monkeypatch.setattr(ctypes, "CDLL", lambda _name: allocator)
    memory.keep_memory.__wrapped__()
    assert allocator.taken == taken
