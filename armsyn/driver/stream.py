"""Streaming a path to an arm at a fixed rate: absolute deadlines, checks and a record each tick.

A tick that comes late is not made up for: whole ticks gone by are skipped and counted, and path
time does not jump over them, so the goals never do. After a longer stall the arm has come to rest
and starts from rest again.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from armsyn.driver.clock import Clock
from armsyn.driver.course import Course, Followable, PathCourse
from armsyn.driver.gravity import GoalLead
from armsyn.driver.joints import Health, JointState
from armsyn.driver.log import Level, StreamLog
from armsyn.driver.signals import StopRequests
from armsyn.driver.watch import SETTLED_SPEED, ArmWatch, WatchSettings
from armsyn.errors import ArmFaultError
from armsyn.safety import TickState, averaged_current, judge_tick, warm_joints

FloatArray = NDArray[np.float64]
OnTick = Callable[[float, float], None]
"""Called after each tick with path time and the path's duration, s; must return quickly."""

HEALTH_INTERVAL = 0.25
"""Seconds in which the slow checks have visited every servo: torque, errors, temperature. Slow
rates make several a tick, as far as the period has time for them."""

REST_AFTER = 0.02
"""Seconds of stall after which the stream starts from rest again."""

LONGEST_SETTLING = 0.5
"""Seconds that the stream waits at its end for the arm to arrive; if it does not, an event says
which joint stands how far off its goal."""

LONGEST_CORRECTION = 2.5
"""The same, where goals are corrected by what is measured."""

SETTLED_TICKS = 10
"""Ticks in a row at its goal and at rest after which the arm has arrived."""


class ServoLink(Protocol):
    """What a stream needs of the arm; `armsyn.driver.joints.JointGroup` is one."""

    def exchange(self, command: FloatArray) -> JointState:
        """Send goals, shape (n,), rad, and return the joints' state."""
        ...

    @property
    def polls(self) -> int:
        """How many slow checks there are."""
        ...

    def read_health(self, row: int) -> Health | None:
        """Torque and hardware error of one joint's servo; None when it did not answer."""
        ...

    def poll(self, turn: int) -> Health | None:
        """Make the slow check whose turn it is; None when there is no answer."""
        ...


class Outcome(enum.Enum):
    """How following a path ended."""

    ARRIVED = enum.auto()
    """At the path's end. How near the arm is to it, events and measured angles say."""
    STOPPED = enum.auto()
    """On the first request to stop, after a deceleration."""
    ABORTED = enum.auto()
    """On the second request: goals stay as they are."""


