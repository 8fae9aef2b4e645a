"""Planning how an arm that may be moving follows a new target: which synergy, how slow, how far.

The law (`armsyn.kernels.law`) is played ahead from the state in which it will begin:
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
from armsyn.errors import CollisionError, RefusedMotionError, UnreachableError
from armsyn.ik import optimiser_settings
from armsyn.kernels.arm_numbers import packed
from armsyn.kernels.following import POSTURE, VELOCITY, Followed, follow
from armsyn.kernels.law import HAND, JOINTS, RAMP, Law
from armsyn.kernels.pacing import LEAST_SCALING, MOST_SCALINGS
from armsyn.kernels.ticking import tick
from armsyn.planning.checking import checked_target, out_of_reach, where
from armsyn.planning.end_posture import end_posture
from armsyn.planning.posing import HandOrientation, HandTask, Pointing
from armsyn.planning.tracking_begin import STEP_S, LawMaker
from armsyn.planning.tracking_candidates import candidates
from armsyn.planning.tracking_sources import Source
from armsyn.planning.tracking_state import Candidate, Going, PlannedLaw, at_rest, seen
from armsyn.safety import check_collision
from armsyn.synergy.controller import RAMP_S

FloatArray = NDArray[np.float64]

TOLERANCE_M = 5e-4
"""A target is reached within this distance, m."""

LONGEST_S = 8.0
"""Longest reach before slowing, s."""

SLOWED_S = 60.0
"""No law is slowed to take longer, s: near a singular posture it would take minutes, and planning
it seconds. Where no other synergy serves, the guard of every step bends its way instead."""

HEADROOM = 0.9
"""Share of the limits that a law is slowed to; the rest is for the velocity that is carried over
and for corrections by what is measured."""

GUARD = 0.95
"""Share of the limits that every step keeps, whatever the law asks for."""

_LOOKED_AT = 2
"""Every such posture of a way is looked at for collisions, and what lies between."""


@dataclass(frozen=True)
class LawPlanner:
    """Plans laws of one arm.

    Parameters
    ----------
    arm : ArmDescription
    sources : tuple of Source
        Of its synergies, as `armsyn.planning.tracking_sources.sources_of` finds them.
    ik : {"svd", "jt", "njt", "dls"}
        The optimiser that those are of.
    """

    arm: ArmDescription
    sources: tuple[Source, ...]
    ik: str = "svd"

    @cached_property
    def guarded(self) -> FloatArray:
        """The arm with the limits that every step keeps, `armsyn.kernels.arm_numbers.packed`."""
        return self._packed(GUARD)

    @cached_property
    def _roomy(self) -> FloatArray:
        return self._packed(HEADROOM)

    def _packed(self, share: float) -> FloatArray:
        """The arm with a share of its speeds and accelerations, and its jerks."""
        arm = self.arm
        bounds = np.array(
            [share * arm.max_velocity, share * arm.max_acceleration, np.array(arm.max_jerk)]
        )
        return packed(arm.chain.arrays, optimiser_settings(self.ik), bounds)

    @cached_property
    def _maker(self) -> LawMaker:
        return LawMaker(self.guarded)

    def prepare(self) -> None:
        """Compile what planning and following need, which would hold up a stream for seconds."""
        rest = self.arm.rest
        state = at_rest(rest)
        state[VELOCITY] = 1e-6
        hand = self.arm.chain.forward(rest).tip
        for orientation in (None, Pointing((1.0, 0.0, 0.0))):
            with contextlib.suppress(RefusedMotionError):
                self.plan(state, hand, orientation=orientation)
        out_of_reach(self.arm, rest, hand)
        law, known = (
            Law(np.ones(HAND), np.zeros((JOINTS, rest.size))),
            np.zeros(rest.size, dtype=np.bool_),
        )
        tick(self.guarded, *law, state, rest, known, 0.0, STEP_S, STEP_S, 0.0)

    def plan(
        self,
        state: FloatArray,
        target: ArrayLike,
        going: Going | None = None,
        *,
        orientation: HandOrientation | None = None,
    ) -> PlannedLaw:
        """Plan how to follow a target from a state of the arm.

        Parameters
        ----------
        state : array, shape (7, n)
            In which the law will begin, as `armsyn.kernels.following` has it.
        target : array_like, shape (3,)
            m, base frame.
        going : Going, optional
            What is followed until then.
        orientation : HandOrientation, optional
            How the hand is to be turned there.

        Returns
        -------
        PlannedLaw

        Raises
        ------
        InputError
            No three finite numbers.
        UnreachableError
            The hand cannot be there, or be turned so; or no synergy brings it within
            `TOLERANCE_M`.
        CollisionError
            Those that do go through the arm itself or what is around it.
        """
        task = HandTask(checked_target(target), orientation)
        missed, refused = np.inf, None  # how near the others come; the first that collides
        bent = None  # the first that would be too slow
        here = seen(state)
        hand = self.arm.chain.forward(here).tip
        for candidate in candidates(self.sources, here, hand, task, going):
            # by the law alone: within their limits slow arms do not come there before it is slowed
            path, quick = self._played(
                self._maker.law(state, task, candidate), state, guarded=False
            )
            ending = None
            if orientation is not None:
                ending = end_posture(self.arm, task, here, path[-1])
            elif quick.distance > TOLERANCE_M:
                if missed == np.inf and (
                    beyond := out_of_reach(self.arm, state[POSTURE], task.goal)
                ):
                    raise beyond
                missed = min(missed, quick.distance)
                continue
            slowed, law, is_slow = self._slowed(state, task, candidate, ending)
            path, done = self._played(law, state)
            if done.distance > TOLERANCE_M or not self._turned(task, path[-1]):
                missed = missed if is_slow else min(missed, done.distance)
                continue
            if collision := self._collision(path):
                refused = refused or collision
                continue
            planned = PlannedLaw(law, task, slowed, path, len(path) * STEP_S)
            if not is_slow:
                return planned
            bent = bent or planned
        if bent:
            return bent
        raise refused or self._why_not(task, float(missed))

    def _turned(self, task: HandTask, posture: FloatArray) -> bool:
        """Whether the hand is turned as asked."""
        if task.orientation is None:
            return True
        return task.errors(self.arm.chain, posture)[1] <= task.orientation.tolerance

    def _collision(self, path: FloatArray) -> CollisionError | None:
        some = np.concatenate([path[:-1:_LOOKED_AT], path[-1:]])
        return check_collision(some, self.arm, leaving=True)

    def _why_not(self, task: HandTask, missed: float) -> UnreachableError:
        slow, other = f"would take more than {SLOWED_S:.0f} s", "go by way of another target"
        turned = "" if task.orientation is None else ", or turned wrongly"
        but = f"it {slow}: allow it more (by a smaller --slower), or {other}"
        if missed < np.inf:
            away = f"the hand stays {missed * 100:.1f} cm or more away from it"
            but = f"{away}{turned}, or {slow}: try another --ik, or {other}"
        return UnreachableError(
            f"target {where(task.goal)} is within reach of {self.arm.name}, but with every learned"
            f" synergy {but}",
            missed if missed < np.inf else 0.0,
        )

    def _slowed(
        self,
        state: FloatArray,
        task: HandTask,
        candidate: Candidate,
        ending: FloatArray | None,
    ) -> tuple[Candidate, Law, bool]:
        """Slow a law until it keeps the limits, or as far as that helps: every step keeps them.

        The last of the three says whether it would have to be slower than `SLOWED_S`.
        """
        before, slower = np.inf, candidate
        for _ in range(MOST_SCALINGS):
            candidate = slower
            law = self._maker.law(state, task, candidate, ending)
            path, played = self._played(law, state, guarded=False)
            excess = played.excess
            if excess <= 1.0 or excess > 0.995 * before:
                break
            if len(path) * STEP_S * excess > SLOWED_S:
                return candidate, law, True
            before = excess
            slower = candidate._replace(scale=candidate.scale * max(excess, LEAST_SCALING))
        return candidate, law, False

    def _played(
        self, law: Law, state: FloatArray, *, guarded: bool = True
    ) -> tuple[FloatArray, Followed]:
        """Play a law from a state: the path, and what came of it."""
        steps = int(LONGEST_S * (law.hand[RAMP] / RAMP_S) / STEP_S)
        path = np.empty((steps, self.arm.rest.size))
        arm = self.guarded if guarded else self._roomy
        done = follow(arm, *law, state.copy(), 0.0, STEP_S, steps, TOLERANCE_M, guarded, path)
        return path[: done.made], Followed(*done)
