"""Least squares for a mean of distances: reweighted, bounded, from many starts.

The paper's distance is a mean of norms, sum |v_i| over the gaps v_i of every frame and landmark,
and least squares minimises squares. With weights 1 / |v_i| held still the sum of w_i |v_i|^2 has
the same value and the same slope and lies above it, so a descent of one is a descent of the other
(iteratively reweighted least squares, Weiszfeld 1937): a few trust-region steps
(`scipy.optimize.least_squares`, Branch, Coleman and Li 1999, for the bounds), new weights, again,
until the distance no longer falls. Derivatives are forward differences, all parameters in one
batch of lanes, each counted as a roll-out.

Thousands of gaps decide a step only by J^T J, J^T r and r^T r, so scipy is given the few residuals
that have the same: [|r|, 0 ...], and a root of J^T J whose first row is r^T J / |r|. The steps are
the same, without a decomposition of thousands of rows for each.

A descent finds the nearest valley. The first start is the best of a Latin hypercube, the next
ones are its followers; then come, in turn, starts from anywhere and jumps from the best so far.
A model with a simpler one inside (S_D with one sigmoid for all is S_C) descends in the simpler
one first and is freed where that ends: with twice the parameters there are many more valleys.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import qmc

from armsyn.synergy.evaluation import BudgetSpentError, Candidates, Evaluator

FloatArray = NDArray[np.float64]

DIFFERENCE = 1e-4
"""Step of the finite differences, as a share of a parameter's range."""
INSIDE = 1e-6
"""How far inside its bounds a descent starts, as a share of the range: it needs room."""
LEAST_GAP_M = 1e-5
"""A smaller gap weighs no more, else one that vanishes would fix the posture there."""
STEPS = 5
"""Trust-region steps with the same weights."""
ROUNDS = 30
FALL = 1e-3
"""A round that lowers the distance by a smaller share is the last of its descent."""
SCREENED = 4
"""Starts looked at for each parameter before the first descent; never more than a third of the
budget."""
JUMP = 0.1
"""Standard deviation of a jump from the best, as a share of a parameter's range; every other
jump goes anywhere."""


def multistart(evaluator: Evaluator, generator: Generator) -> Candidates:
    """Descend from one start after the other until the budget is spent.

    Parameters
    ----------
    evaluator : Evaluator
    generator : numpy.random.Generator

    Returns
    -------
    Candidates
        Where the descents ended.
    """
    ends: list[FloatArray] = []
    scores: list[float] = []
    try:
        for shares, ties in _starts(evaluator, generator):
            end, score = _descend(evaluator, shares, ties)
            ends.append(end)
            scores.append(score)
    except BudgetSpentError:
        ends.append(evaluator.best)
        scores.append(evaluator.best_score)
    return Candidates(np.array(ends), np.array(scores))


def _starts(
    evaluator: Evaluator, generator: Generator
) -> Iterator[tuple[FloatArray, NDArray[np.int64]]]:
    """Yield shares of the parameters' ranges to start from, and which of them are tied."""
    problem = evaluator.problem
    free, simple = np.arange(problem.lower.size), int(problem.ties.max()) + 1
    screened = max(1, min(SCREENED * simple, evaluator.left // 3))
    starts = qmc.LatinHypercube(simple, rng=generator).random(screened)
    scores = evaluator.scores(problem.at(starts[:, problem.ties]))
    ranked = iter(starts[np.argsort(scores, kind="stable")])
    while True:
        start = next(ranked, None)
        if start is None:
            yield problem.shares(evaluator.best) + JUMP * generator.standard_normal(free.size), free
            start = generator.random(simple)
        yield start, problem.ties


def _descend(
    evaluator: Evaluator, shares: FloatArray, ties: NDArray[np.int64]
) -> tuple[FloatArray, float]:
    """Descend, tied first and then free; return where it ended and the distance there, m."""
    shares, score = _descend_tied(evaluator, shares, ties)
    free = np.arange(ties.size)
    if not np.array_equal(ties, free):
        shares, score = _descend_tied(evaluator, shares[ties], free)
    return evaluator.problem.at(shares), score


def _descend_tied(
    evaluator: Evaluator, shares: FloatArray, ties: NDArray[np.int64]
) -> tuple[FloatArray, float]:
    score = np.inf
    for _ in range(ROUNDS):
        shares = np.clip(shares, INSIDE, 1.0 - INSIDE)
        weighted = _Weighted(evaluator, shares, ties)
        if score - weighted.score < FALL * weighted.score:
            break
        score = weighted.score
        shares = least_squares(
            weighted.residuals, shares, weighted.jacobian, bounds=(0.0, 1.0), max_nfev=STEPS
        ).x
    return shares, weighted.score


class _Weighted:
    """Residuals with weights held still, as functions of shares of the parameters' ranges."""

    def __init__(self, evaluator: Evaluator, shares: FloatArray, ties: NDArray[np.int64]) -> None:
        self._evaluator, self._ties, self._at = evaluator, ties, shares
        self._gaps: FloatArray = evaluator.residuals(self._parameters(shares[None]))[0]
        norms = np.linalg.norm(self._gaps, axis=1)
        self.score = float(norms.mean())
        self._roots: FloatArray = 1.0 / np.sqrt(np.maximum(norms, LEAST_GAP_M))[:, None]

    def _parameters(self, shares: FloatArray) -> FloatArray:
        return self._evaluator.problem.at(shares[:, self._ties])

    def _gaps_at(self, shares: FloatArray) -> FloatArray:
        if not np.array_equal(shares, self._at):
            self._gaps = self._evaluator.residuals(self._parameters(shares[None]))[0]
            self._at = shares.copy()
        return self._gaps

    def residuals(self, shares: FloatArray) -> FloatArray:
        """Return residuals with the norm of the weighted gaps, shape (parameters + 1,)."""
        squeezed = np.zeros(shares.size + 1)
        squeezed[0] = np.linalg.norm(self._gaps_at(shares) * self._roots)
        return squeezed

    def jacobian(self, shares: FloatArray) -> FloatArray:
        """Return their derivatives, shape (parameters + 1, parameters)."""
        gaps = self._gaps_at(shares)
        steps = np.where(shares + DIFFERENCE > 1.0, -DIFFERENCE, DIFFERENCE)
        moved = self._evaluator.residuals(self._parameters(shares + np.diag(steps)))
        slopes = (moved - gaps) * self._roots / steps[:, None, None]
        J = slopes.reshape(steps.size, -1)
        r = (gaps * self._roots).reshape(-1)
        along = J @ r / max(np.linalg.norm(r), np.finfo(float).tiny)
        values, vectors = np.linalg.eigh(J @ J.T - np.outer(along, along))
        across = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
        return np.concatenate([along[None], across])
