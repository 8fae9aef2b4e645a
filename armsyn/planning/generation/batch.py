"""A batch of reaches from targets to arrays: predicted, varied, paced and judged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import CollisionError, LimitError, RefusedMotionError, UnreachableError
from armsyn.planning import finishing
from armsyn.planning.checking import checked_start, not_finite
from armsyn.planning.end_posture import fulfilled
from armsyn.planning.evenness import UnevenError
from armsyn.planning.generation.following import follow
from armsyn.planning.generation.targets import Targets
from armsyn.planning.generation.variability import Variability
from armsyn.planning.motion_planner import THERE_M
from armsyn.planning.pacing import Paced, joined, thinned, thinning
from armsyn.planning.posing import HandOrientation, HandTask
from armsyn.planning.postures import tips
from armsyn.planning.prediction import Predictor

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

KINDS: tuple[tuple[type[RefusedMotionError], str], ...] = (
    (UnreachableError, "unreachable"),
    (LimitError, "limit"),
    (CollisionError, "collision"),
    (UnevenError, "uneven"),
)
"""Why reaches are refused, in words of one table."""


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
        Frames a second; limits hold at `armsyn.planning.pacing.LEAST_HZ` or more.
    repeats : int
        Reaches to every target, one after another.
    seed : int
    variability : Variability or None
        How repeats differ; None for repeats that do not.
    orientation : HandOrientation or None
        How hands are to be turned at the end, unless the targets say.
    """

    arm: ArmDescription
    predictor: Predictor
    targets: Targets
    start: FloatArray
    rate_hz: float
    repeats: int = 1
    seed: int = 0
    variability: Variability | None = None
    orientation: HandOrientation | None = None

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
        Of `KINDS`.
    reason : str
        One line.
    """

    index: int
    target: tuple[float, float, float]
    kind: str
    reason: str


@dataclass(frozen=True)
class Change:
    """A reach that is made otherwise than it was predicted.

    Parameters
    ----------
    index : int
    evened : float
        How much nearer to minimum jerk of every joint it is, 0 to 1.
    swivel_m : float
        By how much the elbow ends elsewhere, m.
    reason : str
        Why it was refused as predicted, in one line.
    """

    index: int
    evened: float
    swivel_m: float
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
    evened, swivels : array, shape (M,)
        See `Change`; 0 where nothing is changed.
    turned : array, shape (M,)
        rad by which the hand ends turned otherwise than asked; NaN where nothing was asked.
    changed : tuple of Change
        Those that are.
    refused : tuple of Refusal
    """

    index: IntArray
    targets: FloatArray
    hands: FloatArray
    durations: FloatArray
    outside: FloatArray
    paced: Paced
    evened: FloatArray
    swivels: FloatArray
    turned: FloatArray
    changed: tuple[Change, ...]
    refused: tuple[Refusal, ...]


def make_batch(recipe: Recipe, first: int, last: int) -> Batch:
    """Make the reaches `first` to `last`, which is not included.

    Each is what `armsyn.planning.motion_planner.MotionPlanner` plans, but for repeats that differ.

    Parameters
    ----------
    recipe : Recipe
    first, last : int
        The one before the other.

    Returns
    -------
    Batch
    """
    arm, index = recipe.arm, np.arange(first, last)
    targets, asked, turned = _asked(recipe, first, last)
    starts, barred = _allowed_starts(arm, asked)
    predicted = recipe.predictor.predict(starts, targets)
    if recipe.variability is not None:
        predicted = recipe.variability.vary(arm.chain, predicted, targets, recipe.seed, first)
    angles, durations = predicted.angles, predicted.durations
    finite = np.isfinite(angles).all(axis=(1, 2)) & np.isfinite(durations)
    there = _there(arm, starts, targets, turned)
    if there.any() or not finite.all():  # these stay where they are
        angles = np.where((finite & ~there)[:, None, None], angles, starts[:, None])
        durations = np.where(finite, durations, 1.0)
    step = thinning(recipe.rate_hz)
    found = follow(arm, angles, durations, targets, step * recipe.rate_hz, turned)
    refused = {**found.refused, **barred, **_not_finite(finite)}
    rows = np.array([row for row in range(last - first) if row not in refused], dtype=np.intp)
    paths = found.paths
    if step > 1:
        paths = [None if path is None else thinned(path, step) for path in paths]
    paced = joined(paths, found.scales, rows, recipe.rate_hz, arm.chain.dof)
    return Batch(
        index[rows],
        targets[rows],
        tips(arm.chain, paced.paths[paced.first[1:] - 1]),
        durations[rows],
        predicted.outside[rows],
        paced,
        found.evened[rows],
        found.swivels[rows],
        _turned(arm, paced.paths[paced.first[1:] - 1], targets, rows, turned),
        tuple(
            Change(first + row, float(found.evened[row]), float(found.swivels[row]), why)
            for row, why in sorted(found.changed.items())
            if row not in refused
        ),
        tuple(_refusal(first + row, targets[row], refused[row]) for row in sorted(refused)),
    )


