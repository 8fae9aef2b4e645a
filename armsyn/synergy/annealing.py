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
A population that is stable starts again from new random members while the budget lasts; what the
best of these runs ended with is the result.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armsyn.errors import InputError
from armsyn.synergy.evaluation import Candidates, Evaluator

FloatArray = NDArray[np.float64]


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

    @classmethod
    def within(cls, budget: int) -> Schedule:
        """Return the schedule for so many evaluations of a reach.

        Few members that cool slowly do better than many that cool fast: S_C on 14 captured
        reaches of HuG-MP ends at 2.9 to 3.2 cm with 2 to 4 members and at 5.0 with 8 after 200
        evaluations, at 1.40 with 4 to 8 and 1.66 with 16 after 1,000, at 1.22 with 8 and 1.23
        with 16 after 10,000. Larger first steps and a warmer start help the small budgets.
        """
        population = 4 if budget < 1000 else 8
        generations = max(1, budget // population - 1)
        cooling = max(1, int(0.9 * generations))
        return cls(population, cooling, max(1, cooling // 4), generations, 0.3, 0.01, 0.1)

    @property
    def evaluations(self) -> int:
        """Roll-outs of a run that never becomes stable."""
        return self.population * (1 + self.max_generations)

    def step(self, generation: int) -> float:
        """Share of the parameters' ranges that a variation has in this generation."""
        progress = min(generation / self.generations, 1.0)
        return float(self.first_step * (self.last_step / self.first_step) ** progress)

    def temperature(self, generation: int) -> float:
        """Share of the first average score that Metropolis' temperature has; 0 at the end."""
        if generation >= self.generations:
            return 0.0
        return float(self.first_temperature * (self.step(generation) / self.first_step) ** 2)


def anneal(evaluator: Evaluator, generator: Generator, schedule: Schedule) -> Candidates:
    """Anneal populations until the budget is spent.

    Parameters
    ----------
    evaluator : Evaluator
    generator : numpy.random.Generator
    schedule : Schedule
        A budget that is smaller than its population anneals as large a one as there is.

    Returns
    -------
    Candidates
        The population of the best run.
    """
    best: Candidates | None = None
    while best is None or evaluator.left >= 2 * schedule.population:
        found = anneal_once(evaluator, generator, schedule)
        if best is None or found.scores.min() < best.scores.min():
            best = found
    return best


def anneal_once(evaluator: Evaluator, generator: Generator, schedule: Schedule) -> Candidates:
    """Anneal one population until it is stable or the budget is spent.

    Parameters
    ----------
    evaluator : Evaluator
    generator : numpy.random.Generator
    schedule : Schedule

    Returns
    -------
    Candidates
        The population at its end.
    """
    lower, upper = evaluator.problem.lower, evaluator.problem.upper
    width = upper - lower
    shape = (min(schedule.population, evaluator.left), lower.size)
    members = lower + width * generator.random(shape)
    scores = evaluator.scores(members)
    averages = [float(scores.mean())]
    for generation in range(schedule.max_generations):
        if evaluator.left < shape[0] or _is_stable(averages, generation, schedule):
            break
        variation = schedule.step(generation) * width * generator.standard_normal(shape)
        trial = np.clip(members + variation, lower, upper)
        trial_scores = evaluator.scores(trial)
        temperature = schedule.temperature(generation) * averages[0]
        # -log of a uniform number: how many temperatures worse Metropolis still keeps
        keep = trial_scores < scores + temperature * generator.exponential(size=shape[0])
        members = np.where(keep[:, None], trial, members)
        scores = np.where(keep, trial_scores, scores)
        averages.append(float(scores.mean()))
    return Candidates(members, scores)


def _is_stable(averages: list[float], generation: int, schedule: Schedule) -> bool:
    if generation <= schedule.generations or len(averages) <= schedule.patience:
        return False
    return averages[-1 - schedule.patience] - averages[-1] < 1e-3 * averages[-1]
