"""What the experiments share: learning each reach's own parameters, and playing them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from armsyn.experiments.selections import Prepared
from armsyn.experiments.settings import Settings
from armsyn.motion.filtering import hand_speed
from armsyn.motion.resample import interpolate
from armsyn.scoring import correlation
from armsyn.synergy.controller import Controller
from armsyn.synergy.learning import fit
from armsyn.synergy.models import synergies
from armsyn.synergy.training import Training

FloatArray = NDArray[np.float64]
Progress = Callable[[str, int, int, str], None]


@dataclass(frozen=True)
class Learned:
    """One optimiser and model, learned for every reach by itself.

    Parameters
    ----------
    prepared : Prepared
    ik, model : str
    rate : float
        lambda, 1/s.
    parameters : array, shape (reaches, parameters)
    distances : array, shape (reaches,)
        The paper's distance that was minimised, m: a training error.
    """

    prepared: Prepared
    ik: str
    model: str
    rate: float
    parameters: FloatArray
    distances: FloatArray = field(repr=False)

    @property
    def mean(self) -> float:
        """Mean distance, m."""
        return float(self.distances.mean())

    def play(self, row: int, onto: Training | None = None, longer: float = 1.0) -> FloatArray:
        """Play what was learned for a reach.

        Parameters
        ----------
        row : int
            The reach whose parameters are played.
        onto : Training, optional
            Another reach, whose start and target are taken.
        longer : float
            Play for so many times the captured duration.

        Returns
        -------
        array, shape (frames, landmarks, 3)
            m.
        """
        arm = self.prepared.arm
        training = onto or self.prepared.trainings[row]
        rolled = Controller(arm.chain, self.ik, self.rate).synthesize(
            training.start,
            training.target,
            synergies(self.model, arm.chain.dof, self.parameters[row]),
            dt=1.0 / self.prepared.selection.rate_hz,
            frames=round(longer * training.time.size),
        )
        return np.asarray(rolled.positions[:, list(arm.landmark_frames)])

    @cached_property
    def speed_rs(self) -> FloatArray:
        """Correlation of each played hand's speed with the captured one, shape (reaches,)."""
        return np.array([self._speed_r(row) for row in range(len(self.distances))])

    def _speed_r(self, row: int) -> float:
        training = self.prepared.trainings[row]
        captured = speed(training.time, training.landmarks[:, -1])
        played = speed(training.time, self.play(row)[:, -1])
        return float(np.nan_to_num(correlation(captured, played)))


def speed(time: FloatArray, hand: FloatArray) -> FloatArray:
    """Hand speed at the motion's own frames, filtered as every speed here.

    Parameters
    ----------
    time : array, shape (frames,)
        s.
    hand : array, shape (frames, 3)
        m.

    Returns
    -------
    array, shape (frames,)
        m/s; the hand is taken to rest before and after.
    """
    profile = hand_speed(time, hand)
    return interpolate(profile.time, profile.speed, time)


def learn_each(
    prepared: Prepared,
    pairs: Iterable[tuple[str, str]],
    settings: Settings,
    on_progress: Progress,
    *,
    stable: bool = False,
) -> dict[tuple[str, str], Learned]:
    """Learn optimisers and models, one set of parameters a reach.

    Parameters
    ----------
    prepared : Prepared
    pairs : iterable of (ik, model)
    settings : Settings
    on_progress : callable
        As in `armsyn.synergy.learning.learn`.
    stable : bool
        Positive gains instead of the paper's bounds.

    Returns
    -------
    dict of (ik, model) to Learned

    Raises
    ------
    KeyboardInterrupt
        When Ctrl-C ended one of them: half of an experiment is none.
    """
    bounds = ", positive gains" if stable else ""

    def report(name: str, done: int, total: int, said: str) -> None:
        on_progress(f"{prepared.selection.title}: {name}{bounds}", done, total, said)

    found = {}
    for ik, model in pairs:
        options = settings.options(prepared, model, stable=stable)
        fitted = fit(prepared.arm, prepared.trainings, ik, model, options, report)
        rate = options.rate_of(ik)
        found[ik, model] = Learned(prepared, ik, model, rate, fitted.parameters, fitted.scores)
    return found
