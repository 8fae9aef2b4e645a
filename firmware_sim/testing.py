"""Simulators for tests: in a process of their own on real ports, and on a stepped clock.

::

    with simulated("xm430-w350:1", baud=1_000_000, faults=["crc-error:probability=0.01"]) as arm:
        my_driver = MyDriver(arm.port)
        arm.inject("unplugged:for=2")
        arm.hands.turn({1: 3000})                   # as a person would, with the torque off

    port = stepped("xm430-w350:1", "ax-12a:2")      # no process, no real time
    port.exchange(b"...")
    MyDriver(SteppedSerial(port, timeout=0.1))      # for what takes pyserial's Serial

`firmware_sim.pytest_plugin` has both as fixtures.
"""

from __future__ import annotations

import select
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any

from firmware_sim.control.client import send
from firmware_sim.control.hands import Hands, positions_in
from firmware_sim.errors import SimulatorStartError
from firmware_sim.stepped import SteppedPort, stepped
from firmware_sim.stepped_serial import SteppedSerial

__all__ = [
    "Hands",
    "RunningSimulator",
    "SimulatorProcess",
    "SteppedPort",
    "SteppedSerial",
    "running",
    "simulated",
    "stepped",
]

_WORDS_KEPT = 100
"""Lines of standard error that are kept."""

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
        self._words: deque[str] = deque(maxlen=_WORDS_KEPT)
        own = () if "--no-table" in arguments else ("--no-table",)
        command = [sys.executable, "-m", "firmware_sim", *arguments, *own, "--exit-with-stdin"]
        # In a session of its own, so that Ctrl-C is for the tests alone.
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self._listener = Thread(target=self._listen, name="last words", daemon=True)
        self._listener.start()
        self.port = self._first_line()
        if not self.port:
            status = self.stop()
            raise SimulatorStartError(
                f"no port from {' '.join(command)}: {self.last_words or 'it said nothing'}", status
            )

    @property
    def last_words(self) -> str:
        """The last line that it wrote to standard error, empty for none."""
        return self._words[-1] if self._words else ""

    @property
    def messages(self) -> list[str]:
        """The last lines that it wrote to standard error."""
        return list(self._words)

    def _listen(self) -> None:
        """Take what it says: a pipe that nobody reads would hold it up in the end."""
        if self.process.stderr is not None:
            for line in self.process.stderr:
                self._words.append(line.rstrip())

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
            status = self.process.wait(_STOP_PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            status = self.process.wait()
        self._listener.join()
        if self.process.stderr is not None:
            self.process.stderr.close()
        return status


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


class RunningSimulator(SimulatorProcess):
    """A simulator in a process of its own that takes faults while it runs: see `simulated`.

    Parameters
    ----------
    folder : Path
        Empty, for its link, control file and trace.
    arguments : str
        Of the command ``firmware-sim``.

    Attributes
    ----------
    port : str
        The port at the start.
    link : str
        A name of the port that stays the same when it is unplugged and comes back.
    """

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.link = str(folder / "port")
        self._control = folder / "control"
        self._trace = folder / "trace.txt"
        own = ("--link", self.link, "--control", str(self._control), "--trace", str(self._trace))
        self._last_trace = ""
        super().__init__(*arguments, *own)

    def inject(self, fault: str) -> int:
        """Begin a fault, such as ``"crc-error:id=1,for=2"``; return its number.

        Raises
        ------
        ControlError
            If there is no such fault.
        """
        return int(send(self._control, "inject", fault)["number"])

    def clear(self, name: str = "all") -> None:
        """End the faults of a name, the one with a number, or all.

        Raises
        ------
        ControlError
            If none is in force that is meant.
        """
        send(self._control, "clear", name)

    def status(self) -> dict[str, Any]:
        """Return the time, the port, the faults and the servos, as ``--status`` has them."""
        return send(self._control, "status")

    def strikes(self) -> list[dict[str, Any]]:
        """Return what faults did last: tick, time, fault, number, id and detail of each."""
        strikes: list[dict[str, Any]] = send(self._control, "log")["log"]
        return strikes

    @property
    def hands(self) -> Hands:
        """Hands of a person: ``arm.hands.turn({1: 2048, 2: 1000})``; time is real then."""

        def positions() -> dict[int, int]:
            return positions_in(self.status()["servos"])

        return Hands(self.inject, self.clear, positions, time.sleep)

    @property
    def trace(self) -> str:
        """The packet trace: as far as it is written by now, whole after the end."""
        if self._trace.exists():
            return self._trace.read_text()
        return self._last_trace

    def stop(self) -> int:
        """End it, and return its exit status; may be called twice."""
        status = super().stop()
        self._last_trace = self.trace
        return status


@contextmanager
def simulated(
    *servos: str,
    baud: int | None = None,
    protocol: int | None = None,
    faults: Sequence[str] = (),
    seed: int | None = None,
    state: Path | None = None,
    rig: str | None = None,
    arguments: Sequence[str] = (),
) -> Iterator[RunningSimulator]:
    """Run a simulator that takes faults for as long as a ``with`` block lasts.

    Parameters
    ----------
    servos : str
        ``MODEL:ID`` or ``MODEL@FIRMWARE:ID`` each; none with `rig`, or if `arguments` name an arm
        or a rig.
    baud : int, optional
        Of all servos, bit/s.
    protocol : int, optional
        1 or 2, of all servos.
    faults : sequence of str
        In force from the start, such as ``"crc-error:id=1,probability=0.1"``.
    seed : int, optional
        Of the faults' chance.
    state : Path, optional
        Where EEPROM and angles are kept from one run to the next.
    rig : str, optional
        The text of a rig file with the servos.
    arguments : sequence of str
        More arguments of the command, such as ``("--rig", "arm.toml")``.

    Yields
    ------
    RunningSimulator
        With ``port``, ``link``, ``inject``, ``clear``, ``hands``, ``status``, ``strikes`` and
        ``trace``.

    Raises
    ------
    SimulatorStartError
        If it does not start; says what is wrong.
    """
    command = ["--servo", *servos] if servos else []
    for name, value in (
        ("--baud", baud),
        ("--protocol", protocol),
        ("--seed", seed),
        ("--state", state),
    ):
        command += [] if value is None else [name, str(value)]
    for fault in faults:
        command += ["--fault", fault]
    with TemporaryDirectory(prefix="firmware-sim-") as folder:
        if rig is not None:
            file = Path(folder) / "rig.toml"
            file.write_text(rig)
            command += ["--rig", str(file)]
        simulator = RunningSimulator(Path(folder), *command, *arguments)
        try:
            yield simulator
        finally:
            simulator.stop()
