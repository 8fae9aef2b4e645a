"""Planning how an arm that may be moving follows a new target: which synergy, how slow, how far.

The law (`armsyn.planning.tracking_law`) is played ahead from the state in which it will begin:
the controller is slowed as a whole (lambda / kappa, s / kappa) until speeds and accelerations
hold, and a target whose way collides, or that no synergy arrives at, is refused before the arm
turns to it.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import CollisionError, InputError, RefusedMotionError, UnreachableError
from armsyn.ik import optimiser_settings
from armsyn.planning.checking import checked_target, out_of_reach, where
from armsyn.planning.tracking_begin import STEP_S, LawMaker
from armsyn.planning.tracking_candidates import candidates
from armsyn.planning.tracking_law import OFF, POSTURE, RATE, VELOCITY, Law, follow, tick
from armsyn.planning.tracking_state import Candidate, Going, PlannedLaw, State
from armsyn.safety import check_collision
from armsyn.synergy import SynergyLibrary

FloatArray = NDArray[np.float64]

TOLERANCE_M = 5e-4
"""A target is reached within this distance, m."""

LONGEST_S = 8.0
"""Longest reach before slowing, s."""

HEADROOM = 0.9
"""Share of the limits that a law is slowed to; the rest is for the velocity that is carried over
and for corrections by what is measured."""

GUARD = 0.95
"""Share of the limits that every step keeps, whatever the law asks for."""

_MOST_SCALINGS = 40
_LOOKED_AT = 2
"""Every such posture of a way is looked at for collisions, and what lies between."""


@dataclass(frozen=True)
class LawPlanner:
    """Plans laws of one arm.

    Parameters
    ----------
    arm : ArmDescription
    library : SynergyLibrary
        Learned for that arm.
    ik : {"svd", "jt", "njt", "dls"}
    model : {"A", "B", "C", "D"}

    Raises
    ------
    InputError
        A library of another arm.
    """

    arm: ArmDescription
    library: SynergyLibrary
    ik: str = "svd"
    model: str = "C"

    def __post_init__(self) -> None:
        if self.library.arm != self.arm.name or self.library.joint_names != self.arm.joint_names:
            raise InputError(
                f"the synergies are those of {self.library.arm}, the arm is {self.arm.name}: run"
                f" armsyn learn --arm {self.arm.name}"
            )
        hand = self.arm.chain.forward(self.arm.rest).tip
        self.library.nearest(hand, hand, self.ik, self.model)  # refuse what it has not learned

    @cached_property
    def maker(self) -> LawMaker:
        """Makes this planner's laws."""
        return LawMaker(self.arm, self.ik, self.library.lambdas[self.ik])

    def prepare(self) -> None:
        """Compile what planning and following need, which would hold up a stream for seconds."""
        rest = self.arm.rest
        state = State.at_rest(rest)
        state.moving[VELOCITY] = 1e-6
        hand = self.arm.chain.forward(rest).tip
        with contextlib.suppress(RefusedMotionError):
            self.plan(state, hand)
        out_of_reach(self.arm, rest, hand)
        known = np.zeros(rest.size, dtype=np.bool_)
        law = Law(np.ones(8), np.zeros((5, rest.size)))
        chain, settings, bounds = (
            self.arm.chain.arrays,
            optimiser_settings(self.ik),
            self.bounds(1.0),
        )
        sensed, moving = state.sensed, state.moving
        tick(chain, settings, law, bounds, sensed, moving, rest, known, 0.0, STEP_S, STEP_S, 0.0)

    def bounds(self, share: float) -> FloatArray:
        """A share of the arm's speeds and accelerations, and its jerks, shape (3, n)."""
        arm = self.arm
        return np.array([share * arm.max_velocity, share * arm.max_acceleration, arm.max_jerk])

    def plan(self, state: State, target: ArrayLike, going: Going | None = None) -> PlannedLaw:
        """Plan how to follow a target from a state of the arm.

        Parameters
        ----------
        state : State
            In which the law will begin.
        target : array_like, shape (3,)
            m, base frame.
        going : Going, optional
            What is followed until then.

        Returns
        -------
        PlannedLaw

        Raises
        ------
        InputError
            No three finite numbers.
        UnreachableError
            No learned synergy brings the hand within `TOLERANCE_M`.
        CollisionError
            Those that do go through the arm itself or what is around it.
        """
        goal = checked_target(target)
        missed, refused = np.inf, None  # how near the others come; the first that collides
        hand = self.arm.chain.forward(state.seen).tip
        for candidate in candidates(self.library, self.ik, self.model, hand, goal, going):
            quick = self._played(self.maker.law(state, goal, candidate), state)[1]
            if quick > TOLERANCE_M:
                if missed == np.inf and (
                    beyond := out_of_reach(self.arm, state.moving[POSTURE], goal)
                ):
                    raise beyond
                missed = min(missed, quick)
                continue
            slowed, law = self._slowed(state, goal, candidate)
            path, distance, _ = self._played(law, state)
            if distance > TOLERANCE_M:
                missed = min(missed, distance)
                continue
            if collision := self._collision(path):
                refused = refused or collision
                continue
            return PlannedLaw(
                law,
                slowed.synergy,
                slowed.chosen_for,
                path,
                len(path) * STEP_S,
                slowed.name,
                slowed.rank,
                slowed.scale,
            )
        raise refused or self._why_not(goal, float(missed))

    def _collision(self, path: FloatArray) -> CollisionError | None:
        seen = np.concatenate([path[:-1:_LOOKED_AT], path[-1:]])
        return check_collision(seen, self.arm, leaving=True)

    def _why_not(self, goal: FloatArray, missed: float) -> UnreachableError:
        return UnreachableError(
            f"target {where(goal)} is within reach of {self.arm.name}, but every learned synergy"
            f" ({self.ik}/{self.model}) stays {missed * 100:.1f} cm or more away from it: try"
            " another --ik, or go by way of another target",
            missed,
        )

    def _slowed(
        self, state: State, goal: FloatArray, candidate: Candidate
    ) -> tuple[Candidate, Law]:
        """Slow a law until it keeps the limits, or as far as that helps: every step keeps them."""
        before = np.inf
        for _ in range(_MOST_SCALINGS):
            law = self.maker.law(state, goal, candidate)
            excess = self._played(law, state, guarded=False)[2]
            if excess <= 1.0 or excess > 0.995 * before:
                break
            before = excess
            candidate = candidate._replace(scale=candidate.scale * max(excess, 1.01))
        return candidate, law

    def _played(
        self, law: Law, state: State, *, guarded: bool = True
    ) -> tuple[FloatArray, float, float]:
        """Play a law from a state: the path, the distance at its end, m, and the excess."""
        steps = int(LONGEST_S * (self.maker.rate / law.hand[RATE]) / STEP_S)
        path = np.empty((steps if guarded else 0, self.arm.rest.size))
        made, distance, excess, _ = follow(
            self.arm.chain.arrays,
            optimiser_settings(self.ik),
            law,
            self.bounds(GUARD if guarded else HEADROOM),
            state.sensed[OFF],
            state.moving.copy(),
            0.0,
            STEP_S,
            steps,
            TOLERANCE_M,
            guarded,
            path,
        )
        return path[:made], distance, excess