@dataclass
class Streamer:
    """Follows one path after another on one time line.

    Parameters
    ----------
    link : ServoLink
    settings : WatchSettings
    max_acceleration : array, shape (n,)
        Of the arm's joints, rad/s2.
    longest_stall : float
        Seconds without a command after which the servos have stopped themselves.
    commanded : array, shape (n,)
        The posture that the goals now stand for, rad; afterwards the last one wanted.
    log : StreamLog
    stops : StopRequests
    clock : Clock
    on_tick : callable, optional
    lead : GoalLead, optional
        What goals lead the wanted posture by, against gravity; without it they are the same.

    Attributes
    ----------
    measured : array, shape (n,)
        Where the arm was last seen, rad.
    sent : array, shape (n,)
        The last goals that the servos were sent, rad.
    ticks, missed_ticks : int
        Commands sent, and ticks skipped because the host was late.
    """

    link: ServoLink
    settings: WatchSettings
    max_acceleration: FloatArray
    longest_stall: float
    commanded: FloatArray
    log: StreamLog
    stops: StopRequests
    clock: Clock
    on_tick: OnTick | None = None
    lead: GoalLead | None = None
    ticks: int = 0
    missed_ticks: int = 0

    def __post_init__(self) -> None:
        n = self.commanded.size
        self.measured = np.full(n, np.nan)
        self.sent = self.commanded if self.lead is None else self.commanded + self.lead.lead
        self._state: JointState | None = None
        # currents count from 0: a short peak at the first tick is no load yet
        self._judged_by = TickState.at_rest(self.commanded)._replace(current=np.zeros(n))
        self._warm: set[str] = set()
        self.begin()
        self._polls_due, self._turn = 0.0, 0

    def begin(self) -> None:
        """Let the time line begin now; what was made ready before does not count as silence."""
        self._start = self._next = self._last_sent = self.clock.now()
        self.watch = ArmWatch(self.settings, self._start)

    def note(self, text: str, level: Level = "info") -> None:
        """Keep an event in the log."""
        self.log.note(self.clock.now() - self._start, text, level)

    def follow(self, path: Followable, *, may_stop: bool = True) -> Outcome:
        """Stream a path from its start; `run` with a course along it, which see.

        Parameters
        ----------
        path : Followable
            Starting where the goals stand.
        may_stop : bool
            As `run`.
        """
        course = PathCourse(path, self.max_acceleration, self.settings.period)
        return self.run(course, may_stop=may_stop)

    def run(self, course: Course, *, may_stop: bool = True) -> Outcome:
        """Stream a course from its start, and wait at its end for the arm to arrive.

        Parameters
        ----------
        course : Course
            Starting where the goals stand.
        may_stop : bool
            Whether the first request to stop decelerates; the second always aborts.

        Returns
        -------
        Outcome

        Raises
        ------
        CommandFaultError, FollowingError
            A command that must not be sent; an arm that does not follow.
        BusTimeoutError, BusError
            A servo silent for too long; too many lost commands.
        HardwareFaultError
            A servo reports an error or has lost its torque.
        ArmFaultError
            The host stalled for longer than the servos wait.
        PortLostError
            The port went away.
        """
        try:
            return self._stream(course, may_stop=may_stop)
        finally:
            self.stops.rest()

    def _stream(self, course: Course, *, may_stop: bool) -> Outcome:
        self.watch.settled_ticks = 0
        self._next = max(self._next, self.clock.now())
        settling, calm = 0.0, 0
        while True:
            stall = self._wait_for_tick()
            self.stops.beat()
            if self.stops.count > 1:
                return Outcome.ABORTED
            self._pace(course, stall, stop=may_stop and self.stops.count == 1)
            self._tick(course.advance(self._state))
            if self.on_tick is not None:
                self.on_tick(course.now, course.duration)
            if course.finished:
                settling += self.settings.period
                calm = calm + 1 if self._arrived() else 0
                longest = self._longest_settling(course)
                if calm >= SETTLED_TICKS or settling >= longest:
                    self._note_end(settling, arrived=calm >= SETTLED_TICKS)
                    return Outcome.STOPPED if course.stopping else Outcome.ARRIVED

    def _arrived(self) -> bool:
        """Whether the arm stands where it should; corrects its goals until it does."""
        state = self._state
        if self.lead is None or not self.lead.settings.active or state is None:
            return self.watch.settled_ticks > 0
        self.lead.correct(self.commanded, state)
        slow = bool((np.abs(state.velocity) < SETTLED_SPEED).all() and state.fresh.all())
        return self.lead.there and slow

    def _longest_settling(self, course: Course) -> float:
        """Seconds that the end of a course may take."""
        lead = self.lead
        if lead is None or not lead.settings.active or course.stopping:
            return LONGEST_SETTLING
        given_up = lead.content and not lead.there
        return LONGEST_SETTLING if given_up else LONGEST_CORRECTION

    def _note_end(self, settling: float, *, arrived: bool) -> None:
        names = self.settings.limits.names
        if self.lead is not None and self.lead.limited.any():
            name = names[int(np.argmax(self.lead.limited))]
            self.note(f"{name} sags: its goal cannot lead beyond its range", "warning")
        if not arrived:
            miss = np.abs(self.measured - self.commanded)
            row = int(np.argmax(miss))
            self.note(
                f"not at rest on its goals after {settling:.3g} s: stands {miss[row]:.3f} rad off"
                f" its goal at {names[row]}",
                "warning",
            )

    def _wait_for_tick(self) -> float:
        """Wait for the next deadline; returns the time of the whole ticks that were missed, s."""
        period = self.settings.period
        self.clock.sleep_until(self._next)
        now = self.clock.now()
        missed = int((now - self._next) / period)
        self._next += (missed + 1) * period
        self.missed_ticks += missed
        self.watch.missed(missed)
        silence = now - self._last_sent
        if silence > self.longest_stall:
            raise ArmFaultError(
                f"the host stalled for {silence:.3f} s, and the servos' watchdog stops them after"
                f" {self.longest_stall:.3f} s: run it on a quieter machine, or more slowly"
            )
        return missed * period

    def _pace(self, course: Course, stall: float, *, stop: bool) -> None:
        """Let the course slow down for a stop, or start from rest after a stall.

        After a stall a course that is to stop has stopped already.
        """
        if stall > REST_AFTER:
            stop = stop or course.stopping
            then = "stopped where it stands" if stop else "starting from rest again"
            self.note(f"the host stalled for {stall:.3f} s: {then}", "warning")
            self._judged_by.commands[:] = self.commanded
            (course.halt if stop else course.resume_from_rest)()
        elif stop and not course.stopping:
            self.note("asked to stop: decelerating")
            course.stop()

    def _tick(self, wanted: FloatArray) -> None:
        wanted = self._judged(wanted)
        goals = wanted if self.lead is None else self.lead.goals(wanted)
        self._last_sent = self.clock.now()
        state = self.link.exchange(goals)
        before, self.commanded, self.sent = self.commanded, wanted, goals
        self._state = state
        self.measured[:] = state.position
        self.ticks += 1
        now = self.clock.now()
        self.watch.update(now, before, wanted, state)
        self._remember(state)
        health_fault = self._check_health(state)
        self.log.append(
            self._last_sent - self._start, wanted, goals, state, self.watch.hardware_error
        )
        fault_found = health_fault or self.watch.fault(now)
        if fault_found is not None:
            raise fault_found

    def _judged(self, wanted: FloatArray) -> FloatArray:
        """The command as it may be sent; raises the fault where it must not be."""
        verdict = judge_tick(self._judged_by, wanted, self.settings.limits)
        if verdict.fault is not None:
            raise verdict.fault
        assert verdict.command is not None  # noqa: S101 - one of the two
        commands = self._judged_by.commands
        commands[:-1] = commands[1:]
        commands[-1] = verdict.command
        return verdict.command

    def _remember(self, state: JointState) -> None:
        """Keep what the next command is judged by."""
        self._judged_by = self._judged_by._replace(
            measured=state.position,
            speed=self.watch.speed,
            fresh=state.fresh,
            current=averaged_current(self._judged_by.current, state.current, self.settings.period),
            temperature=state.temperature,
            voltage=state.voltage,
        )

    def _check_health(self, state: JointState) -> ArmFaultError | None:
        """Ask a servo that has its alert bit set, else those whose turn it is."""
        if state.alert.any():
            row = int(np.argmax(state.alert))
            found = self.watch.poll_fault(self.link.read_health(row))
            return found or self.watch.alert_fault(row)
        each_tick = self.link.polls * self.settings.period / HEALTH_INTERVAL
        self._polls_due = min(self._polls_due + each_tick, float(self.link.polls))
        began, made = self.clock.now(), 0
        while self._polls_due >= 1.0 and (made == 0 or self._has_time_for_more(began, made)):
            health = self.link.poll(self._turn)
            self._turn, self._polls_due, made = self._turn + 1, self._polls_due - 1.0, made + 1
            self._warn_of_heat()
            problem = self.watch.poll_fault(health) or self.watch.silence_fault(health)
            if problem is not None:
                return problem
        return None

    def _has_time_for_more(self, began: float, made: int) -> bool:
        """Whether one more slow check, as long as those before, ends before the next tick."""
        now = self.clock.now()
        return now + (now - began) / made < self._next

    def _warn_of_heat(self) -> None:
        """Say once of each joint that it is nearly too hot."""
        for name in warm_joints(self._judged_by, self.settings.limits):
            if name not in self._warm:
                self._warm.add(name)
                row = self.settings.limits.names.index(name)
                limit = self.settings.limits.max_temperature[row]
                self.note(
                    f"{name} is {self._judged_by.temperature[row]:.0f} degrees Celsius hot, its"
                    f" servo stops at {limit:.0f}: let it rest soon",
                    "warning",
                )
