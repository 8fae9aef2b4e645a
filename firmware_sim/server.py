"""The loop that joins a bus to a port in real time.

It sleeps until something arrives or falls due; bytes leave at absolute times on the monotonic
clock.
"""

from __future__ import annotations

import gc
import os
import select
import signal
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FrameType

from firmware_sim.bus import Bus, Transmission
from firmware_sim.clock import Clock, RealClock
from firmware_sim.pty_port import PtyPort

_HOUSEKEEPING = 0.02
"""How often moving servos are brought up to date while nobody asks, s."""

_BACKLOG = 0.05
"""How far the wire may be behind before no more is read, s: then the client's writes block, as they
do at a real port, and nothing piles up here."""

_SPIN = 40.0e-6
"""How long before a due time sleeping ends and waiting begins, s: a sleep ends about this late."""

_BATCH = 250.0e-6
"""Answers that fall due within this time leave together, at the last one's time, s: as behind an
adapter, and with half the work at 4 Mbaud."""

_TIMER_SLACK_NS = 1000


class Server:
    """One bus behind one port.

    Parameters
    ----------
    bus : Bus
        The servos.
    port : PtyPort
        Where clients come.
    stdin : int or None
        A descriptor whose end of file ends the loop.
    """

    def __init__(self, bus: Bus, port: PtyPort, stdin: int | None = None) -> None:
        self._bus = bus
        self._port = port
        self._stdin = stdin
        self._clock: Clock = RealClock()
        self._due: deque[Transmission] = deque()
        self._stopped = False
        self._wake_read, self._wake_write = os.pipe()
        os.set_blocking(self._wake_write, False)

    def run(self, announce: Callable[[], None]) -> None:
        """Serve until SIGINT, SIGTERM, or the end of the watched standard input.

        Parameters
        ----------
        announce : callable
            Called once everything is ready, so that whoever hears it may stop the loop at once.
        """
        _sharpen_timer()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._stop)
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
        backlog = self._bus.wire_free - self._clock.now() - _BACKLOG
        watched = [self._wake_read]
        if self._stdin is not None:
            watched.append(self._stdin)
        if backlog <= 0.0:
            watched.append(self._port.master)
        ready = select.select(watched, [], [], self._patience(backlog))[0]
        if self._port.master in ready:
            self._listen()
        if self._stdin in ready and not os.read(self._stdin, 4096):
            self._stopped = True
        self._speak()
        if not ready:
            self._bus.advance(self._clock.now())

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopped = True

    def _patience(self, backlog: float) -> float | None:
        """Return how long to sleep, s; None for as long as nothing comes."""
        if self._due:
            moment, count = self._next_batch()
            return max(0.0, moment - self._margin(count) - self._clock.now())
        if backlog > 0.0:
            return backlog
        return _HOUSEKEEPING if self._bus.moving else None

    def _next_batch(self) -> tuple[float, int]:
        """Return when to speak next, s, and how many answers leave then."""
        end = self._due[0].due + _BATCH
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
        chunk = self._port.read()
        if chunk:
            now = self._clock.now()
            self._due += self._bus.receive(chunk, now, self._port.baud_rate)

    def _speak(self) -> None:
        """Send what is due, waiting for what is about to be."""
        while self._due:
            moment, count = self._next_batch()
            if moment - self._clock.now() > self._margin(count):
                return
            while self._clock.now() < moment:
                pass
            self._port.write(b"".join(self._due.popleft().data for _ in range(count)))


def _sharpen_timer() -> None:
    """Ask Linux to end sleeps within a microsecond; where it will not, they end 50 us late."""
    with suppress(OSError):
        Path("/proc/self/timerslack_ns").write_text(str(_TIMER_SLACK_NS))
