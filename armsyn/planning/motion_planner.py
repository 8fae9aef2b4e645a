"""Reaches as whole motions: predicted over phase, then bent, slowed and checked for the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armsyn.arm import ArmDescription
from armsyn.errors import InputError
from armsyn.planning.checking import (
    PLANNING_RATE_HZ,
    checked_rate,
    checked_start,
    checked_target,
    not_finite,
)
from armsyn.planning.end_posture import fulfilled
from armsyn.planning.examples import PHASES
from armsyn.planning.finishing import finished, reach_of
from armsyn.planning.nearest import NearestReaches
from armsyn.planning.pacing import thinning
from armsyn.planning.planned import PlannedReach
from armsyn.planning.posing import HandOrientation, HandTask
from armsyn.planning.postures import tips
from armsyn.planning.prediction import Predictor

THERE_M = 5e-4
"""A hand that is this near to its target already stays."""


@dataclass(frozen=True)
class MotionPlanner:
    """Plans reaches of one arm by a predictor of whole motions.

    Parameters
    ----------
    arm : ArmDescription
    predictor : Predictor
        On that arm's chain.
    captured : NearestReaches, optional
        Captured reaches, of which the nearest stands beside a plan to be compared with.

    Raises
    ------
    InputError
        A predictor of other joints.
    """

    arm: ArmDescription
    predictor: Predictor
    captured: NearestReaches | None = None

    def __post_init__(self) -> None:
        if self.predictor.chain.names != self.arm.joint_names:
            raise InputError(
                f"what predicts moves {', '.join(self.predictor.chain.names)}; {self.arm.name} has"
                f" {', '.join(self.arm.joint_names)}: learn its atlas by armsyn learn --atlas"
            )

    @property
    def name(self) -> str:
        """Of the plan, as the predictor's."""
        return self.predictor.name

    def plan(
        self,
        posture: ArrayLike,
        target: ArrayLike,
        rate_hz: float = PLANNING_RATE_HZ,
        *,
        orientation: HandOrientation | None = None,
    ) -> PlannedReach:
        """Plan a reach from a posture to a target; see `armsyn.planning.planner.Planner.plan`."""
        arm, start = self.arm, checked_start(self.arm, posture, stands=True)
        task, rate_hz = HandTask(checked_target(target), orientation), checked_rate(rate_hz)
        found = self.predictor.predict(start[None], task.goal[None])
        angles, duration = found.angles[0], float(found.durations[0])
        if not (np.isfinite(angles).all() and np.isfinite(duration)):
            raise not_finite()
        hand = tips(arm.chain, start[None])[0]
        distance, angle = task.errors(arm.chain, start)
        if distance <= THERE_M and fulfilled(task, distance, angle):
            angles = np.repeat(start[None], PHASES, axis=0)
        done = finished(arm, angles, duration, task, thinning(rate_hz) * rate_hz)
        return reach_of(
            arm,
            task,
            done,
            rate_hz,
            plan=self.name,
            duration_s=duration,
            source=f"planned for {arm.name} by {self.name}",
            outside_m=None if np.isnan(found.outside[0]) else float(found.outside[0]),
            learned=None if self.captured is None else self.captured.of(hand, task.goal)[0][0],
        )
