"""Speaks to a running simulator through its control file."""

from __future__ import annotations

import json
import socket
from pathlib import Path
from typing import Any

from firmware_sim.control.file import read_control_file
from firmware_sim.errors import ControlError

PATIENCE = 5.0
"""How long an answer may take, s."""

_ANSWER_CAP = 4_000_000


def send(
    control_file: Path, command: str, fault: str | None = None, timeout: float = PATIENCE
) -> dict[str, Any]:
    """Ask a running simulator to do something, and return its answer.

    Parameters
    ----------
    control_file : Path
        What ``firmware-sim --control FILE`` wrote.
    command : str
        ``inject``, ``clear``, ``list``, ``log`` or ``status``.
    fault : str, optional
        What to inject, as ``crc-error:id=3``; or what to clear: a name, a number, or ``all``.
    timeout : float
        How long the answer may take, s.

    Returns
    -------
    dict
        See `control.COMMANDS` and `control_report`; without ``ok``.

    Raises
    ------
    ControlError
        If there is no such simulator, or it refuses: one line.
    """
    address = read_control_file(control_file)
    request = {"token": address.token, "command": command}
    if fault is not None:
        request["fault"] = fault
    try:
        with address.connect(timeout) as connection:
            connection.sendall(json.dumps(request).encode() + b"\n")
            line = _read_line(connection)
        answer = json.loads(line)
    except OSError as error:
        raise ControlError(
            f"{control_file}: its simulator does not answer ({error}); is it still running?"
        ) from error
    except ValueError as error:
        raise ControlError(f"{control_file}: what answers there is no simulator") from error
    if not isinstance(answer, dict) or answer.pop("ok", None) is not True:
        reason = answer.get("error") if isinstance(answer, dict) else None
        raise ControlError(str(reason or f"{control_file}: what answers there is no simulator"))
    return answer


def _read_line(connection: socket.socket) -> bytes:
    line = bytearray()
    while not line.endswith(b"\n"):
        chunk = connection.recv(65_536)
        if not chunk or len(line) > _ANSWER_CAP:
            break
        line += chunk
    return bytes(line)
