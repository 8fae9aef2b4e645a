"""The file that says where a simulator's control socket is, and what opens it."""

from __future__ import annotations

import json
import os
import socket
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from firmware_sim.errors import ControlError, OutputError
from firmware_sim.files import read_capped

SCHEMA = "firmware-sim-control-1"

_FILE_SIZE_CAP = 10_000
_PATIENCE = 1.0  # s to see whether a simulator listens


@dataclass(frozen=True, slots=True)
class ControlAddress:
    """Where to connect, and what to say.

    Parameters
    ----------
    port : int
        On 127.0.0.1.
    token : str
        Of every request.
    """

    port: int
    token: str

    def connect(self, timeout: float) -> socket.socket:
        """Return a connection; OSError if nobody listens."""
        return socket.create_connection(("127.0.0.1", self.port), timeout)


def write_control_file(path: Path, address: ControlAddress) -> Path:
    """Write a new control file, mode 0600; one that a killed simulator left is replaced.

    Raises
    ------
    OutputError
        If something else is there, or it cannot be made.
    """
    content = {"schema": SCHEMA, "port": address.port, "token": address.token}
    _remove_stale(path)
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
    except FileExistsError:
        raise OutputError(
            f"{path} exists already: remove it, or give another --control", str(path)
        ) from None
    except OSError as error:
        raise OutputError(f"{path} cannot be made: {error.strerror}", str(path)) from error
    with os.fdopen(descriptor, "w", encoding="utf-8") as file:
        file.write(json.dumps(content) + "\n")
    return path


def read_control_file(path: Path) -> ControlAddress:
    """Read a control file.

    Raises
    ------
    ControlError
        If there is none, or it is not one.
    """
    try:
        content = read_capped(path, _FILE_SIZE_CAP)
    except OSError as error:
        raise ControlError(
            f"{path} cannot be read ({error.strerror}): is a simulator running with"
            f" --control {path}?"
        ) from error
    try:
        document = json.loads(content[:_FILE_SIZE_CAP])
    except (ValueError, RecursionError):
        document = None
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise ControlError(f"{path} is not a control file")
    port, token = document.get("port"), document.get("token")
    if type(port) is not int or not 0 < port < 65_536 or not isinstance(token, str):
        raise ControlError(f"{path} is not a control file: port or token are wrong")
    return ControlAddress(port, token)


def remove_control_file(path: Path, address: ControlAddress) -> None:
    """Remove a control file that is still this simulator's own."""
    with suppress(ControlError, OSError):
        if read_control_file(path) == address:
            path.unlink()


def _remove_stale(path: Path) -> None:
    """Remove a control file whose simulator does not listen any more."""
    try:
        if path.is_symlink():
            return
        address = read_control_file(path)
    except (ControlError, OSError):  # an impossible name, too: it is refused later
        return
    try:
        address.connect(_PATIENCE).close()
    except OSError:
        with suppress(OSError):
            path.unlink()
