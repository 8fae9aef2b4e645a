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
from armsyn.driver.joints import Health, JointState
from armsyn.driver.log import StreamLog
from armsyn.driver.path import Path, PathTime
from armsyn.driver.signals import StopRequests
from armsyn.driver.watch import ArmWatch, WatchSettings
from armsyn.errors import ArmFaultError, CommandFaultError
from armsyn.safety import check_command

FloatArray = NDArray[np.float64]
OnTick = Callable[[float, float], None]
"""Called after each tick with path time and the path's duration, s; must return quickly."""

HEALTH_INTERVAL = 0.25
"""Seconds in which the slow check of torque and hardware error visits every servo once."""

REST_AFTER = 0.02
"""Seconds of stall after which the stream starts from rest again."""

SHORTEST_RAMP = 0.2
"""Seconds of the shortest deceleration along the path."""

LONGEST_SETTLING = 0.5
"""Seconds that the stream waits at its end for the arm to arrive; if it does not, an event says
which joint stands how far off its goal."""

SETTLED_TICKS = 10
"""Ticks in a row at its goal and at rest after which the arm has arrived."""


class ServoLink(Protocol):
    """What a stream needs of the arm; `armsyn.driver.joints.JointGroup` is one."""

    def exchange(self, command: FloatArray) -> JointState:
        """Send goals, shape (n,), rad, and return the joints' state."""
        ...

    def read_health(self, row: int) -> Health | None:
        """Torque and hardware error of one joint's servo; None when it did not answer."""
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
        Where the goals stand, rad; afterwards the last goals sent.
    log : StreamLog
    stops : StopRequests
    clock : Clock
    on_tick : callable, optional

    Attributes
    ----------
    measured : array, shape (n,)
        Where the arm was last seen, rad.
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
    ticks: int = 0
    missed_ticks: int = 0

    def __post_init__(self) -> None:
        n = self.commanded.size
        self.measured = np.full(n, np.nan)
        self.begin()
        self._health_every = max(1, round(HEALTH_INTERVAL / self.settings.period / n))

    def begin(self) -> None:
        """Let the time line begin now; what was made ready before does not count as silence."""
        self._start = self._next = self._last_sent = self.clock.now()
        self.watch = ArmWatch(self.settings, self._start)

    def note(self, text: str) -> None:
        """Keep an event in the log."""
        self.log.note(self.clock.now() - self._start, text)

    def follow(self, path: Path, *, may_stop: bool = True) -> Outcome:
        """Stream a path from its start, and wait at its end for the arm to arrive.

        Parameters
        ----------
        path : Path
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
        path_time = PathTime()
        self.watch.settled_ticks = 0
        self._next = max(self._next, self.clock.now())
        settling = 0.0
        while True:
            stall = self._wait_for_tick()
            if self.stops.count > 1:
                return Outcome.ABORTED
            self._pace(path, path_time, stall, stop=may_stop and self.stops.count == 1)
            self._tick(path.at(path_time.advance(self.settings.period)))
            if self.on_tick is not None:
                self.on_tick(path_time.now, path.duration)
            if path_time.stopped or path_time.now >= path.duration:
                settling += self.settings.period
                settled = self.watch.settled_ticks >= SETTLED_TICKS
                if settled or settling >= LONGEST_SETTLING:
                    if not settled:
                        self._note_miss()
                    return Outcome.STOPPED if path_time.stopping else Outcome.ARRIVED

    def _note_miss(self) -> None:
        miss = np.abs(self.measured - self.commanded)
        joint = int(np.argmax(miss))
        self.note(
            f"not at rest on its goals after {LONGEST_SETTLING:g} s: stands {miss[joint]:.3f} rad"
            f" off its goal at {self.settings.limits.names[joint]}"
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
        if self.ticks and silence > self.longest_stall:
            raise ArmFaultError(
                f"the host stalled for {silence:.3f} s, and the servos' watchdog stops them after"
                f" {self.longest_stall:.3f} s: run it on a quieter machine, or more slowly"
            )
        return missed * period

    def _pace(self, path: Path, path_time: PathTime, stall: float, *, stop: bool) -> None:
        """Let path time slow down for a stop, or start from rest after a stall."""
        if path_time.stopping or not (stop or stall > REST_AFTER):
            return
        # half of the acceleration that the joints may have; the path itself needs some, too
        speed = path.speed_at(path_time.now, self.settings.period)
        ramp = max(SHORTEST_RAMP, 2.0 * float(np.max(speed / self.max_acceleration)))
        if stop:
            self.note("asked to stop: decelerating")
            path_time.stop(ramp)
        else:
            self.note(f"the host stalled for {stall:.3f} s: starting from rest again")
            path_time.resume_from_rest(ramp)

    def _tick(self, command: FloatArray) -> None:
        refusal = check_command(command, self.commanded, self.settings.limits)
        if refusal is not None:
            raise CommandFaultError(
                f"{refusal}: the motion went wrong on its way and was stopped; plan it again",
                refusal.joint,
                refusal.value,
                refusal.limit,
            ) from refusal
        self._last_sent = self.clock.now()
        state = self.link.exchange(command)
        before, self.commanded = self.commanded, command
        self.measured[:] = state.position
        self.ticks += 1
        now = self.clock.now()
        self.watch.update(now, before, command, state)
        health_fault = self._check_health(state)
        self.log.append(self._last_sent - self._start, command, state, self.watch.hardware_error)
        fault_found = health_fault or self.watch.fault(now, command, state)
        if fault_found is not None:
            raise fault_found

    def _check_health(self, state: JointState) -> ArmFaultError | None:
        """Ask a servo that has its alert bit set, else every now and then the next in turn."""
        if state.alert.any():
            row = int(np.argmax(state.alert))
            return self.watch.health_fault(
                row, self.link.read_health(row)
            ) or self.watch.alert_fault(row)
        turn, rest = divmod(self.ticks, self._health_every)
        if rest:
            return None
        row = turn % self.commanded.size
        return self.watch.health_fault(row, self.link.read_health(row))
