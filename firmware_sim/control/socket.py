"""Faults at run time: a control socket on loopback, and how to speak to it.

One request a line and one answer a line, both JSON objects::

    {"token": "...", "command": "inject", "fault": "crc-error:id=3,for=2"}
    {"ok": true, "number": 4, "fault": "crc-error:id=3,for=2"}

`COMMANDS` says what can be asked. Address and token are in a file that only its owner can read.
Whoever sends garbage, a wrong token or too much is told so in a line and disconnected.
"""

from __future__ import annotations

import json
import secrets
import socket
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from firmware_sim.clock import Clock, RealClock
from firmware_sim.control.file import ControlAddress, remove_control_file, write_control_file
from firmware_sim.control.report import describe_fault, describe_simulation, describe_strike
from firmware_sim.errors import ControlError, SimulatorError
from firmware_sim.simulation import Simulation

LINE_CAP = 4096
"""Most bytes of a request."""

REQUEST_CAP = 10_000
"""Most requests of one connection."""

CONNECTION_CAP = 8
"""Most connections; to make room for another, one that has not shown the token goes first, and of
those alike the one that has been silent longest."""

_STRIKES_SHOWN = 100

Answer = dict[str, Any]


class ControlSocket:
    """Listens on loopback for those who want to inject faults; has no thread of its own.

    Parameters
    ----------
    simulation : Simulation
        What they act on.
    path : Path
        Where address and token go, for its owner alone.
    clock : Clock
        The simulation's time.

    Raises
    ------
    OutputError
        If the file is there already, and not a dead simulator's, or cannot be made.
    """

    def __init__(self, simulation: Simulation, path: Path, clock: Clock | None = None) -> None:
        self.refused = 0
        """How many requests were no good."""
        self._simulation = simulation
        self._clock = clock or RealClock()
        self._connections: dict[int, _Connection] = {}  # by descriptor, the least recent first
        self._token = secrets.token_urlsafe(32)
        self._listener = socket.create_server(("127.0.0.1", 0), backlog=CONNECTION_CAP)
        try:
            self._listener.setblocking(False)
            self._address = ControlAddress(self._listener.getsockname()[1], self._token)
            self._path = write_control_file(path, self._address)
        except BaseException:
            self._listener.close()
            raise

    def descriptors(self) -> Sequence[int]:
        """Return what to watch for something to read."""
        return (self._listener.fileno(), *self._connections)

    def serve(self, ready: Sequence[int]) -> None:
        """Deal with the descriptors that have something to read; others are ignored."""
        for descriptor in ready:
            connection = self._connections.pop(descriptor, None)
            if connection is not None and self._hear(connection):
                self._connections[descriptor] = connection
        if self._listener.fileno() in ready:
            self._accept()

    def close(self) -> None:
        """Close all, and remove the file; may be called twice."""
        for connection in self._connections.values():
            connection.close()
        self._connections.clear()
        if self._listener.fileno() >= 0:
            self._listener.close()
            remove_control_file(self._path, self._address)

    def _accept(self) -> None:
        try:
            client, _address = self._listener.accept()
        except OSError:  # gone again, or out of descriptors: nobody to tell
            return
        client.setblocking(False)
        if len(self._connections) >= CONNECTION_CAP:
            strangers = (at for at, other in self._connections.items() if not other.is_known)
            self._connections.pop(next(strangers, next(iter(self._connections)))).close()
        self._connections[client.fileno()] = _Connection(client)

    def _hear(self, connection: _Connection) -> bool:
        """Answer one request, if a whole one has come; return whether the connection goes on.

        More of them wait in the socket, so that the bus has its turn in between.
        """
        line = connection.take_line()
        if line is not None:
            answer, goes_on = self._answer(line)
            connection.is_known |= goes_on
            if not connection.send(answer) or not goes_on:
                connection.close()
        return connection.is_open

    def _answer(self, line: bytes) -> tuple[Answer, bool]:
        """Return the answer to a line, and whether its sender may go on."""
        request = _read_object(line)
        token = request.pop("token", None)
        known = isinstance(token, str) and secrets.compare_digest(
            token.encode("utf-8", "replace"), self._token.encode()
        )
        if not known:
            self.refused += 1
            return _refusal("no request with a valid token"), False
        try:
            self._simulation.catch_up(self._clock.now())
            return {"ok": True, **execute(self._simulation, request)}, True
        except SimulatorError as error:
            self.refused += 1
            return _refusal(str(error)), True


