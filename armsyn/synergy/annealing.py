"""The paper's meta-heuristic: simulated annealing of a population (3.3, algorithm 1).

Every member of a random population evolves by small random variations of its parameters; a
variation that reduces the distance to the captured motion is kept, otherwise the previous values
are restored, until the average score of the population is stable.

Two readings, stated because the paper leaves them open. Line 12 as printed keeps a vector when
``previousScore - score < 0``, that is when it got worse; the text ("if the algorithm reduces
this distance, the vector of parameters is kept") is what is meant and what is done here. And
"simulated annealing" is taken at its word: steps shrink geometrically from a fifth of each
parameter's range to 1/200 of it, and a worse vector is kept with the probability
exp(-increase / temperature) of Metropolis, the temperature falling with the square of the step.

Every motion draws its random numbers from a generator of its own, seeded with its name, every
roll-out stands alone, and a population that is stable rests while others go on: so the result is
the same for any number of workers and any company of motions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import InputError

FloatArray = NDArray[np.float64]
Scorer = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class Schedule:
    """How a population anneals.

    Parameters
    ----------
    population : int
        Members for each motion.
    generations : int
        Over which the steps shrink from `first_step` to `last_step`.
    patience : int
        Stable: the average score fell by less than a thousandth over as many generations.
    max_generations : int
        End also when never stable.
    first_step, last_step : float
        Standard deviation of a variation, as a share of the parameter's range.
    first_temperature : float
        As a share of the population's first average score.
    """

    population: int = 24
    generations: int = 400
    patience: int = 100
    max_generations: int = 1200
    first_step: float = 0.2
    last_step: float = 0.005
    first_temperature: float = 0.02

    def __post_init__(self) -> None:
        counts = (self.population, self.generations, self.patience, self.max_generations)
        if min(counts) < 1:
            raise InputError("population and generations of a schedule must be at least 1")

    def step(self, generation: int) -> float:
        """Share of the parameters' ranges that a variation has in this generation."""
        progress = min(generation / self.generations, 1.0)
        return float(self.first_step * (self.last_step / self.first_step) ** progress)

    def temperature(self, generation: int) -> float:
        """Share of the first average score that Metropolis' temperature has; 0 at the end."""
        if generation >= self.generations:
            return 0.0
        return float(self.first_temperature * (self.step(generation) / self.first_step) ** 2)


@dataclass(frozen=True)
class Annealed:
    """What annealing found.

    Parameters
    ----------
    parameters : array, shape (motions, parameters)
        The best vector ever met, for each motion.
    scores : array, shape (motions,)
        Its score.
    members : array, shape (motions, population, parameters)
        The whole population at the end.
    member_scores : array, shape (motions, population)
        Its scores.
    evaluations : int
        Roll-outs made.
    history : array, shape (generations + 1, motions)
        Average score of the population.
    stable : bool
        Whether every motion's average score became stable.
    interrupted : bool
        Whether Ctrl-C ended it.
    """

    parameters: FloatArray
    scores: FloatArray
    members: FloatArray
    member_scores: FloatArray
    evaluations: int
    history: FloatArray
    stable: bool
    interrupted: bool


def anneal(
    score: Scorer,
    names: Sequence[str],
    lower: FloatArray,
    upper: FloatArray,
    *,
    schedule: Schedule | None = None,
    seed: int = 0,
    on_generation: Callable[[int, float], None] | None = None,
) -> Annealed:
    """Anneal one population a motion, all of them side by side.

    Parameters
    ----------
    score : callable
        From parameters, shape (motions, population, parameters), to scores, shape (motions,
        population).
    names : sequence of str
        One a motion; with `seed` they decide its random numbers.
    lower, upper : array, shape (parameters,)
        Bounds.
    schedule : Schedule, optional
    seed : int
    on_generation : callable, optional
        Called after each generation with its number and the average best score. When it raises
        ``KeyboardInterrupt`` (as Ctrl-C does anywhere in here), the best so far is returned.

    Returns
    -------
    Annealed
    """
    plan = schedule or Schedule()
    generators = [np.random.default_rng([seed, *name.encode()]) for name in names]
    width = upper - lower
    shape = (plan.population, lower.size)
    members = lower + width * np.stack([g.random(shape) for g in generators])
    scores = score(members)
    history = [scores.mean(axis=1)]
    best, best_scores = _better(members, scores, members[:, 0], np.full(len(names), np.inf))
    restless = np.ones(len(names), dtype=bool)
    interrupted = False
    try:
        for generation in range(plan.max_generations):
            variation = np.stack([g.standard_normal(shape) for g in generators])
            chance = np.stack([g.random(plan.population) for g in generators])
            trial = np.clip(members + plan.step(generation) * width * variation, lower, upper)
            trial_scores = score(trial)
            temperature = plan.temperature(generation) * history[0][:, None]
            keep = trial_scores < scores + temperature * -np.log(np.maximum(chance, 1e-300))
            keep &= restless[:, None]
            # In one assignment, which Ctrl-C cannot part
            members, scores = (
                np.where(keep[..., None], trial, members),
                np.where(keep, trial_scores, scores),
            )
            best, best_scores = _better(members, scores, best, best_scores)
            history.append(scores.mean(axis=1))
            if on_generation is not None:
                on_generation(generation + 1, float(best_scores.mean()))
            if generation >= plan.generations:
                restless &= ~_are_stable(history, plan.patience)
            if not restless.any():
                break
    except KeyboardInterrupt:
        interrupted = True
    evaluations = scores.size * len(history)
    return Annealed(
        best,
        best_scores,
        members,
        scores,
        evaluations,
        np.array(history),
        stable=not restless.any(),
        interrupted=interrupted,
    )


def _better(
    members: FloatArray, scores: FloatArray, best: FloatArray, best_scores: FloatArray
) -> tuple[FloatArray, FloatArray]:
    rows = np.arange(scores.shape[0])
    leader = scores.argmin(axis=1)
    ahead = scores[rows, leader] < best_scores
    return (
        np.where(ahead[:, None], members[rows, leader], best),
        np.where(ahead, scores[rows, leader], best_scores),
    )


def _are_stable(history: list[FloatArray], patience: int) -> NDArray[np.bool_]:
    if len(history) <= patience:
        return np.zeros(history[-1].shape, dtype=bool)
    return np.asarray(history[-1 - patience] - history[-1] < 1e-3 * history[-1])
