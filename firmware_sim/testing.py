"""Simulators for tests: one in a process of its own, and one on a stepped clock."""

from __future__ import annotations

import select
import subprocess
import sys
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

from firmware_sim.bus import Bus, Transmission
from firmware_sim.clock import SteppedClock
from firmware_sim.errors import SimulatorStartError

_START_PATIENCE = 10.0
_STOP_PATIENCE = 5.0


class SimulatorProcess:
    """A simulator running in a process of its own.

    Parameters
    ----------
    arguments : str
        Of the command ``firmware-sim``.

    Raises
    ------
    SimulatorStartError
        If it does not offer a port within 10 s.
    """

    def __init__(self, *arguments: str) -> None:
        command = [sys.executable, "-m", "firmware_sim", *arguments, "--exit-with-stdin"]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.port = self._first_line()
        if not self.port:
            raise SimulatorStartError(f"no port from {' '.join(command)}", self.stop())

    def _first_line(self) -> str:
        stdout = self.process.stdout
        if stdout is None or not select.select([stdout], [], [], _START_PATIENCE)[0]:
            return ""
        return stdout.readline().strip()

    def stop(self) -> int:
        """End it, and return its exit status; may be called twice."""
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                pipe.close()
        try:
            return self.process.wait(_STOP_PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()


@contextmanager
def running(*servos: str, arguments: tuple[str, ...] = ()) -> Iterator[str]:
    """Run a simulator for as long as a ``with`` block lasts.

    Parameters
    ----------
    servos : str
        ``MODEL:ID`` each; none if `arguments` name an arm or a rig.
    arguments : tuple of str
        More arguments of the command, such as ``("--baud", "1000000")``.

    Yields
    ------
    str
        The port's path.
    """
    chosen = ("--servo", *servos) if servos else ()
    simulator = SimulatorProcess(*chosen, *arguments)
    try:
        yield simulator.port
    finally:
        simulator.stop()


class SteppedPort:
    """A serial port to a bus in the same process, on a clock that moves only by waiting.

    The same requests at the same times give the same bytes, however slow the machine.

    Parameters
    ----------
    bus : Bus
        The servos.
    clock : SteppedClock
        Their time.
    baud_rate : float
        The client's, bit/s.
    """

    def __init__(self, bus: Bus, clock: SteppedClock, baud_rate: float) -> None:
        self.bus = bus
        self.clock = clock
        self.baud_rate = baud_rate
        self._due: deque[Transmission] = deque()
        self._arrived = bytearray()

    def write(self, data: bytes) -> None:
        """Send bytes; no time passes."""
        self._due += self.bus.receive(data, self.clock.now(), self.baud_rate)

    def in_waiting(self) -> int:
        """How many bytes have arrived by now."""
        while self._due and self._due[0].due <= self.clock.now():
            self._arrived += self._due.popleft().data
        return len(self._arrived)

    def read(self, size: int, timeout: float) -> bytes:
        """Return up to `size` bytes, waiting for them for at most `timeout` s."""
        deadline = self.clock.now() + timeout
        while self.in_waiting() < size and self._due and self._due[0].due <= deadline:
            self.clock.advance_to(self._due[0].due)
        if self.in_waiting() < size:
            self.clock.advance_to(deadline)
        taken = bytes(self._arrived[:size])
        del self._arrived[:size]
        return taken

    def exchange(self, request: bytes) -> bytes:
        """Send a request, wait until all answers have left the wire, and return them."""
        self.write(request)
        self.clock.advance_to(self.bus.wire_free)
        return self.read(self.in_waiting(), 0.0)
