"""The loop that joins a simulation to a port in real time.

It sleeps until something arrives or falls due; bytes leave at absolute times on the monotonic
clock. What else is to be done (a trace to write, a table to show) is done in small pieces while
nothing is about to leave.
"""

from __future__ import annotations

import gc
import os
import select
import signal
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Protocol

from firmware_sim.clock import Clock, RealClock
from firmware_sim.command.pty_port import PtyPort
from firmware_sim.command.stopping import catch_stops
from firmware_sim.simulation import Simulation, queue
from firmware_sim.wire.bus import Transmission
from firmware_sim.wire.line import BITS_PER_BYTE

_HOUSEKEEPING = 0.02
"""How often moving servos are brought up to date while nobody asks, s."""

_BACKLOG = 0.05
"""How far the wire may be behind before no more is read, s: then the client's writes block, as they
do at a real port, and nothing piles up here."""

_CHUNK = 0.25
"""How long the bytes that are read at once may take on the wire, s: at 50 bit/s no more than one is
taken, so that what a client sends after it has changed the rate does not wait for minutes."""

_LAST_WORDS = 0.2
"""How long what a client sent before it closed the port may take on the wire, s; the rest is lost.
A driver that lets go of its servos at the very end is heard."""

_PAUSE = 0.5e-3
"""How long nothing may be due for a chore to be done, s."""

_CHORES_WAIT = 0.05
"""How long chores wait at most for such a pause, s: a client that pipelines leaves none."""

_SPIN = 40.0e-6
"""How long before a due time sleeping ends and waiting begins, s: a sleep ends about this late."""

_BATCH = 400.0e-6
"""Answers that fall due within this time leave together, at the last one's time, s: as behind an
adapter, and with half the work at 4 Mbaud."""

_TIMER_SLACK_NS = 1000


class Chore(Protocol):
    """Something to be done in small pieces while the wire is idle."""

    @property
    def next_due(self) -> float:
        """When there is something to do, s; infinity for not before something else happens."""

    def work(self, now: float) -> None:
        """Do a piece of it that takes a fraction of a millisecond, at a time in s."""


class Guest(Protocol):
    """Somebody who listens at descriptors of their own, such as a control socket."""

    def descriptors(self) -> Sequence[int]:
        """Return what to watch for something to read."""

    def serve(self, ready: Sequence[int]) -> None:
        """Deal with the descriptors that have something to read."""


