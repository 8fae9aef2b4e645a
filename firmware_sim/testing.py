"""Simulators for tests: one in a process of its own, and one on a stepped clock."""

from __future__ import annotations

import errno
import select
import subprocess
import sys
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

from firmware_sim.bus import Bus, Transmission
from firmware_sim.clock import SteppedClock
from firmware_sim.errors import SimulatorStartError
from firmware_sim.simulation import Simulation, queue

_START_PATIENCE = 60.0
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
        If it does not offer a port within 60 s: the first start on a machine compiles the physics.
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
    """A serial port to a simulation in the same process, on a clock that moves only by waiting.

    The same requests at the same times give the same bytes, however slow the machine.

    Parameters
    ----------
    simulation : Simulation or Bus
        The servos, with or without faults.
    clock : SteppedClock
        Their time.
    baud_rate : float
        The client's, bit/s.

    Raises
    ------
    OSError
        From `write`, `in_waiting` and `read`, while the simulation is unplugged.
    """

    def __init__(self, simulation: Simulation | Bus, clock: SteppedClock, baud_rate: float) -> None:
        if not isinstance(simulation, Simulation):
            simulation = Simulation(simulation, start=clock.now())
        self.simulation = simulation
        self.clock = clock
        self.baud_rate = baud_rate
        self._due: deque[Transmission] = deque()
        self._arrived = bytearray()

    @property
    def bus(self) -> Bus:
        """The servos' bus."""
        return self.simulation.bus

    def write(self, data: bytes) -> None:
        """Send bytes; no time passes."""
        self._check_plug()
        now = self.clock.now()
        queue(self._due, self.simulation.receive(data, now, self.baud_rate))

    def in_waiting(self) -> int:
        """How many bytes have arrived by now."""
        self._check_plug()
        while self._due and self._due[0].due <= self.clock.now():
            self._arrived += self._due.popleft().data
        return len(self._arrived)

    def read(self, size: int, timeout: float) -> bytes:
        """Return up to `size` bytes, waiting for them for at most `timeout` s."""
        deadline = self.clock.now() + timeout
        while self.in_waiting() < size and self.clock.now() < deadline:
            self.wait_until(min(deadline, self._due[0].due if self._due else deadline))
        taken = bytes(self._arrived[:size])
        del self._arrived[:size]
        return taken

    def exchange(self, request: bytes) -> bytes:
        """Send a request, wait until all answers have left the wire, and return them."""
        self.write(request)
        self.wait_until(max([self.simulation.wire_free, *(sent.due for sent in self._due)]))
        return self.read(self.in_waiting(), 0.0)

    def wait_until(self, when: float) -> None:
        """Let time pass until `when`, s, with all that happens by itself until then."""
        event = self.simulation.next_event
        while event is not None and event <= when:
            self.clock.advance_to(event)
            queue(self._due, self.simulation.advance(self.clock.now()))
            following = self.simulation.next_event
            if following is not None and following <= event:
                break
            event = following
        self.clock.advance_to(when)

    def _check_plug(self) -> None:
        event = self.simulation.next_event
        if event is not None and event <= self.clock.now():
            queue(self._due, self.simulation.advance(self.clock.now()))
        if self.simulation.unplugged:
            self._due.clear()
            self._arrived.clear()
            raise OSError(errno.EIO, "the simulated port is unplugged")
