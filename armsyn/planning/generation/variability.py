"""How a person's repeats of one reach differ, and reaches that differ so.

What captured repeats leave of a prediction is freed of each target's own mean; its covariance,
of joint angles over phase and the logarithm of the movement time together, is what is drawn from.
"""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import CaptureError
from armsyn.kinematics import SerialChain
from armsyn.planning.ending import EASE, ended_at
from armsyn.planning.examples import Examples
from armsyn.planning.generation.chance import normal
from armsyn.planning.postures import jacobians
from armsyn.planning.prediction import Predicted, Predictor

FloatArray = NDArray[np.float64]

KEPT = 0.99
"""Share of the variance that modes are kept for."""

MOST_MODES = 24
MOST_STRETCH = 2.0
"""Of modes at an end posture, of which the hand leaves hardly anything where it is."""
_STILL = 0.02
"""Share of the arm's reach, m/rad: what moves the hand by less does not."""

FEWEST_REPEATS = 6
"""Repeats beyond the first of each target, for a covariance that is more than chance."""


@dataclass(frozen=True)
class Variability:
    """Modes by which repeats differ.

    Parameters
    ----------
    modes : array, shape (k, PHASES, n)
        Each one's change of the joint angles at one standard deviation, rad or m; none at the
        start.
    times : array, shape (k,)
        The same of the logarithm of the movement time.
    repeats : int
        Captured repeats beyond the first of each target that they are learned from.
    """

    modes: FloatArray
    times: FloatArray
    repeats: int

    def vary(
        self, chain: SerialChain, predicted: Predicted, targets: FloatArray, seed: int, first: int
    ) -> Predicted:
        """Make predictions differ as repeats do; start and end stay.

        Parameters
        ----------
        chain : SerialChain
        predicted : Predicted
            Reaches `first` and on, by index.
        targets : array, shape (M, 3)
            m.
        seed : int
        first : int
            Index of the first: each reach's chance is its own.

        Returns
        -------
        Predicted
        """
        count = len(targets)
        z = normal(seed, "repeats", first, first + count, len(self.times))
        change = (z @ self.modes.reshape(len(self.times), -1)).reshape(predicted.angles.shape)
        last = np.einsum("mk,mkn->mn", z, self._last_modes(chain, predicted.angles[:, -1]))
        change += EASE[:, None] * (last - change[:, -1])[:, None]
        angles, errors = ended_at(chain, predicted.angles + change, targets)
        durations = predicted.durations * np.exp(z @ self.times)
        return dataclasses.replace(predicted, angles=angles, durations=durations, errors=errors)

    def _last_modes(self, chain: SerialChain, ends: FloatArray) -> FloatArray:
        """Return what the modes change at end postures, shape (M, n), the hand staying: (M, k, n).

        People's repeats that end with the hand in one place differ by what leaves it there. That
        is another part of posture space at every place, and modes of all places lie in none of
        them: what is left of them there has less than people's variance, and is stretched to it.
        """
        last = self.modes[:, -1]
        J = jacobians(chain, ends)
        square = J @ J.transpose(0, 2, 1) + (_STILL * chain.reach) ** 2 * np.eye(3)
        moved = np.einsum("kn,man->mka", last, J)
        staying = last - np.einsum("mka,man->mkn", moved, np.linalg.solve(square, J))
        size = np.sqrt((staying**2).sum(axis=(1, 2)))
        stretch = np.minimum(np.linalg.norm(last) / np.maximum(size, 1e-9), MOST_STRETCH)
        return np.asarray(stretch[:, None, None] * staying)


def learn_variability(examples: Examples, predictor: Predictor) -> Variability:
    """Learn how repeats differ.

    Parameters
    ----------
    examples : Examples
        Captured reaches; repeats share subject and place.
    predictor : Predictor
        Whose starts and ends are those of the captures: what it leaves is what repeats differ by.

    Returns
    -------
    Variability

    Raises
    ------
    CaptureError
        Fewer than `FEWEST_REPEATS` repeats.
    """
    groups = defaultdict(list)
    for row, key in enumerate(zip(examples.subjects, examples.places, strict=True)):
        groups[key].append(row)
    several = [np.array(rows) for rows in groups.values() if len(rows) > 1]
    repeats = sum(len(rows) - 1 for rows in several)
    if repeats < FEWEST_REPEATS:
        raise CaptureError(
            f"{repeats} repeats of a captured reach: variability needs {FEWEST_REPEATS} at least,"
            " such as those of hug_mp:S01:all"
        )
    predicted = predictor.predict(examples.starts, examples.targets)
    left = (examples.angles - predicted.angles).reshape(examples.size, -1)
    times = np.log(examples.durations / predicted.durations)
    both = np.concatenate([left, times[:, None]], axis=1)
    around = np.concatenate([both[rows] - both[rows].mean(axis=0) for rows in several])
    return _modes(around / np.sqrt(repeats), examples.angles.shape[1:], repeats)


def _modes(factor: FloatArray, shape: tuple[int, ...], repeats: int) -> Variability:
    """The greatest modes of the covariance ``factor.T @ factor``."""
    # log times are of the size of angles, so neither drowns in the other
    _, sizes, directions = np.linalg.svd(factor, full_matrices=False)
    share = np.cumsum(sizes**2) / np.sum(sizes**2)
    count = min(int(np.searchsorted(share, KEPT)) + 1, MOST_MODES, len(sizes))
    found = sizes[:count, None] * directions[:count]
    # of two directions the one whose largest part is positive: the same bytes everywhere
    found *= np.sign(found[np.arange(count), np.abs(found).argmax(axis=1)])[:, None]
    modes = found[:, :-1].reshape(count, *shape)
    modes[:, 0] = 0.0
    return Variability(modes, found[:, -1].copy(), repeats)
