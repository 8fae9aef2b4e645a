"""Planning how an arm that may be moving follows a new target: which synergy, how slow, how far.

The law (`armsyn.planning.tracking_law`) is played ahead from the state in which it will begin:
the controller is slowed as a whole (lambda / kappa, s / kappa) until speeds and accelerations
hold, and a target whose way collides, or that no synergy arrives at, is refused before the arm
turns to it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import CollisionError, InputError, RefusedMotionError, UnreachableError
from armsyn.ik import optimiser_settings
from armsyn.planning.checking import checked_target, out_of_reach, where
from armsyn.planning.tracking_law import (
    CARRIED,
    CLOCK,
    FADE,
    GAIN,
    LIMIT_RATE,
    OFF,
    OFFSET,
    POSTURE,
    RAMP,
    RATE,
    SLOPE,
    VELOCITY,
    Law,
    controller_velocity,
    follow,
    tick,
)
from armsyn.planning.tracking_state import Candidate, Going, PlannedLaw, State
from armsyn.safety import check_collision
from armsyn.synergy import SynergyLibrary
from armsyn.synergy.controller import LIMIT_RATE as NEARING_RATE
from armsyn.synergy.controller import RAMP_S

FloatArray = NDArray[np.float64]

TOLERANCE_M = 5e-4
"""A target is reached within this distance, m."""

STEP_S = 0.005
"""Longest step of the law: lambda dt g must stay well below 1."""

FADE_S = 0.12
"""Least time constant with which a carried velocity fades, s: of what people have left of an
abandoned movement little remains after 0.4 s."""

LONGEST_S = 8.0
"""Longest reach before slowing, s."""

HEADROOM = 0.9
"""Share of the limits that a law is slowed to; the rest is for the velocity that is carried over
and for corrections by what is measured."""

GUARD = 0.95
"""Share of the limits that every step keeps, whatever the law asks for."""

SAME_REACH = 0.25
"""A target that has moved by no more than this share of what is left to it is the same reach's:
synergy, slowing and clock go on."""

STREAM_S = 0.25
STREAM_M = 0.03
"""So is one that has moved by no more than that within that time of the last."""

SAME_PLACE = 0.15
"""But not beyond this distance from the target that the synergy was chosen for, m."""

_MOST_SCALINGS = 40
_CLOCKS = 201
_SATURATED = 7.0
"""phi is 0.999 where its exponent is this far past the middle."""

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

    def prepare(self) -> None:
        """Compile what planning and following need, which would hold up a stream for seconds."""
        rest = self.arm.rest
        state = State.at_rest(rest)
        state.moving[VELOCITY] = 1e-6
        hand = self.arm.chain.forward(rest).tip
        with contextlib.suppress(RefusedMotionError):
            self.plan(state, hand)
        out_of_reach(self.arm, rest, hand)
        law = Law(np.ones(8), np.zeros((5, rest.size)))
        chain, settings, bounds = (
            self.arm.chain.arrays,
            optimiser_settings(self.ik),
            self.bounds(GUARD),
        )
        known = np.zeros(rest.size, dtype=np.bool_)
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
        for candidate in self._candidates(state, goal, going):
            quick = self._played(self._law(state, goal, candidate), state)[1]
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

    def _candidates(
        self, state: State, goal: FloatArray, going: Going | None
    ) -> Iterator[Candidate]:
        """Synergies that may serve, the likeliest first."""
        hand = self.arm.chain.forward(state.seen).tip
        if going is not None and _goes_on(going, goal, hand):
            then = going.planned
            phase = (then.law.clock + going.elapsed) / then.time_scale
            yield Candidate(
                then.learned, then.rank, then.synergy, then.time_scale, then.chosen_for, phase
            )
        nearest = self.library.nearest(hand, goal, self.ik, self.model)
        for rank, (learned, chosen) in enumerate(nearest):
            yield Candidate(learned.name, rank, self.library.synergy(chosen), 1.0, goal)

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
            law = self._law(state, goal, candidate)
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
        steps = int(LONGEST_S * (self._rate / law.hand[RATE]) / STEP_S)
        path = np.empty((steps if guarded else 0, self.arm.rest.size))
        made, distance, excess = follow(
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

    @property
    def _rate(self) -> float:
        return self.library.lambdas[self.ik]

    def _law(self, state: State, goal: FloatArray, candidate: Candidate) -> Law:
        """A law that begins where the arm is as fast as it is."""
        synergy, scale = candidate.synergy, candidate.scale
        hand, joints = np.zeros(8), np.zeros((5, self.arm.rest.size))
        hand[:3] = goal
        hand[RATE], hand[RAMP] = self._rate / scale, RAMP_S * scale
        hand[LIMIT_RATE], hand[FADE] = NEARING_RATE / scale, FADE_S
        joints[GAIN], joints[OFFSET] = synergy.gains[0], synergy.offsets[0]
        joints[SLOPE] = synergy.slopes[0] / scale
        law = Law(hand, joints)
        if not state.moving[VELOCITY:].any():
            return law
        hand[CLOCK] = (
            self._clock(law, state) if candidate.phase is None else candidate.phase * scale
        )
        return self.begun(law, state)

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
        hand, joints = law.hand.copy(), law.joints.copy()
        # what fades so decelerates by 1/e of its speed a time constant: half of what may be
        hand[FADE] = max(FADE_S, 2.0 / np.e * float(np.max(np.abs(rest) / most)))
        joints[CARRIED:] = rest, bend
        return Law(hand, joints)

    def _velocity(self, law: Law, state: State, q: FloatArray, t: float) -> FloatArray:
        velocity = np.empty(q.size)
        settings = optimiser_settings(self.ik)
        seen = q + state.sensed[OFF]
        controller_velocity(self.arm.chain.arrays, settings, law, seen, q, t, velocity)
        return velocity

    def _clock(self, law: Law, state: State) -> float:
        """The earliest time of phi at which the controller is nearest to the present velocity.

        An arm at rest begins anew, and so does one that moves elsewhere.
        """
        slopes, offsets, ramp = law.joints[SLOPE], law.joints[OFFSET], law.hand[RAMP]
        ready = Law(law.hand.copy(), law.joints.copy())
        ready.hand[[RAMP, LIMIT_RATE]] = 0.0, np.inf
        ready.joints[[SLOPE, OFFSET]] = [[0.0], [-np.inf]]
        full = self._velocity(ready, state, state.moving[POSTURE], 0.0)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            late = np.where(np.isfinite(offsets), (offsets + _SATURATED) / slopes, 0.0)
            clocks = np.linspace(0.0, max(float(late.max()), ramp), _CLOCKS)
            phi = 1.0 / (1.0 + np.exp(offsets - clocks[:, None] * slopes))
        x = np.minimum(clocks / ramp, 1.0)
        share = phi * (x**3 * (10.0 - 15.0 * x + 6.0 * x**2))[:, None]
        gap = ((state.moving[VELOCITY] - share * full) ** 2).sum(axis=1)
        return float(clocks[int(np.argmin(gap))])


def _goes_on(going: Going, goal: FloatArray, hand: FloatArray) -> bool:
    """Whether a new target belongs to the reach that is on its way."""
    then = going.planned
    shift = float(np.linalg.norm(goal - then.law.target))
    streamed = going.elapsed <= STREAM_S and shift <= STREAM_M
    near = shift <= SAME_REACH * float(np.linalg.norm(goal - hand))
    return (near or streamed) and float(np.linalg.norm(goal - then.chosen_for)) <= SAME_PLACE
