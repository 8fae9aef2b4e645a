"""What learners look at: one reach's distance, counted against a budget.

Every learner sees the same `Evaluator` and nothing else of the problem, so that a table of
learners compares them at the same number of roll-outs, each finite difference counted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import InputError

FloatArray = NDArray[np.float64]
Function = Callable[[FloatArray], FloatArray]


class BudgetSpentError(Exception):
    """A learner asked for more roll-outs than are left."""


@dataclass(frozen=True)
class Candidates:
    """Vectors that a learner ended with: a population, or the ends of its descents.

    Parameters
    ----------
    members : array, shape (members, parameters)
    scores : array, shape (members,)
        Their distances, m.
    """

    members: FloatArray
    scores: FloatArray


@dataclass(frozen=True)
class Problem:
    """One reach to be learned.

    Parameters
    ----------
    distances : callable
        From parameters, shape (lanes, parameters), to the paper's distance, shape (lanes,), m.
    residuals : callable
        From the same to the gaps whose mean norm that is, shape (lanes, points, 3), m.
    lower, upper : array, shape (parameters,)
        Bounds.
    ties : array of int, shape (parameters,)
        A vector of a simpler model, indexed with it, is one of this problem; the simplest
        problems have only themselves, 0, 1, 2 ...
    """

    distances: Function
    residuals: Function
    lower: FloatArray
    upper: FloatArray
    ties: NDArray[np.int64]

    def at(self, shares: FloatArray) -> FloatArray:
        """Return the parameters at shares of their ranges, shape (..., parameters), in bounds."""
        width = self.upper - self.lower
        return np.clip(self.lower + width * shares, self.lower, self.upper)

    def shares(self, parameters: FloatArray) -> FloatArray:
        """Return which shares of their ranges parameters are, shape (..., parameters)."""
        return np.asarray((parameters - self.lower) / (self.upper - self.lower))


class Evaluator:
    """Evaluates a problem, counts, and remembers the best vector ever met.

    Parameters
    ----------
    problem : Problem
    budget : int
        Roll-outs that may be made.

    Raises
    ------
    InputError
        A budget below one.

    Attributes
    ----------
    spent : int
        Roll-outs made.
    best : array, shape (parameters,)
    best_score : float
        m; infinite before anything was evaluated.
    history : list of (int, float)
        Roll-outs made and the best score, whenever it fell.
    """

    def __init__(self, problem: Problem, budget: int) -> None:
        if budget < 1:
            raise InputError(f"a budget is at least one evaluation, got {budget}")
        self.problem = problem
        self.budget = budget
        self.spent = 0
        self.best = problem.lower
        self.best_score = np.inf
        self.history: list[tuple[int, float]] = []

    @property
    def left(self) -> int:
        """Roll-outs that may still be made."""
        return self.budget - self.spent

    def scores(self, parameters: FloatArray) -> FloatArray:
        """Return distances of parameters, shape (lanes, parameters): shape (lanes,), m.

        Raises
        ------
        BudgetSpentError
            When fewer roll-outs are left than lanes are asked for.
        """
        self._spend(len(parameters))
        scores = self.problem.distances(parameters)
        self._remember(parameters, scores)
        return scores

    def residuals(self, parameters: FloatArray) -> FloatArray:
        """Return gaps of parameters, shape (lanes, parameters): shape (lanes, points, 3), m.

        Raises
        ------
        BudgetSpentError
            When fewer roll-outs are left than lanes are asked for.
        """
        self._spend(len(parameters))
        gaps = self.problem.residuals(parameters)
        self._remember(parameters, np.linalg.norm(gaps, axis=2).mean(axis=1))
        return gaps

    def _spend(self, lanes: int) -> None:
        if lanes > self.left:
            raise BudgetSpentError
        self.spent += lanes

    def _remember(self, parameters: FloatArray, scores: FloatArray) -> None:
        leader = int(scores.argmin())
        if scores[leader] < self.best_score:
            self.best, self.best_score = parameters[leader].copy(), float(scores[leader])
            self.history.append((self.spent, self.best_score))