class Server:
    """One simulation behind one port.

    Parameters
    ----------
    simulation : Simulation
        The servos and what goes wrong with them.
    port : PtyPort
        Where clients come.
    stdin : int or None
        A descriptor whose end of file ends the loop.
    guests : sequence of Guest
        Who else is listened to.
    chores : sequence of Chore
        What is done while the wire is idle.
    """

    def __init__(
        self,
        simulation: Simulation,
        port: PtyPort,
        stdin: int | None = None,
        guests: Sequence[Guest] = (),
        chores: Sequence[Chore] = (),
    ) -> None:
        self._simulation = simulation
        self._port = port
        self._stdin = stdin
        self._guests = tuple(guests)
        self._chores = tuple(chores)
        self._clock: Clock = RealClock()
        self._due: deque[Transmission] = deque()
        self._next_chore = 0
        self._chored = 0.0
        self._baud_rate = 0
        self._stopped = False
        self._wake_read, self._wake_write = os.pipe()
        os.set_blocking(self._wake_write, False)
        self._always = [self._wake_read] if stdin is None else [self._wake_read, stdin]

    def run(self, announce: Callable[[], None]) -> None:
        """Serve until SIGINT, SIGTERM, SIGHUP, or the end of the watched standard input.

        Parameters
        ----------
        announce : callable
            Called once everything is ready, so that whoever hears it may stop the loop at once.
        """
        _sharpen_timer()
        catch_stops(self._stop)
        signal.set_wakeup_fd(self._wake_write, warn_on_full_buffer=False)
        gc.freeze()  # what start-up made need not be looked at again in the middle of an answer
        try:
            announce()
            while not self._stopped:
                self._turn()
        finally:
            signal.set_wakeup_fd(-1)
            os.close(self._wake_read)
            os.close(self._wake_write)

    def _turn(self) -> None:
        """Sleep until there is something to do, and do it."""
        now = self._clock.now()
        backlog = self._simulation.wire_free - now - _BACKLOG
        watched = self._always
        if self._port.plugged:
            watched = [*watched, *self._port.comings]
            if backlog <= 0.0:
                watched.append(self._port.master)
            else:
                self._follow_rate(now)
        for guest in self._guests:
            watched = [*watched, *guest.descriptors()]
        ready = select.select(watched, [], [], self._patience(now, backlog))[0]
        if ready:
            self._hear(ready)
        else:
            queue(self._due, self._simulation.advance(self._clock.now()))
        self._follow_plug()
        self._speak()
        self._do_chores()

    def _hear(self, ready: list[int]) -> None:
        if not set(self._port.comings).isdisjoint(ready) and self._port.left():
            self._hang_up()
        if self._port.master in ready:
            self._listen()
            if len(ready) == 1:
                return
        if self._stdin in ready and not os.read(self._stdin, 4096):
            self._stopped = True
        for guest in self._guests:
            guest.serve(ready)

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopped = True

    def _patience(self, now: float, backlog: float) -> float | None:
        """Return how long to sleep, s; None for as long as nothing comes."""
        wake = float("inf")
        if self._due:
            moment, count = self._next_batch(now)
            wake = moment - self._margin(count)
        elif self._simulation.moving:
            wake = now + _HOUSEKEEPING
        if self._may_do_chores(now):
            for chore in self._chores:
                wake = min(wake, chore.next_due)
        if backlog > 0.0:
            wake = min(wake, now + min(backlog, _BACKLOG))
        event = self._simulation.next_event
        if event is not None:
            wake = min(wake, event)
        return None if wake == float("inf") else max(0.0, wake - now)

    def _next_batch(self, now: float) -> tuple[float, int]:
        """Return when to speak next, s, and how many answers leave then; late ones go at once."""
        end = max(self._due[0].due + _BATCH, now)
        moment, count = 0.0, 0
        for transmission in self._due:
            if transmission.due > end:
                break
            moment = transmission.due
            count += 1
        return moment, count

    def _margin(self, count: int) -> float:
        """Return how long to wait awake, s: clients wait for the last answer, so it is sharp."""
        return _SPIN if count == len(self._due) else 0.0

    def _listen(self) -> None:
        now = self._clock.now()
        self._follow_rate(now)
        chunk = self._port.read(max(1, int(_CHUNK * self._baud_rate / BITS_PER_BYTE)))
        if self._port.left():
            self._hang_up(chunk)
        else:
            self._take(chunk, now)

    def _take(self, chunk: bytes, now: float) -> None:
        """Let the servos hear bytes; at 0 bit/s a line is hung up, and nothing gets through."""
        if chunk and self._baud_rate:
            queue(self._due, self._simulation.receive(chunk, now, self._baud_rate))

    def _follow_rate(self, now: float) -> None:
        """Forget bytes on the wire when the client listens at another rate."""
        rate = self._port.baud_rate
        if rate != self._baud_rate:
            self._baud_rate = rate
            self._due.clear()
            self._simulation.free_wire(now)

    def _hang_up(self, heard: bytes = b"") -> None:
        """Forget a client that has closed the port, but for its last words."""
        alone, words = self._port.let_in()
        self._port.forget_unread()
        now = self._clock.now()
        self._follow_rate(now)
        self._due.clear()
        self._simulation.hang_up(now)
        for chunk in (heard, *words):
            if not alone or self._simulation.wire_free < now + _LAST_WORDS:
                self._take(chunk, now)
        if alone:
            self._due.clear()
            self._simulation.hang_up(now)

    def _speak(self) -> None:
        """Send what is due, waiting for what is about to be."""
        while self._due:
            now = self._clock.now()
            moment, count = self._next_batch(now)
            if moment - now > self._margin(count):
                return
            while self._clock.now() < moment:
                pass
            data = b"".join(self._due.popleft().data for _ in range(count))
            if self._port.plugged:
                self._port.write(data)

    def _follow_plug(self) -> None:
        """Let the port be there, or not, as the simulation says."""
        self._port.follow(self._simulation.unplugged, self._simulation.forbidden)
        if self._due and not self._port.plugged:
            self._due.clear()

    def _may_do_chores(self, now: float) -> bool:
        """Return whether there is time enough, or chores have waited for long enough."""
        if not self._due or self._due[0].due - now > _PAUSE:
            return True
        return now - self._chored > _CHORES_WAIT

    def _do_chores(self) -> None:
        """Do a piece of one of the chores that are due, each in its turn."""
        now = self._clock.now()
        if not self._may_do_chores(now):
            return
        for place in range(len(self._chores)):
            turn = (self._next_chore + place) % len(self._chores)
            if self._chores[turn].next_due <= now:
                self._chores[turn].work(now)
                self._next_chore = turn + 1
                self._chored = now
                return


def _sharpen_timer() -> None:
    """Ask Linux to end sleeps within a microsecond; where it will not, they end 50 us late."""
    with suppress(OSError):
        Path("/proc/self/timerslack_ns").write_text(str(_TIMER_SLACK_NS))
