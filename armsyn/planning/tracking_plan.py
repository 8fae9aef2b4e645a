"""Planning how an arm that may be moving follows a new target: which synergy, how slow, how far.

The law (`armsyn.planning.tracking_law`) is played ahead from the state in which it will begin:
the controller is slowed as a whole (lambda / kappa, s / kappa) until speeds and accelerations
hold, and a target whose way collides, or that no synergy arrives at, is refused before the arm
turns to it.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import InputError, RefusedMotionError, UnreachableError
from armsyn.ik import optimiser_settings
from armsyn.kernels.rollout import Synergies
from armsyn.planning.checking import checked_target, out_of_reach, where
from armsyn.planning.tracking_law import Bounds, Law, Moving, controller_velocity, follow
from armsyn.safety import check_collision
from armsyn.synergy import SynergyLibrary
from armsyn.synergy.controller import LIMIT_RATE, RAMP_S

FloatArray = NDArray[np.float64]

TOLERANCE_M = 5e-4
"""A target is reached within this distance, m."""

STEP_S = 0.005
"""Longest step of the law: lambda dt g must stay well below 1."""

FADE_S = 0.3
"""Least time in which a carried velocity fades, s."""

LONGEST_S = 8.0
"""Longest reach before slowing, s, as of `armsyn.planning.reach`."""

HEADROOM = 0.9
"""Share of the limits that a law is slowed to; the rest is for the velocity that is carried over
and for corrections by what is measured."""

GUARD = 0.95
"""Share of the limits that every step keeps, whatever the law asks for."""

_MOST_SCALINGS = 40
_CLOCKS = 201
_SATURATED = 7.0
"""phi is 0.999 where its exponent is this far past the middle."""

_LOOKED_AT = 2
"""Every such posture of a way is looked at for collisions, and what lies between."""


class State(NamedTuple):
    """How an arm moves, and how far it stands off what it is told.

    Attributes
    ----------
    moving : Moving
    correction : array, shape (n,)
        Measured less commanded posture, as far as it is known, rad.
    """

    moving: Moving
    correction: FloatArray

    def copy(self) -> State:
        """Arrays that nobody else writes to."""
        return State(Moving(*(part.copy() for part in self.moving)), self.correction.copy())

    @classmethod
    def at_rest(cls, posture: FloatArray) -> State:
        """An arm that stands still where it is told, shape (n,), rad."""
        n = posture.size
        return cls(Moving(posture.copy(), np.zeros(n), np.zeros(n)), np.zeros(n))


@dataclass(frozen=True)
class PlannedLaw:
    """How a target is to be followed.

    Parameters
    ----------
    law : Law
    path : array, shape (frames, n)
        What comes of it if nothing else happens, `STEP_S` or a period apart, rad.
    duration : float
        Seconds until the hand has come to rest at its target.
    learned : str
        The captured reach whose synergy it uses.
    rank : int
        0 when that is the nearest.
    time_scale : float
        kappa, how much slower than the learned reach.
    """

    law: Law
    path: FloatArray
    duration: float
    learned: str
    rank: int
    time_scale: float


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

    def prepare(self) -> None:
        """Compile what planning and following need, which would hold up a stream for seconds."""
        rest = self.arm.rest
        state = State.at_rest(rest)
        state.moving.v[:] = 1e-6
        hand = self.arm.chain.forward(rest).tip
        with contextlib.suppress(RefusedMotionError):
            self.plan(state, hand)

    def bounds(self, share: float) -> Bounds:
        """A share of the arm's speeds and accelerations."""
        arm = self.arm
        return Bounds(share * arm.max_velocity, share * arm.max_acceleration, arm.max_jerk)

    def plan(self, state: State, target: ArrayLike) -> PlannedLaw:
        """Plan how to follow a target from a state of the arm.

        Parameters
        ----------
        state : State
            In which the law will begin.
        target : array_like, shape (3,)
            m, base frame.

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
        hand = self.arm.chain.forward(state.moving.q + state.correction).tip
        nearest, refused = np.inf, None  # how near the others come; the first that collides
        for rank, (learned, chosen) in enumerate(
            self.library.nearest(hand, goal, self.ik, self.model)
        ):
            synergy = self.library.synergy(chosen)
            missed = self._played(self._law(state, goal, synergy, 1.0), state, GUARD)[1]
            if missed > TOLERANCE_M:
                if rank == 0 and (beyond := out_of_reach(self.arm, state.moving.q, goal)):
                    raise beyond
                nearest = min(nearest, missed)
                continue
            law, scale = self._slowed(state, goal, synergy)
            path, missed, _ = self._played(law, state, GUARD)
            if missed > TOLERANCE_M:
                nearest = min(nearest, missed)
                continue
            seen = np.concatenate([path[:-1:_LOOKED_AT], path[-1:]])
            if collision := check_collision(seen, self.arm, leaving=True):
                refused = refused or collision
                continue
            return PlannedLaw(law, path, len(path) * STEP_S, learned.name, rank, scale)
        raise refused or self._why_not(goal, float(nearest))

    def _why_not(self, goal: FloatArray, missed: float) -> UnreachableError:
        return UnreachableError(
            f"target {where(goal)} is within reach of {self.arm.name}, but every learned synergy"
            f" ({self.ik}/{self.model}) stays {missed * 100:.1f} cm or more away from it: try"
            " another --ik, or go by way of another target",
            missed,
        )

    def _slowed(self, state: State, goal: FloatArray, synergy: Synergies) -> tuple[Law, float]:
        """Slow a law until it keeps the limits, or as far as that helps: every step keeps them."""
        scale, before = 1.0, np.inf
        for _ in range(_MOST_SCALINGS):
            law = self._law(state, goal, synergy, scale)
            excess = self._played(law, state, HEADROOM, guarded=False)[2]
            if excess <= 1.0 or excess > 0.995 * before:
                break
            scale, before = scale * max(excess, 1.01), excess
        return law, scale

    def _played(
        self, law: Law, state: State, share: float, *, guarded: bool = True
    ) -> tuple[FloatArray, float, float]:
        """Play a law from a state: the path, the distance at its end, m, and the excess."""
        n = self.arm.rest.size
        steps = int(LONGEST_S * (self._rate / law.rate) / STEP_S)
        path = np.empty((steps if guarded else 0, n))
        made, distance, excess = follow(
            self.arm.chain.arrays,
            optimiser_settings(self.ik),
            law,
            self.bounds(share),
            state.correction,
            state.copy().moving,
            0.0,
            STEP_S,
            steps,
            TOLERANCE_M,
            guarded,
            path,
        )
        return path[:made], distance, excess

    @property
    def _rate(self) -> float:
        return self.library.lambdas[self.ik]

    def _law(self, state: State, goal: FloatArray, synergy: Synergies, scale: float) -> Law:
        """A law that begins where the arm is as fast as it is."""
        still = Law(
            target=goal,
            gains=synergy.gains[0].copy(),
            slopes=synergy.slopes[0] / scale,
            offsets=synergy.offsets[0].copy(),
            carried=np.zeros((2, state.correction.size)),
            clock=0.0,
            rate=self._rate / scale,
            ramp=RAMP_S * scale,
            limit_rate=LIMIT_RATE / scale,
            fade=FADE_S,
        )
        if not state.moving.v.any() and not state.moving.a.any():
            return still
        return self.begun(still._replace(clock=self._clock(still, state)), state)

    def begun(self, law: Law, state: State) -> Law:
        """A law as it begins in a state: it carries over what the arm has and it does not.

        Parameters
        ----------
        law : Law
        state : State

        Returns
        -------
        Law
        """
        q, v, a = state.moving
        here = self._velocity(law, state, q, law.clock)
        soon = self._velocity(law, state, q + STEP_S * v, law.clock + STEP_S)
        most = self.arm.max_acceleration
        rest, bend = v - here, np.clip(a - (soon - here) / STEP_S, -most, most)
        # minimum jerk decelerates at 15/8 of its mean: half of the acceleration is for that
        fade = max(FADE_S, 3.75 * float(np.max(np.abs(rest) / most)))
        return law._replace(carried=np.array([rest, bend]), fade=fade)

    def _velocity(self, law: Law, state: State, q: FloatArray, t: float) -> FloatArray:
        velocity = np.empty(q.size)
        settings = optimiser_settings(self.ik)
        seen = q + state.correction
        controller_velocity(self.arm.chain.arrays, settings, law, seen, q, t, velocity)
        return velocity

    def _clock(self, law: Law, state: State) -> float:
        """The earliest time of phi at which the controller is nearest to the present velocity.

        An arm at rest begins anew, and so does one that moves elsewhere; one that is told of the
        target that it has already goes on as if nobody had spoken.
        """
        ready = law._replace(
            slopes=np.zeros(1), offsets=np.array([-np.inf]), ramp=0.0, limit_rate=np.inf
        )
        full = self._velocity(ready, state, state.moving.q, 0.0)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            middle = np.where(np.isfinite(law.offsets), (law.offsets + _SATURATED) / law.slopes, 0)
            clocks = np.linspace(0.0, max(float(middle.max()), law.ramp), _CLOCKS)
            phi = 1.0 / (1.0 + np.exp(law.offsets - clocks[:, None] * law.slopes))
        x = np.minimum(clocks / law.ramp, 1.0)
        share = phi * (x**3 * (10.0 - 15.0 * x + 6.0 * x**2))[:, None]
        gap = ((state.moving.v - share * full) ** 2).sum(axis=1)
        return float(clocks[int(np.argmin(gap))])