class _Connection:
    """One client: its socket, and what it has said of its next line."""

    def __init__(self, client: socket.socket) -> None:
        self._client = client
        self._pending = bytearray()
        self._requests = 0
        self.is_known = False
        """Whether it has shown the token."""

    @property
    def is_open(self) -> bool:
        return self._client.fileno() >= 0

    def take_line(self) -> bytes | None:
        """Return the next line if it is whole by now; close at the end or at too much."""
        chunk = self._receive()
        if chunk is None:
            return None
        self._pending += chunk
        if not chunk:
            self.close()
        elif len(self._pending) > LINE_CAP or self._requests >= REQUEST_CAP:
            self.send(_refusal("too much"))
            self.close()
        elif chunk.endswith(b"\n"):
            line = bytes(self._pending)
            self._pending.clear()
            self._requests += 1
            return line
        return None

    def _receive(self) -> bytes | None:
        """Return bytes up to the next end of a line; None for none yet, empty at the end."""
        try:
            waiting = self._client.recv(LINE_CAP, socket.MSG_PEEK)
            end = waiting.find(b"\n") + 1 or len(waiting)
            return self._client.recv(end) if waiting else b""
        except BlockingIOError:
            return None
        except OSError:
            return b""

    def send(self, answer: Answer) -> bool:
        """Send an answer; return False where the client does not take it."""
        data = json.dumps(answer).encode() + b"\n"
        try:
            return self._client.send(data) == len(data)
        except OSError:
            return False

    def close(self) -> None:
        self._client.close()


def execute(simulation: Simulation, request: Mapping[str, object]) -> Answer:
    """Do what a request asks for, and return what there is to say.

    Raises
    ------
    SimulatorError
        One line, if it cannot be done.
    """
    command = request.get("command")
    if not isinstance(command, str) or command not in COMMANDS:
        raise ControlError(f"command is none of {', '.join(COMMANDS)}")
    arguments = {name: value for name, value in request.items() if name != "command"}
    allowed, act = COMMANDS[command]
    for name, value in arguments.items():
        if name not in allowed or not isinstance(value, str):
            takes = " and ".join(allowed) or "nothing"
            raise ControlError(f"{command} takes {takes}, as text")
    return act(simulation, arguments)


def _inject(simulation: Simulation, arguments: Mapping[str, Any]) -> Answer:
    if "fault" not in arguments:
        raise ControlError("inject needs fault")
    return describe_fault(simulation.inject(arguments["fault"]), simulation)


def _clear(simulation: Simulation, arguments: Mapping[str, Any]) -> Answer:
    cleared = simulation.clear(arguments.get("fault", "all"))
    return {"cleared": [fault.number for fault in cleared]}


def _list(simulation: Simulation, _arguments: Mapping[str, Any]) -> Answer:
    return {"faults": [describe_fault(fault, simulation) for fault in simulation.faults]}


def _log(simulation: Simulation, _arguments: Mapping[str, Any]) -> Answer:
    return {"log": [describe_strike(s) for s in list(simulation.log)[-_STRIKES_SHOWN:]]}


def _status(simulation: Simulation, _arguments: Mapping[str, Any]) -> Answer:
    return describe_simulation(simulation)


COMMANDS: Mapping[
    str, tuple[tuple[str, ...], Callable[[Simulation, Mapping[str, Any]], Answer]]
] = {
    "inject": (("fault",), _inject),
    "clear": (("fault",), _clear),
    "list": ((), _list),
    "log": ((), _log),
    "status": ((), _status),
}
"""By name: the fields a request may have, and what is done.

``inject`` puts a fault in force; ``clear`` takes away those of a name, the one with a number, or
all; ``list`` says which are in force, ``log`` what struck last, ``status`` how the servos are.
"""


def _refusal(reason: str) -> Answer:
    return {"ok": False, "error": reason}


def _read_object(line: bytes) -> dict[str, Any]:
    """Return the JSON object on a line; an empty one where there is none."""
    try:
        document = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    return document if isinstance(document, dict) else {}
