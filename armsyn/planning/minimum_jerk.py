"""Minimum jerk, of joint angles or of the hand along a straight line: rules that need no captures.

Captured reaches, where there are any, only tell how long a person takes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain
from armsyn.planning.ending import EASE
from armsyn.planning.examples import PHASES, Examples
from armsyn.planning.hull import Hull
from armsyn.planning.movement_time import MovementTime, learn_movement_time
from armsyn.planning.postures import postures_at, tips
from armsyn.planning.prediction import Predicted, checked_reaches

FloatArray = NDArray[np.float64]

SHORTEST_S = 0.4
SECONDS_PER_METRE = 0.8
"""Movement time over the way of the hand, where no captures tell it."""


@dataclass(frozen=True)
class MinimumJerkPredictor:
    """Every joint goes its way by minimum jerk (Flash and Hogan 1985, eq. 6, of joint angles).

    Parameters
    ----------
    chain : SerialChain
    time : MovementTime, optional
        Of a person.
    hull : Hull, optional
        Of captured targets; without it `outside` is NaN.
    """

    chain: SerialChain
    time: MovementTime | None = None
    hull: Hull | None = None

    name: ClassVar[str] = "minjerk"

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict M reaches; see `armsyn.planning.prediction.Predictor`.

        The end is the posture nearest to the start, in steps of inverse kinematics.
        """
        first, goals = checked_reaches(self.chain, starts, targets)
        angles, errors = self._moved(first, goals)
        if self.time is None:
            way = np.linalg.norm(goals - tips(self.chain, first), axis=1)
            durations = SHORTEST_S + SECONDS_PER_METRE * way
        else:
            durations = self.time(self.chain, first, goals)
        unknown = np.full(len(goals), np.nan)
        outside = unknown if self.hull is None else self.hull.outside(goals)
        return Predicted(angles, durations, outside, errors)

    def _moved(self, starts: FloatArray, goals: FloatArray) -> tuple[FloatArray, FloatArray]:
        ends, errors = postures_at(self.chain, starts, goals)
        angles = (ends - starts)[:, None] * EASE[:, None]
        angles += starts[:, None]
        return angles, errors


@dataclass(frozen=True)
class StraightHandPredictor(MinimumJerkPredictor):
    """The hand goes straight to the target by minimum jerk, joints follow by least changes.

    Parameters
    ----------
    chain, time, hull
        As of `MinimumJerkPredictor`.

    References
    ----------
    Flash and Hogan 1985, eq. 6.
    """

    name: ClassVar[str] = "minjerk_hand"

    def _moved(self, starts: FloatArray, goals: FloatArray) -> tuple[FloatArray, FloatArray]:
        hands = tips(self.chain, starts)
        angles = np.repeat(starts[:, None], PHASES, axis=1)
        errors = np.zeros(len(goals))
        for phase in range(1, PHASES):
            here = hands + (goals - hands) * EASE[phase]
            angles[:, phase], errors = postures_at(self.chain, angles[:, phase - 1], here)
        return angles, errors


def learn_minimum_jerk(examples: Examples) -> MinimumJerkPredictor:
    """Learn what a person's reaches say about movement times, and where they were captured.

    Parameters
    ----------
    examples : Examples
        As for `armsyn.planning.linear.learn_linear`.

    Returns
    -------
    MinimumJerkPredictor

    Raises
    ------
    CaptureError
        Too few of them, or all in one plane.
    """
    return MinimumJerkPredictor(*_learned(examples))


def learn_straight_hand(examples: Examples) -> StraightHandPredictor:
    """Learn the same for a hand that goes straight; see `learn_minimum_jerk`."""
    return StraightHandPredictor(*_learned(examples))


def _learned(examples: Examples) -> tuple[SerialChain, MovementTime, Hull]:
    return examples.chain, learn_movement_time(examples), Hull.of(examples.targets)
