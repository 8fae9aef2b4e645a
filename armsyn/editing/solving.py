"""The loop both solvers share: step, test, step, on the same kinematics and tolerance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.bounded import Bounds, bounded_step
from armsyn.editing.priorities import Damping, Level, priority_step
from armsyn.editing.problem import Problem
from armsyn.errors import InputError

FloatArray = NDArray[np.float64]
DampingUnit = Literal["relative", "metre", "centimetre"]
_STALLED = 1e-9
"""A step of the unknowns (standard deviations, rad) below which nothing moves any more."""

_HALVINGS = 6
_NEXT = 0.01
_NEGLIGIBLE = 1e-3
"""Of the tolerance: goals that come nearer by less in an iteration have come as near as they do."""
_POSITIVE = ("tolerance", "longest", "coefficient_bound", "allowed_miss", "metres_per_radian")


@dataclass(frozen=True)
class SolverOptions:
    """What a solver may do.

    Parameters
    ----------
    iterations : int
        At most.
    damping : float
        xi.
    damping_unit : {"relative", "metre", "centimetre"}
        A share of each level's largest singular value, or an amount in metres or centimetres a
        unit of the unknowns. The paper's 0.8 and 10 converge only as centimetres.
    whiten : bool
        Whether components count in standard deviations of the examples.
    tolerance : float
        What each goal may miss, m (rad for orientations). Solvers go on until no coordinate
        misses more than half of it, which together is less.
    longest : float
        What is asked of a goal in one iteration, m or rad: Jacobians hold nearby only.
    toward : {"", "clip", "mean"}
        What the freedom that is left is used for: nothing, or to go back to the clip's or to the
        mean motion's coefficients (z in the paper's Eq. 10); by key-frames, not by paths.
    toward_coefficients : tuple of float
        Whitened coefficients to go to instead: a style.
    pull : float
        Share of the way there an iteration, in (0, 1].
    coefficient_bound : float
        Standard deviations of the examples beyond which an edit is refused unless forced.
    allowed_miss : float
        What constraints of the first level may miss, m (rad for orientations), before an edit is
        refused unless forced.
    metres_per_radian : float
        What a radian of an orientation counts against a metre of a position on its level.

    Raises
    ------
    InputError
        When a value is out of range.
    """

    iterations: int = 100
    damping: float = 0.01
    damping_unit: DampingUnit = "relative"
    whiten: bool = True
    tolerance: float = 1e-6
    longest: float = 0.1
    toward: Literal["", "clip", "mean"] = ""
    toward_coefficients: tuple[float, ...] = ()
    pull: float = 1.0
    coefficient_bound: float = 6.0
    allowed_miss: float = 1e-3
    metres_per_radian: float = 0.5

    def __post_init__(self) -> None:
        if self.iterations < 1:
            raise InputError(f"{self.iterations} iterations: give at least one")
        if not (np.isfinite(self.damping) and self.damping >= 0.0):
            raise InputError(f"damping {self.damping:g} is negative or not finite")
        if self.damping_unit not in get_args(DampingUnit):
            raise InputError(
                f"damping unit '{self.damping_unit}': {', '.join(get_args(DampingUnit))}"
            )
        for name in _POSITIVE:
            if not getattr(self, name) > 0.0:
                raise InputError(f"{name} {getattr(self, name):g} is not positive")
        if not 0.0 < self.pull <= 1.0:
            raise InputError(f"pull {self.pull:g} is not in (0, 1]")
        if not np.isfinite(self.toward_coefficients).all():
            raise InputError("the coefficients to go to are finite numbers")

    @classmethod
    def paper(cls, xi: float = 10.0, iterations: int = 100) -> Self:
        """Return the paper's settings: xi in centimetres, components unwhitened."""
        return cls(iterations, xi, "centimetre", whiten=False)

    @property
    def as_damping(self) -> Damping:
        """The damping as a step takes it."""
        share = 0.01 if self.damping_unit == "centimetre" else 1.0
        return Damping(self.damping * share, self.damping_unit == "relative")


@dataclass(frozen=True, eq=False)
class Solution:
    """Where a solver ended.

    Attributes
    ----------
    x : array, shape (q,)
        The unknowns.
    iterations : int
        Steps taken.
    success : bool
        Whether every goal of every level is met to the tolerance.
    """

    x: FloatArray
    iterations: int
    success: bool


def solve(
    problem: Problem,
    start: FloatArray,
    options: SolverOptions,
    rest: FloatArray | None = None,
    bounds: Bounds | None = None,
    *,
    settle: bool = True,
) -> Solution:
    """Step until every goal is met, nothing moves any more, or the iterations are used up.

    Parameters
    ----------
    problem : Problem
    start : array, shape (q,)
    options : SolverOptions
    rest : array, shape (q,), optional
        Where the freedom that is left goes.
    bounds : Bounds, optional
        Never left; `start` is within.
    settle : bool
        Whether to go on with `rest` once the goals are met, until it moves nothing any more.

    Returns
    -------
    Solution
    """
    x, damping = np.array(start), options.as_damping
    levels = problem.levels(x)
    enough = 0.5 * options.tolerance * min(1.0, problem.metres_per_radian)
    negligible = _NEGLIGIBLE * options.tolerance * _NEXT ** (len(levels) - 1)

    def step_from(x: FloatArray, levels: list[Level], z: FloatArray | None = None) -> FloatArray:
        wishes = [_clamped(level, options.longest) for level in levels]
        if bounds is None:
            return priority_step(wishes, damping, z)[0]
        return bounded_step(wishes, damping, bounds, x, z)

    for iteration in range(options.iterations + 1):
        met = all(np.abs(error).max() <= enough for _, error in levels)
        if iteration == options.iterations or (met and not (settle and rest is not None)):
            break
        step = step_from(x, levels, None if rest is None else options.pull * (rest - x))
        if np.abs(step).max() <= (options.tolerance if met else _STALLED):
            break
        ahead = _better(problem, x, step, levels, step_from)
        ahead = ahead or (x + step, problem.levels(x + step))
        if rest is None and _merit(levels) - _merit(ahead[1]) < negligible:
            break
        x, levels = ahead
    return Solution(x, iteration, met)


def _better(
    problem: Problem,
    x: FloatArray,
    step: FloatArray,
    levels: list[Level],
    step_from: Callable[[FloatArray, list[Level]], FloatArray],
) -> tuple[FloatArray, list[Level]] | None:
    """Go as far along a step, halved at need, as makes the goals' errors smaller.

    Far from what can be reached full steps would swing about it. What a step for the last level
    bends the ones above by is of second order: they are led back before it is judged.
    """
    before = _merit(levels)
    for halvings in range(_HALVINGS + 1):
        there = x + step * 0.5**halvings
        found = problem.levels(there)
        if _merit(found) < before:
            return there, found
        if len(found) > 1:
            last = found[-1]
            there = there + step_from(there, [*found[:-1], Level(last.J, 0.0 * last.error)])
            found = problem.levels(there)
            if _merit(found) < before:
                return there, found
    return None


def _merit(levels: list[Level]) -> float:
    """Sum of the levels' errors, each counting `_NEXT` times the one above."""
    return sum(
        _NEXT**place * float(np.linalg.norm(error)) for place, (_, error) in enumerate(levels)
    )


def _clamped(level: Level, longest: float) -> Level:
    largest = float(np.abs(level.error).max())
    return level if largest <= longest else Level(level.J, level.error * (longest / largest))
