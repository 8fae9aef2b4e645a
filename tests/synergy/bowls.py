"""Problems whose minimum is known, for the learners."""

import numpy as np

from armsyn.synergy.evaluation import Evaluator, Problem

LOWER, UPPER = np.array([-5.0, 0.0, 1.0, -1.0]), np.array([5.0, 20.0, 10.0, 1.0])
WIDTH = UPPER - LOWER
MINIMUM = np.array([1.0, 5.0, 2.0, 0.3])
LEFT = 0.1


def bowl(minimum: np.ndarray = MINIMUM) -> Problem:
    """Distance in shares of the ranges to a minimum, over what is left there.

    As gaps: each share along an axis of its own, in balanced pairs that leave `LEFT` between them.
    """

    def gaps(parameters: np.ndarray) -> np.ndarray:
        share = (parameters - minimum) / WIDTH
        offsets = np.zeros((len(parameters), 2, 4, 3))
        offsets[..., 0] = share[:, None]
        offsets[:, 0, :, 1], offsets[:, 1, :, 1] = LEFT, -LEFT
        return offsets.reshape(len(parameters), 8, 3)

    def distances(parameters: np.ndarray) -> np.ndarray:
        return np.linalg.norm(gaps(parameters), axis=2).mean(axis=1)

    return Problem(distances, gaps, LOWER, UPPER, np.arange(4))


def evaluator(budget: int, minimum: np.ndarray = MINIMUM) -> Evaluator:
    return Evaluator(bowl(minimum), budget)
