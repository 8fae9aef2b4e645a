"""What predictors have to beat in the experiment `anytarget`: means of captured reaches and raw IK.

Each is learned from examples and predicts as `armsyn.planning.prediction.Predictor` does. Those
without a movement time of their own take the one that is linear in the target.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armsyn.kinematics import SerialChain
from armsyn.motion import FloatArray
from armsyn.motion.resample import interpolate, uniform_times
from armsyn.motion.segmentation import CUT_FRACTION
from armsyn.planning.ending import led_to
from armsyn.planning.examples import PHASE, Examples
from armsyn.planning.linear import LinearPredictor, learn_linear, with_one
from armsyn.planning.prediction import Predicted
from armsyn.scoring.distance import held_distance
from armsyn.scoring.pairing import Movement, Trimmed
from armsyn.synergy.controller import ARM_RATES, Controller
from armsyn.synergy.models import synergies

_RATE_HZ = 100.0
_LONGEST_S = 8.0
_GAINS = (0.1, 0.15, 0.25, 0.4, 0.6, 1.0, 1.5)
_JUDGED_BY = 8
"""Examples by which the one gain of S_A is chosen."""
Paths = Callable[[FloatArray, FloatArray], FloatArray]
"""From starts (M, n) and targets (M, 3) to angles over normalised time, (M, 101, n)."""


@dataclass(frozen=True, eq=False)
class PathPredictor:
    """Paths in movement times that are linear in the target, as those of the linear baseline.

    Parameters
    ----------
    timing : LinearPredictor
        Learned from the same examples.
    paths : callable
        From starts and targets to angles over normalised time.
    """

    timing: LinearPredictor
    paths: Paths

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict reaches; see `armsyn.planning.prediction.Predictor`."""
        times = np.clip(
            with_one(targets) @ self.timing.times, self.timing.shortest, self.timing.longest
        )
        return predicted(self.timing.chain, self.paths(starts, targets), times, targets)


def predicted(
    chain: SerialChain, paths: FloatArray, durations: FloatArray, targets: FloatArray
) -> Predicted:
    """Say what paths (M, 101, n) miss at their ends; how far outside is not asked of baselines."""
    missed = np.linalg.norm(chain.positions(paths[:, -1])[:, -1] - targets, axis=1)
    return Predicted(paths, durations, np.zeros(len(targets)), missed)


@dataclass(frozen=True, eq=False)
class MeanReach:
    """The mean of all examples, led to start and end, in their mean time.

    Learned from the other repeats of a target it is the human floor.

    Parameters
    ----------
    examples : Examples
    """

    examples: Examples

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict reaches; see `armsyn.planning.prediction.Predictor`."""
        count, chain = len(targets), self.examples.chain
        mean = self.examples.angles.mean(axis=0)
        paths, _ = led_to(chain, mean[None].repeat(count, axis=0), starts, targets)
        times = np.full(count, self.examples.durations.mean())
        return predicted(chain, paths, times, targets)


def nearest_reach(examples: Examples) -> PathPredictor:
    """Learn the mean reach of each captured target; the nearest target's is led to a new one."""
    nearest = nearest_mean(examples)

    def paths(starts: FloatArray, targets: FloatArray) -> FloatArray:
        return led_to(examples.chain, nearest(targets), starts, targets)[0]

    return PathPredictor(learn_linear(examples), paths)


def nearest_mean(examples: Examples) -> Callable[[FloatArray], FloatArray]:
    """Return what finds the mean motion (101, n) of the captured target nearest to each of some.

    Parameters
    ----------
    examples : Examples
        The same target of two persons is two.

    Returns
    -------
    callable
        From targets (M, 3) to motions (M, 101, n).
    """
    owners = list(zip(examples.subjects, examples.places, strict=True))
    groups = [
        [row for row, other in enumerate(owners) if other == owner]
        for owner in dict.fromkeys(owners)
    ]
    centres = np.array([examples.targets[rows].mean(axis=0) for rows in groups])
    means = np.array([examples.angles[rows].mean(axis=0) for rows in groups])

    def nearest(targets: FloatArray) -> FloatArray:
        apart = np.linalg.norm(centres - targets[:, None], axis=2)
        return np.asarray(means[apart.argmin(axis=1)])

    return nearest


@dataclass(frozen=True, eq=False)
class RawIk:
    """The paper's S_A: an optimiser's steps at one gain.

    Parameters
    ----------
    controller : Controller
    gain : float
    """

    controller: Controller
    gain: float

    def predict(self, starts: FloatArray, targets: FloatArray) -> Predicted:
        """Predict reaches; see `armsyn.planning.prediction.Predictor`."""
        chain = self.controller.chain
        played = [self.play(*pair) for pair in zip(starts, targets, strict=True)]
        paths = np.array(
            [interpolate(np.linspace(0.0, 1.0, len(path)), path, PHASE) for path in played]
        )
        times = np.array([(len(path) - 1) / _RATE_HZ for path in played])
        return predicted(chain, led_to(chain, paths, starts, targets)[0], times, targets)

    def play(self, start: FloatArray, target: FloatArray) -> FloatArray:
        """Roll out one reach, cut as captures are: where the hand is below 5 % of its peak speed.

        Parameters
        ----------
        start : array, shape (n,)
        target : array, shape (3,)

        Returns
        -------
        array, shape (frames, n)
            At 100 Hz; a decay never ends, and a little is left at the cut.
        """
        chain = self.controller.chain
        rolled = self.controller.synthesize(
            start,
            target,
            synergies("A", chain.dof, [self.gain]),
            dt=1.0 / _RATE_HZ,
            frames=round(_LONGEST_S * _RATE_HZ),
        )
        speed = np.linalg.norm(np.diff(rolled.positions[:, -1], axis=0), axis=1)
        last = int(np.flatnonzero(speed >= CUT_FRACTION * speed.max())[-1])
        return rolled.angles[: max(last + 2, 3)]


def raw_ik(examples: Examples, optimiser: str) -> RawIk:
    """Choose the one gain of S_A by the held distance of a few examples.

    Parameters
    ----------
    examples : Examples
    optimiser : {"svd", "jt", "njt"}

    Returns
    -------
    RawIk
    """
    few = examples.only(
        np.unique(np.linspace(0, examples.size - 1, min(_JUDGED_BY, examples.size)).astype(int))
    )
    controller = Controller(examples.chain, optimiser, ARM_RATES[optimiser])

    def mean_distance(ik: RawIk) -> float:
        tasks = zip(few.starts, few.targets, strict=True)
        return float(np.mean([_held(few, row, ik.play(*task)) for row, task in enumerate(tasks)]))

    return min((RawIk(controller, gain) for gain in _GAINS), key=mean_distance)


def _held(examples: Examples, row: int, played: FloatArray) -> float:
    duration = float(examples.durations[row])
    moments = uniform_times(0.0, duration, _RATE_HZ)
    captured = interpolate(PHASE * duration, examples.angles[row], moments)
    first, second = (
        Movement(places, places, len(places) / _RATE_HZ)
        for places in map(examples.chain.positions, (captured, played))
    )
    return held_distance(Trimmed(first, second, _RATE_HZ))