def warm_up(recipe: Recipe) -> None:
    """Compile what `make_batch` may need, whatever becomes of the first reaches."""
    make_batch(recipe, 0, 1)  # which is predicted, if nothing more
    start = np.clip(recipe.start, recipe.arm.chain.lower, recipe.arm.chain.upper)
    finishing.warm_up(recipe.arm, start, recipe.rate_hz, recipe.orientation)


def _asked(
    recipe: Recipe, first: int, last: int
) -> tuple[FloatArray, FloatArray, list[HandOrientation] | None]:
    """Targets, starts and orientations of the reaches, a target's repeats one after another."""
    of = np.arange(first, last) // recipe.repeats
    asked = recipe.targets.some(int(of[0]), int(of[-1]) + 1)
    rows = of - of[0]
    starts = np.tile(recipe.start, (len(rows), 1)) if asked.starts is None else asked.starts[rows]
    turned = None if recipe.orientation is None else [recipe.orientation] * len(rows)
    if asked.orientations is not None:
        turned = [asked.orientations[row] for row in rows.tolist()]
    return asked.targets[rows], starts, turned


def _there(
    arm: ArmDescription,
    starts: FloatArray,
    targets: FloatArray,
    turned: list[HandOrientation] | None,
) -> NDArray[np.bool_]:
    """Which hands are at their targets already, and turned as asked."""
    there = np.linalg.norm(tips(arm.chain, starts) - targets, axis=1) <= THERE_M
    if turned is not None:
        for row in np.flatnonzero(there).tolist():
            task = HandTask(targets[row], turned[row])
            there[row] = fulfilled(task, *task.errors(arm.chain, starts[row]))
    return np.asarray(there)


def _turned(
    arm: ArmDescription,
    ends: FloatArray,
    targets: FloatArray,
    rows: IntArray,
    turned: list[HandOrientation] | None,
) -> FloatArray:
    """Angles that the hands of some reaches are off what is asked of them, rad, shape (m,)."""
    if turned is None:
        return np.full(len(rows), np.nan)
    tasks = (HandTask(targets[row], turned[row]) for row in rows.tolist())
    return np.array([task.errors(arm.chain, end)[1] for task, end in zip(tasks, ends, strict=True)])


def _allowed_starts(
    arm: ArmDescription, starts: FloatArray
) -> tuple[FloatArray, dict[int, RefusedMotionError]]:
    """Starts within the joints' ranges, and the refusals of those that are not."""
    inside, barred = np.clip(starts, arm.chain.lower, arm.chain.upper), {}
    for row in np.flatnonzero((inside != starts).any(axis=1)).tolist():
        try:
            checked_start(arm, starts[row])
        except LimitError as error:
            barred[row] = error.with_traceback(None)
    return inside, dict(barred)


def _not_finite(finite: NDArray[np.bool_]) -> dict[int, RefusedMotionError]:
    return {row: not_finite() for row in np.flatnonzero(~finite).tolist()}


def _refusal(index: int, target: FloatArray, error: RefusedMotionError) -> Refusal:
    x, y, z = target.tolist()
    kind = next(name for kind, name in KINDS if isinstance(error, kind))
    return Refusal(index, (x, y, z), kind, str(error))
