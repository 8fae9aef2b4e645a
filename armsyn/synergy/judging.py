"""Which of the learned vectors is kept for a reach, and whether an arm may use it.

A vector is played as an arm would play it: phi with its ramp, limits approached softly, until
the hand is there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.motion.peaks import count_peaks
from armsyn.scoring import correlation, movement
from armsyn.scoring.profile import minimum_jerk_fit
from armsyn.synergy.controller import LIMIT_RATE, RAMP_S, Controller, RollOut
from armsyn.synergy.fitting import Fitted
from armsyn.synergy.library import SynergySet
from armsyn.synergy.models import synergies
from armsyn.synergy.options import LearningOptions
from armsyn.synergy.training import Training

FloatArray = NDArray[np.float64]

LEAST_SPEED_R = 0.85
GREATEST_DISTANCE = 0.08
"""Of the arm's reach: the paper's distance beyond which a vector does not fit."""
SLOWEST = 2.0
"""Movement times a vector may take, in those of its capture."""
ARRIVAL_M = 2e-3
LONGEST_S = 6.0
EQUAL = 1.2
"""Vectors within this factor of the least distance count as equals: between them decides how
well they serve other targets."""
MOST_EQUALS = 8
NEIGHBOURS = (0.2, 0.4)
"""Of the arm's reach: how far from the captured target those others lie, along each axis."""
LEAST_SERVICE = 0.8
_FARTHEST = 0.95


class HandSpeed(NamedTuple):
    """How the hand moved: correlations with the capture and with minimum jerk, peaks, time (s)."""

    speed_r: float
    min_jerk_r: float
    peaks: int
    movement_time: float


@dataclass(frozen=True)
class Judge:
    """Judges the vectors learned for one reach.

    Parameters
    ----------
    arm : ArmDescription
    training : Training
    profile : array, shape (101,)
        Captured hand speed over normalised time.
    ik, model : str
    options : LearningOptions
    """

    arm: ArmDescription
    training: Training
    profile: FloatArray
    ik: str
    model: str
    options: LearningOptions

    def verdict(self, fitted: Fitted) -> SynergySet:
        """Choose a vector and say why it may not be used, if it may not.

        Parameters
        ----------
        fitted : Fitted

        Returns
        -------
        SynergySet
            The best vector (the paper's rule); for an arm that moves (``stable``), with a model
            that follows speed, the one among its equals that serves neighbouring targets best.
        """
        parameters = fitted.parameters
        if self._is_for_arms:
            members, scores = fitted.candidates.members, fitted.candidates.scores
            best_first = np.argsort(scores, kind="stable")[:MOST_EQUALS]
            equal = scores[best_first] <= EQUAL * fitted.score
            equals = np.concatenate([parameters[None], members[best_first[equal]]])
            parameters = equals[np.argmax([self._service(member) for member in equals])]
        # Stored with six digits, so judged with six digits
        stored = np.array([float(f"{value:.6g}") for value in parameters])
        distance = self._distance(stored)
        speed_r, misfit = self._fit(stored, distance)
        service = self._service(stored) if self._is_for_arms else 1.0
        if not misfit and service < LEAST_SERVICE:
            misfit = f"serves neighbouring targets poorly ({service:.2f})"
        return SynergySet(
            self.ik, self.model, tuple(stored.tolist()), round(distance, 6), speed_r, misfit
        )

    @property
    def _is_for_arms(self) -> bool:
        return self.options.stable and self.model in ("C", "D")

    def _roll(self, parameters: FloatArray, target: FloatArray, *, as_arm: bool) -> RollOut:
        controller = Controller(self.arm.chain, self.ik, self.options.rate_of(self.ik))
        return controller.synthesize(
            self.training.start,
            target,
            synergies(self.model, self.arm.chain.dof, parameters),
            dt=1.0 / self.options.rate_hz,
            frames=int(LONGEST_S * self.options.rate_hz) if as_arm else self.training.time.size,
            tolerance=ARRIVAL_M if as_arm else -1.0,
            ramp=RAMP_S if as_arm else 0.0,
            limit_rate=LIMIT_RATE if as_arm else np.inf,
        )

    def _distance(self, parameters: FloatArray) -> float:
        """Return the paper's distance, as it was minimised, m."""
        learned = self._roll(parameters, self.training.target, as_arm=False)
        gaps = learned.positions[:, list(self.arm.landmark_frames)] - self.training.landmarks
        return float(np.linalg.norm(gaps, axis=2).mean())

    def _fit(self, parameters: FloatArray, distance: float) -> tuple[float, str]:
        played = self._roll(parameters, self.training.target, as_arm=True)
        hand = self._hand(played)
        longest = SLOWEST * float(self.training.time[-1])
        misfit = ""
        if not played.arrived:
            misfit = f"stays {played.distance * 100:.1f} cm from the target"
        elif distance > GREATEST_DISTANCE * self.arm.chain.reach:
            misfit = f"distance {distance * 100:.1f} cm to the capture"
        elif hand.peaks != 1:
            misfit = f"{hand.peaks} peaks of hand speed"
        elif hand.movement_time > longest:
            misfit = f"takes {hand.movement_time:.2f} s, allowed are {longest:.2f} s"
        elif hand.speed_r < LEAST_SPEED_R:
            misfit = f"speed correlation {hand.speed_r:.2f}"
        return round(hand.speed_r, 4), misfit

    def _hand(self, played: RollOut) -> HandSpeed:
        moved = movement(played.time, played.positions[:, -1])
        speed_r = correlation(self.profile, moved.speed)
        return HandSpeed(
            np.nan_to_num(speed_r).item(),  # a constant speed correlates with nothing
            minimum_jerk_fit(moved.speed, moved.rate)[0],
            count_peaks(moved.speed, moved.rate),
            float(moved.time[-1] - moved.time[0]),
        )

    def _service(self, parameters: FloatArray) -> float:
        """Mean worth of the hand's speed on the way to the target and its neighbours.

        The worth is the lesser of two correlations, with the captured profile and with minimum
        jerk; 0 where the target is missed or the speed has several peaks.
        """
        found = []
        for target in self._neighbours():
            played = self._roll(parameters, target, as_arm=True)
            worth = 0.0
            if played.arrived:
                hand = self._hand(played)
                worth = min(hand.speed_r, hand.min_jerk_r) * (hand.peaks == 1)
            found.append(worth)
        return float(np.mean(found))

    def _neighbours(self) -> Iterator[FloatArray]:
        target = self.training.target
        yield target
        shoulder = self.arm.chain.forward(self.arm.rest).positions[0]
        reach = self.arm.chain.reach
        for share in NEIGHBOURS:
            for offset in share * reach * np.concatenate([np.eye(3), -np.eye(3)]):
                if np.linalg.norm(target + offset - shoulder) < _FARTHEST * reach:
                    yield target + offset
