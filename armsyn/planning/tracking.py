"""Following targets that change while the arm moves: the setpoints of a stream.

What the arm measures closes the loop as in a Smith predictor (Smith 1957; Miall et al., *J. Mot.
Behav.* 25, 1993, of the cerebellum): the hand is judged by the posture commanded plus what the
arm has been standing off it, a servo's known lag taken off; to judge it by the late measurement
itself would let a gain of 50 per second oscillate.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.kernels.following import POSTURE
from armsyn.kernels.ticking import tick
from armsyn.planning.posing import HandOrientation
from armsyn.planning.tracking_ahead import Following, Foresight, Moment, turned
from armsyn.planning.tracking_arriving import ARRIVED_M, SETTLE_S, Measured, looked
from armsyn.planning.tracking_begin import STEP_S
from armsyn.planning.tracking_plan import TOLERANCE_M, LawPlanner
from armsyn.planning.tracking_state import Aim, Arrival, at_rest, seen

FloatArray = NDArray[np.float64]

CORRECTION_S = 0.1
"""Time constant with which it is learned how far a resting arm stands off its commands, s."""

LEAD_S = 0.02
"""How far ahead the first try plans the moment at which the arm turns to a new target, s."""

LONGEST_LEAD_S = 0.16
"""The same for a busy machine: each planning that was late doubles it."""

_TRIES = 4


def _nobody(_: Arrival) -> None:
    return


@dataclass
class ReachTracker:
    """Reaches for targets one after the other, each from wherever the last one has come to.

    `setpoint` belongs to the stream, `aim` to one other thread (or the same).

    Parameters
    ----------
    planner : LawPlanner
    start : array, shape (n,)
        Posture of the arm, at rest, rad.
    on_end : callable
        Called with each `Arrival`, in the stream (or by `aim`); must return at once.
    earliest : float
        Before this time of the stream the arm turns to no target, s: a driver that takes up
        setpoints gradually would add to their accelerations.
    """

    planner: LawPlanner
    start: FloatArray
    on_end: Callable[[Arrival], None] = _nobody
    earliest: float = 0.0
    _moment: Moment = field(init=False)
    _next: deque[Aim] = field(init=False, default_factory=deque)
    _finishing: bool = field(init=False, default=False)

    def __post_init__(self) -> None:
        self.planner.prepare()
        chain = self.planner.arm.chain
        self._moment = Moment(0.0, at_rest(np.clip(self.start, chain.lower, chain.upper)), None)
        self._arm = self.planner.guarded
        self._foresight = Foresight(self._arm)
        self._lock = threading.Lock()
        self._lead = LEAD_S

    @property
    def now(self) -> float:
        """Time of the stream, s."""
        return self._moment.t

    @property
    def at_rest(self) -> bool:
        """Whether there is no target left to arrive at."""
        with self._lock:  # between being taken from the queue and being followed it is neither
            following = self._moment.following
            return not self._next and (following is None or following.settled)

    def finish(self) -> None:
        """Let the stream end once the last target is reached."""
        self._finishing = True

    def aim(
        self,
        target: ArrayLike,
        at: float = 0.0,
        tag: Any = None,
        *,
        orientation: HandOrientation | None = None,
    ) -> Aim:
        """Turn to a target, from where the arm will be then; the last target that stands wins.

        Parameters
        ----------
        target : array_like, shape (3,)
            m, base frame.
        at : float
            When to turn to it, s of the stream; as soon as it is planned where that is over.
        tag : object
            Kept in the `Aim`.
        orientation : HandOrientation, optional
            How the hand is to be turned there.

        Returns
        -------
        Aim

        Raises
        ------
        InputError, UnreachableError, CollisionError
            As `LawPlanner.plan`; the arm goes on to the target that it had.
        """
        for left in reversed(range(_TRIES)):
            with self._lock:
                moment, queued = self._moment, tuple(self._next)
            begin = max(at, moment.t + self._lead, self.earliest)
            going, state = self._foresight.state_at(moment, queued, begin)
            planned = self.planner.plan(state, target, going, orientation=orientation)
            aim = Aim(planned, begin, tag)
            with self._lock:
                late = self._moment.t >= begin
                if not late or not left:
                    passed = self._put_in(aim)
                    break
            self._lead = min(2.0 * self._lead, LONGEST_LEAD_S)  # planning took longer than that
        self._lead = max(0.9 * self._lead, LEAD_S)
        for other in passed:
            self.on_end(self._replaced(other, moment))
        return aim

    def _put_in(self, aim: Aim) -> list[Aim]:
        """Queue an aim behind those that begin earlier; returns the others."""
        passed = [other for other in self._next if other.begin >= aim.begin]
        self._next = deque(other for other in self._next if other.begin < aim.begin)
        self._next.append(aim)
        return passed

    def setpoint(self, t: float, state: Measured) -> FloatArray | None:
        """Posture for a time of the stream, from what the joints measured last.

        Parameters
        ----------
        t : float
            s; goes on from call to call.
        state : Measured

        Returns
        -------
        array, shape (n,), or None
            rad, not to be written to; None once `finish` was called and the last target is
            reached.
        """
        before = self._moment
        span = t - before.t
        if span <= 0.0:
            return np.asarray(before.state[POSTURE])
        following = self._turned(before) if self._next else before.following
        idle = following is None or following.settled
        if self._finishing and idle and not self._next:
            return None
        now = before.state
        if following is not None:
            now, following.distance, fastest = tick(
                self._arm,
                following.law.hand,
                following.law.joints,
                now,
                state.position,
                state.fresh,
                before.t - following.since,
                span,
                STEP_S,
                0.0 if following.settled else 1.0 / CORRECTION_S,
            )
            if not following.settled:
                near = following.distance <= ARRIVED_M and 0.1 * fastest <= TOLERANCE_M
                following.near_for = following.near_for + span if near else 0.0
                if following.near_for >= SETTLE_S or t > following.patience:
                    self._look(following, state, now, t)
        self._moment = Moment(t, now, following)
        return np.asarray(now[POSTURE])

    def _turned(self, before: Moment) -> Following | None:
        """Turn to the next target if it is time to."""
        following = before.following
        with self._lock:
            aims = []
            while self._next and self._next[0].begin <= before.t + 1e-9:
                aims.append(self._next.popleft())
            if not aims:
                return following
            now = turned(aims[-1], before.t)
            self._moment = before._replace(following=now)
        for aim in aims[:-1]:  # the host was late for them
            self.on_end(self._replaced(aim, before))
        if following is not None and not following.settled:
            if following.aim.planned.task.orientation is not None:
                self.on_end(self._replaced(following.aim, before))
            else:  # as the last tick knew it: to work it out here takes longer than a tick
                told = Arrival(following.aim, before.t, following.distance, 0.0, "replaced")
                self.on_end(told)
        return now

    def _look(self, following: Following, state: Measured, now: FloatArray, t: float) -> None:
        arrival = looked(following, state, seen(now), t, self.planner.arm.chain)
        if arrival is not None:
            self.on_end(arrival)

    def _replaced(self, aim: Aim, now: Moment) -> Arrival:
        """End of an aim whose target another takes the place of."""
        left = aim.planned.task.errors(self.planner.arm.chain, seen(now.state))
        return Arrival(aim, now.t, *left, "replaced")
