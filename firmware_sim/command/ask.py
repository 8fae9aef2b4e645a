"""The command's other half: what it asks of a simulator that runs already."""

from __future__ import annotations

import argparse
from typing import Any

from firmware_sim.errors import ControlError

_DEEDS = "--inject, --clear, --status and --log"


def wants_control(arguments: argparse.Namespace) -> bool:
    """Return whether a command line is about a simulator that runs already.

    Raises
    ------
    ControlError
        If it asks something of one without saying of which, or also for servos of its own.
    """
    asked = arguments.status or arguments.log
    if arguments.inject is None and arguments.clear is None and not asked:
        return False
    if not arguments.control:
        raise ControlError(
            "--inject, --clear, --status and --log need --control FILE of the simulator"
        )
    if arguments.servo or arguments.arm or arguments.rig:
        raise ControlError(
            "--inject, --clear, --status and --log speak to a simulator that runs already"
        )
    return True


def ask(arguments: argparse.Namespace) -> str:
    """Ask, and return the answer for people to read.

    Raises
    ------
    ControlError
        If no simulator answers, or it refuses.
    """
    from firmware_sim.control.client import send  # noqa: PLC0415 - no sockets for a simulator

    if arguments.inject is not None:
        answer = send(arguments.control, "inject", arguments.inject)
        return f"fault {answer['number']} in force: {answer['fault']}"
    if arguments.clear is not None:
        answer = send(arguments.control, "clear", arguments.clear)
        cleared = ", ".join(map(str, answer["cleared"]))
        return f"cleared: fault {cleared}" if cleared else "no faults were in force"
    if arguments.log:
        return _log_in_words(send(arguments.control, "log"))
    return _status_in_words(send(arguments.control, "status"))


def _log_in_words(answer: dict[str, Any]) -> str:
    lines = []
    for strike in answer["log"]:
        servo = "" if strike["id"] is None else f" servo {strike['id']}"
        detail = f": {strike['detail']}" if strike["detail"] else ""
        what = f"fault {strike['number']} {strike['fault']}{servo}{detail}"
        lines.append(f"tick {strike['tick']} ({strike['time']:.6f} s) {what}")
    return "\n".join(lines) or "no fault has struck yet"


def _status_in_words(status: dict[str, Any]) -> str:
    port = "unplugged" if status["unplugged"] else "forbidden" if status["forbidden"] else "there"
    lines = [f"{status['time']:.3f} s since the start; port {port}"]
    for servo in status["servos"]:
        registers = ", ".join(f"{name} {value}" for name, value in servo["registers"].items())
        lines.append(f"servo {servo['id']} {servo['model']}, {servo['baud']} bit/s: {registers}")
    lines += [
        f"fault {fault['number']} {fault['fault']}: {fault['strikes']} strikes"
        for fault in status["faults"]
    ]
    if not status["faults"]:
        lines.append("no faults in force")
    return "\n".join(lines)
