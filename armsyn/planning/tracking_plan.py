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
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import CollisionError, InputError, RefusedMotionError, UnreachableError
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

FADE_S = 0.08
"""Least time constant with which a carried velocity fades, s: of what people have left of an
abandoned movement little remains after 0.3 s."""

LONGEST_S = 8.0
"""Longest reach before slowing, s, as of `armsyn.planning.reach`."""

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
    synergy : Synergies
    chosen_for : array, shape (3,)
        The target that the synergy was chosen for, m.
    path : array, shape (frames, n)
        What comes of it if nothing else happens, `STEP_S` apart, rad.
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
    synergy: Synergies
    chosen_for: FloatArray
    path: FloatArray
    duration: float
    learned: str
    rank: int
    time_scale: float


class _Candidate(NamedTuple):
    """A synergy with which a target may be reached for, and kappa so far.

    `phase` is the time of phi at which it goes on, over kappa, s; None for a new reach.
    """

    name: str
    rank: int
    synergy: Synergies
    scale: float
    chosen_for: FloatArray
    phase: float | None = None


class Going(NamedTuple):
    """What is followed when a new target comes.

    Attributes
    ----------
    planned : PlannedLaw
    elapsed : float
        Since it began, s.
    """

    planned: PlannedLaw
    elapsed: float


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
        out_of_reach(self.arm, rest, hand)

    def bounds(self, share: float) -> Bounds:
        """A share of the arm's speeds and accelerations."""
        arm = self.arm
        return Bounds(share * arm.max_velocity, share * arm.max_acceleration, arm.max_jerk)

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
                if missed == np.inf and (beyond := out_of_reach(self.arm, state.moving.q, goal)):
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
    ) -> Iterator[_Candidate]:
        """Synergies that may serve, the likeliest first."""
        hand = self.arm.chain.forward(state.moving.q + state.correction).tip
        if going is not None and _goes_on(going, goal, hand):
            then = going.planned
            phase = (then.law.clock + going.elapsed) / then.time_scale
            yield _Candidate(
                then.learned, then.rank, then.synergy, then.time_scale, then.chosen_for, phase
            )
        nearest = self.library.nearest(hand, goal, self.ik, self.model)
        for rank, (learned, chosen) in enumerate(nearest):
            yield _Candidate(learned.name, rank, self.library.synergy(chosen), 1.0, goal)

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
        self, state: State, goal: FloatArray, candidate: _Candidate
    ) -> tuple[_Candidate, Law]:
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
        n = self.arm.rest.size
        steps = int(LONGEST_S * (self._rate / law.rate) / STEP_S)
        path = np.empty((steps if guarded else 0, n))
        made, distance, excess = follow(
            self.arm.chain.arrays,
            optimiser_settings(self.ik),
            law,
            self.bounds(GUARD if guarded else HEADROOM),
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

    def _law(self, state: State, goal: FloatArray, candidate: _Candidate) -> Law:
        """A law that begins where the arm is as fast as it is."""
        synergy, scale = candidate.synergy, candidate.scale
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
        phase = candidate.phase
        clock = self._clock(still, state) if phase is None else phase * scale
        return self.begun(still._replace(clock=clock), state)

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
        # what fades so decelerates by 1/e of its speed a time constant: half of what may be
        fade = max(FADE_S, 2.0 / np.e * float(np.max(np.abs(rest) / most)))
        return law._replace(carried=np.array([rest, bend]), fade=fade)

    def _velocity(self, law: Law, state: State, q: FloatArray, t: float) -> FloatArray:
        velocity = np.empty(q.size)
        settings = optimiser_settings(self.ik)
        seen = q + state.correction
        controller_velocity(self.arm.chain.arrays, settings, law, seen, q, t, velocity)
        return velocity

    def _clock(self, law: Law, state: State) -> float:
        """The earliest time of phi at which the controller is nearest to the present velocity.

        An arm at rest begins anew, and so does one that moves elsewhere.
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


def _goes_on(going: Going, goal: FloatArray, hand: FloatArray) -> bool:
    """Whether a new target belongs to the reach that is on its way."""
    then = going.planned
    shift = float(np.linalg.norm(goal - then.law.target))
    streamed = going.elapsed <= STREAM_S and shift <= STREAM_M
    near = shift <= SAME_REACH * float(np.linalg.norm(goal - hand))
    return (near or streamed) and float(np.linalg.norm(goal - then.chosen_for)) <= SAME_PLACE
