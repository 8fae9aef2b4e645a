"""Reaches by the motion controller, with the synergy of the nearest learned reach.

People reach faster than servos turn: a planned reach is slowed as a whole (lambda / kappa,
s / kappa, the same path) until the limits of speed, acceleration and jerk hold.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import InputError, RefusedMotionError, UnreachableError
from armsyn.kernels import pacing
from armsyn.planning.allowed import Finished
from armsyn.planning.checking import (
    PLANNING_RATE_HZ,
    TOLERANCE_M,
    checked_rate,
    checked_start,
    checked_target,
    out_of_reach,
    where,
)
from armsyn.planning.evenness import uneven_speed
from armsyn.planning.examples import PHASES
from armsyn.planning.finishing import finished, reach_of
from armsyn.planning.nearest import NearestReaches
from armsyn.planning.pacing import thinning
from armsyn.planning.planned import PlannedReach
from armsyn.planning.posing import HandOrientation, HandTask
from armsyn.planning.timing import Rates, too_fast, too_long
from armsyn.safety import check_collision
from armsyn.synergy import LearnedReach, SynergyLibrary, SynergySet
from armsyn.synergy.controller import LIMIT_RATE, RAMP_S, Controller, RollOut

FloatArray = NDArray[np.float64]

ARRIVED_M = 0.5 * TOLERANCE_M
"""A roll-out stops within this distance of its target."""

LONGEST_S = 8.0
"""Longest reach before slowing; what takes longer to arrive does not arrive."""

_AT_LIMIT_RAD = 0.01


@dataclass(frozen=True)
class SynergyPlanner:
    """Plans reaches of one arm by roll-outs of the controller.

    Parameters
    ----------
    arm : ArmDescription
    library : SynergyLibrary
        Learned for that arm.
    ik : {"svd", "jt", "njt", "dls"}
    model : {"A", "B", "C", "D"}
        A is the paper's raw controller: one gain, no sigmoid.

    Raises
    ------
    InputError
        A library of another arm.
    """

    arm: ArmDescription
    library: SynergyLibrary
    ik: str = "svd"
    model: str = "C"

    name: ClassVar[str] = "synergy"

    def __post_init__(self) -> None:
        if self.library.arm != self.arm.name or self.library.joint_names != self.arm.joint_names:
            raise InputError(
                f"the synergies are those of {self.library.arm}"
                f" ({', '.join(self.library.joint_names)}), the arm is {self.arm.name}"
                f" ({', '.join(self.arm.joint_names)}): run armsyn learn --arm {self.arm.name}"
            )

    def plan(
        self,
        posture: ArrayLike,
        target: ArrayLike,
        rate_hz: float = PLANNING_RATE_HZ,
        *,
        orientation: HandOrientation | None = None,
    ) -> PlannedReach:
        """Plan a reach from a posture to a target; see `armsyn.planning.planner.Planner.plan`.

        Raises
        ------
        InputError, LimitError, UnreachableError, CollisionError
            As there; LimitError also where no synergy that arrives can be slowed until the limits
            hold, UnreachableError where none arrives, CollisionError where those that do touch
            something, by any swivel.
        """
        start = checked_start(self.arm, posture, stands=True)
        task, rate_hz = HandTask(checked_target(target), orientation), checked_rate(rate_hz)
        fine_hz = thinning(rate_hz) * rate_hz
        first: _Arrived | None = None
        missed: RollOut | None = None
        hand = self.arm.chain.positions(start[None])[0, -1]
        for rank, (learned, synergy) in enumerate(self.captured.of(hand, task.goal)):
            rolled = self._roll(start, task.goal, synergy, fine_hz, 1.0)
            if not rolled.arrived:
                missed = rolled if missed is None or rolled.distance < missed.distance else missed
                continue
            arrived = _Arrived(rank, learned, synergy, rolled)
            first = first or arrived
            if orientation is not None:
                break
            with suppress(RefusedMotionError):  # the next may serve; if none does, the first tells
                return self._planned(
                    task, arrived, self._as_played(arrived, task, fine_hz), rate_hz
                )
        if first is None:
            assert missed is not None  # noqa: S101 - there is a candidate
            raise self._why_not(start, task.goal, missed)
        duration = float(first.rolled.time[-1])
        done = finished(self.arm, _over_phase(first.rolled.angles), duration, task, fine_hz)
        return self._planned(task, first, done, rate_hz)

    @property
    def complete(self) -> bool:
        """Whether learning came to its end."""
        return self.library.complete

    @cached_property
    def captured(self) -> NearestReaches:
        """The learned reaches that may serve."""
        return NearestReaches(self.library, self.ik, self.model)

    @cached_property
    def _controller(self) -> Controller:
        return Controller(self.arm.chain, self.ik, self.library.lambdas[self.ik])

    def _roll(
        self, start: FloatArray, goal: FloatArray, synergy: SynergySet, rate_hz: float, scale: float
    ) -> RollOut:
        return self._controller.synthesize(
            start,
            goal,
            self.library.synergy(synergy),
            dt=1.0 / rate_hz,
            frames=int(LONGEST_S * scale * rate_hz) + 2,
            tolerance=ARRIVED_M,
            time_scale=scale,
            ramp=RAMP_S,
            limit_rate=LIMIT_RATE,
        )

    def _as_played(self, arrived: _Arrived, task: HandTask, rate_hz: float) -> Finished:
        """Slow a roll-out until the arm's limits hold; refuse it where it touches."""
        rolled, scale = arrived.rolled, 1.0
        start, rates = rolled.angles[0], Rates.of(self.arm)
        for _ in range(pacing.MOST_SCALINGS):
            excess = rates.excess(rolled.angles, rate_hz)
            worst = int(excess.argmax())
            if excess[worst] <= 1.0:
                break
            scale *= max(float(excess[worst]), pacing.LEAST_SCALING)
            if rolled.time[-1] * scale > pacing.LONGEST_S:
                raise too_long(self.arm, worst, float(rolled.time[-1]) * scale)
            rolled = self._roll(start, task.goal, arrived.synergy, rate_hz, scale)
        else:
            raise too_fast(self.arm, worst, float(excess[worst]), scale)
        if not rolled.arrived:
            raise self._why_not(start, task.goal, rolled)
        if collision := check_collision(rolled.angles, self.arm, leaving=True):
            raise collision
        if uneven := uneven_speed(rolled.positions[:, -1], rate_hz, scale):
            raise uneven
        return Finished(rolled.angles, scale)

    def _planned(
        self, task: HandTask, arrived: _Arrived, done: Finished, rate_hz: float
    ) -> PlannedReach:
        return reach_of(
            self.arm,
            task,
            done,
            rate_hz,
            plan=self.name,
            duration_s=float(arrived.rolled.time[-1]),
            source=f"planned for {self.arm.name} like {arrived.learned.name or 'nobody'}",
            outside_m=self.captured.outside(task.goal),
            learned=arrived.learned if arrived.learned.name else None,
            synergy=arrived.synergy,
            rank=arrived.rank,
        )

    def _why_not(self, start: FloatArray, goal: FloatArray, missed: RollOut) -> UnreachableError:
        if refused := out_of_reach(self.arm, start, goal):
            return refused
        chain, last = self.arm.chain, missed.angles[-1]
        near_limit = np.minimum(last - chain.lower, chain.upper - last) < _AT_LIMIT_RAD
        joints = [name for name, near in zip(chain.names, near_limit, strict=True) if near]
        why = f", with {' and '.join(joints)} at the limit" if joints else ""
        return UnreachableError(
            f"target {where(goal)} is within reach of {self.arm.name}, but every learned synergy"
            f" ({self.ik}/{self.model}) is still {missed.distance * 100:.1f} cm or more away from"
            f" it after {missed.time[-1]:.0f} s{why}: try another --ik or --plan, or go by way of"
            " another target",
            missed.distance,
        )


class _Arrived(NamedTuple):
    """A roll-out that came to its target, and what it was played with."""

    rank: int
    learned: LearnedReach
    synergy: SynergySet
    rolled: RollOut


def _over_phase(angles: FloatArray) -> FloatArray:
    """A roll-out at `PHASES` equal steps of time, for what bends motions."""
    rows = np.linspace(0.0, angles.shape[0] - 1.0, PHASES)
    before = np.minimum(rows.astype(np.int64), max(angles.shape[0] - 2, 0))
    after = np.minimum(before + 1, angles.shape[0] - 1)
    share = (rows - before)[:, None]
    return np.asarray((1.0 - share) * angles[before] + share * angles[after])
