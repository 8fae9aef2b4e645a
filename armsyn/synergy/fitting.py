"""One reach, one optimiser, one model: the problem, and what a learner makes of it.

Every reach draws its random numbers from a generator of its own, seeded with its name, and every
roll-out stands alone: so the result is the same for any number of workers and any company.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.ik import optimiser_settings
from armsyn.kernels import rollout as kernels
from armsyn.kernels.residuals import residual_lanes
from armsyn.kernels.rollout import Timing
from armsyn.synergy.annealing import anneal
from armsyn.synergy.evaluation import Candidates, Evaluator, Problem
from armsyn.synergy.evolution import adapt_covariance, evolve
from armsyn.synergy.least_squares import multistart
from armsyn.synergy.models import parameter_bounds, parameter_ties, synergies
from armsyn.synergy.options import LearningOptions
from armsyn.synergy.training import Training, as_captures

FloatArray = NDArray[np.float64]
Learner = Callable[[Evaluator, Generator, LearningOptions], Candidates]

_LEARNERS: dict[str, Learner] = {
    "least-squares": lambda evaluator, generator, _: multistart(evaluator, generator),
    "annealing": lambda evaluator, generator, o: anneal(evaluator, generator, o.annealing),
    "cma": lambda evaluator, generator, _: adapt_covariance(evaluator, generator),
    "evolution": lambda evaluator, generator, _: evolve(evaluator, generator),
}


@dataclass(frozen=True)
class Fitted:
    """What was learned for one reach.

    Parameters
    ----------
    parameters : array, shape (parameters,)
        The best vector ever met.
    score : float
        Its distance, m: a training error.
    candidates : Candidates
        What else the learner ended with.
    evaluations : int
        Roll-outs made.
    history : array, shape (falls, 2)
        Roll-outs made and the best distance, m, whenever it fell.
    """

    parameters: FloatArray
    score: float
    candidates: Candidates
    evaluations: int
    history: FloatArray

    def best_after(self, evaluations: int) -> float:
        """Return the best distance after so many roll-outs, m; infinite before the first."""
        made = self.history[:, 0] <= evaluations
        return float(self.history[made, 1].min(initial=np.inf))


def reach_problem(
    arm: ArmDescription, training: Training, ik: str, model: str, options: LearningOptions
) -> Problem:
    """State the learning of one reach with one optimiser and model.

    Parameters
    ----------
    arm : ArmDescription
    training : Training
    ik, model : str
    options : LearningOptions

    Returns
    -------
    Problem
    """
    captures = as_captures(arm, [training])
    settings, chain = optimiser_settings(ik), arm.chain
    timing = Timing(options.rate_of(ik), 1.0 / options.rate_hz, 0.0, np.inf)

    def distances(parameters: FloatArray) -> FloatArray:
        lanes = synergies(model, chain.dof, parameters)
        result = np.empty(len(parameters))
        which = np.zeros(len(parameters), dtype=np.int64)
        kernels.distance_lanes(chain.arrays, settings, lanes, timing, captures, which, result)
        return result

    def residuals(parameters: FloatArray) -> FloatArray:
        lanes = synergies(model, chain.dof, parameters)
        result = np.empty((len(parameters), *training.landmarks.shape))
        residual_lanes(chain.arrays, settings, lanes, timing, captures, 0, result)
        return result.reshape(len(parameters), -1, 3)

    lower, upper = parameter_bounds(model, chain.dof, stable=options.stable)
    return Problem(distances, residuals, lower, upper, parameter_ties(model, chain.dof))


def fit_reach(
    arm: ArmDescription, training: Training, ik: str, model: str, options: LearningOptions
) -> Fitted:
    """Learn one reach with one optimiser and model.

    Parameters
    ----------
    arm : ArmDescription
    training : Training
    ik, model : str
    options : LearningOptions

    Returns
    -------
    Fitted
    """
    evaluator = Evaluator(reach_problem(arm, training, ik, model, options), options.evaluations)
    generator = np.random.default_rng([options.seed, *training.capture.name.encode()])
    candidates = _LEARNERS[options.learner](evaluator, generator, options)
    return Fitted(
        evaluator.best,
        evaluator.best_score,
        candidates,
        evaluator.spent,
        np.array(evaluator.history),
    )
