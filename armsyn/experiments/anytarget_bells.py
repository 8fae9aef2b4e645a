"""Predictions evened into one bell each, as a planner does before an arm gets them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from armsyn.experiments.anytarget_people import RATE_HZ
from armsyn.kinematics import SerialChain
from armsyn.motion import FloatArray
from armsyn.motion.resample import interpolate
from armsyn.planning.evening import EVENINGS, evened
from armsyn.planning.evenness import peaks_of
from armsyn.planning.examples import PHASE, Examples
from armsyn.planning.postures import tips
from armsyn.planning.prediction import Predicted, Predictor
from armsyn.planning.predictor import learn_predictor


@dataclass(frozen=True)
class InBells:
    """Predicts as another does, by as little nearer to minimum jerk as makes one bell of it.

    Parameters
    ----------
    predictor : Predictor
    """

    predictor: Predictor

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict M reaches; see `armsyn.planning.prediction.Predictor`."""
        found = self.predictor.predict(starts, targets)
        angles = in_bells(self.predictor.chain, found.angles, found.durations)
        return dataclasses.replace(found, angles=angles)


def learn_chosen(examples: Examples) -> InBells:
    """Learn latent motions, their kernels chosen by the examples' own targets, to be evened."""
    return InBells(learn_predictor("latent", examples, fewest=2))


def in_bells(chain: SerialChain, angles: FloatArray, durations: FloatArray) -> FloatArray:
    """Even motions whose hands speed up more than once, each by the first step that helps.

    Parameters
    ----------
    chain : SerialChain
    angles : array, shape (M, PHASES, n)
        rad.
    durations : array, shape (M,)
        s.

    Returns
    -------
    array, shape (M, PHASES, n)
        Where no step helps, as it was.
    """
    found, rows = angles.copy(), np.arange(len(angles))
    for how in (None, *EVENINGS):
        motions = evened(angles[rows], how) if how else angles[rows]
        helps = _peaks(chain, motions, durations[rows]) <= 1
        if how:  # smoothed, a joint that turns at its limit swings past
            helps &= ((motions >= chain.lower) & (motions <= chain.upper)).all(axis=(1, 2))
        found[rows[helps]] = motions[helps]
        rows = rows[~helps]
        if not rows.size:
            break
    return found


def _peaks(chain: SerialChain, angles: FloatArray, durations: FloatArray) -> FloatArray:
    """Peaks of the hands' speeds, shape (M,)."""
    paths = []
    for motion, duration in zip(angles, durations, strict=True):
        time = np.linspace(0.0, duration, max(round(duration * RATE_HZ), 1) + 1)
        paths.append(tips(chain, interpolate(PHASE * duration, motion, time)))
    first = np.concatenate([[0], np.cumsum([len(path) for path in paths])])
    return np.asarray(peaks_of(np.concatenate(paths), first, RATE_HZ, np.ones(len(paths))))
