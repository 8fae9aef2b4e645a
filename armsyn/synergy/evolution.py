"""Population searches of well-kept libraries: CMA-ES (cmaes) and differential evolution (scipy).

Both see a whole generation scored in one batch of lanes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.optimize import Bounds, differential_evolution

from armsyn.errors import InputError
from armsyn.synergy.evaluation import Candidates, Evaluator

FloatArray = NDArray[np.float64]

FIRST_STEP = 0.25
"""First standard deviation of CMA-ES, as a share of the parameters' ranges."""
RECOMBINATION = 0.9


def adapt_covariance(evaluator: Evaluator, generator: Generator) -> Candidates:
    """CMA-ES with doubled populations on restart (Hansen 2016; IPOP, Auger and Hansen 2005).

    Parameters
    ----------
    evaluator : Evaluator
    generator : numpy.random.Generator

    Returns
    -------
    Candidates
        The last generation of the best run, and the best vector of all.

    Raises
    ------
    InputError
        When the package cmaes is not installed.
    """
    size = 4 + int(3 * math.log(evaluator.problem.lower.size))
    best = _adapt_once(evaluator, generator, size)
    while evaluator.left >= 2 * size:
        size *= 2
        found = _adapt_once(evaluator, generator, size)
        if found.scores.min() < best.scores.min():
            best = found
    return best


def _adapt_once(evaluator: Evaluator, generator: Generator, size: int) -> Candidates:
    try:
        from cmaes import CMA  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise InputError("CMA-ES needs the package cmaes: pip install 'armsyn[cma]'") from error
    problem = evaluator.problem
    dimensions = problem.lower.size
    search = CMA(
        mean=generator.random(dimensions),
        sigma=FIRST_STEP,
        bounds=np.repeat([[0.0, 1.0]], dimensions, axis=0),
        population_size=size,
        seed=int(generator.integers(2**31)),
    )
    best = Candidates(problem.lower[None], np.array([np.inf]))
    while evaluator.left and not search.should_stop():
        shares = np.array([search.ask() for _ in range(size)])[: evaluator.left]
        members = problem.at(shares)
        scores = evaluator.scores(members)
        if scores.min() < best.scores.min():
            best = Candidates(members, scores)
        if len(scores) < size:
            break
        search.tell(list(zip(shares, scores.tolist(), strict=True)))
    return best


def evolve(evaluator: Evaluator, generator: Generator) -> Candidates:
    """Differential evolution (Storn and Price 1997), a generation at a time.

    Parameters
    ----------
    evaluator : Evaluator
    generator : numpy.random.Generator

    Returns
    -------
    Candidates
        The last population.
    """
    problem = evaluator.problem
    members = max(5, min(4 * problem.lower.size, evaluator.left // 8))
    shares = generator.random((min(members, evaluator.left), problem.lower.size))
    if evaluator.left < 2 * members:  # no second generation
        return Candidates(problem.at(shares), evaluator.scores(problem.at(shares)))

    def distances(columns: FloatArray) -> FloatArray:
        return evaluator.scores(problem.at(columns.T))

    found = differential_evolution(
        distances,  # type: ignore[arg-type]  # the stubs know one vector at a time only
        Bounds(np.zeros(problem.lower.size), np.ones(problem.lower.size)),
        init=shares,
        maxiter=evaluator.left // members - 1,
        recombination=RECOMBINATION,
        rng=generator,
        polish=False,
        vectorized=True,
        updating="deferred",
        tol=0.0,
    )
    return Candidates(problem.at(found.population), found.population_energies)
