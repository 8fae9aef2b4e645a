"""The command's other half: what it asks of a simulator that runs already."""

from __future__ import annotations

import argparse
from typing import Any

from firmware_sim.errors import ControlError


def wants_control(arguments: argparse.Namespace) -> bool:
    """Return whether a command line is about a simulator that runs already.

    Raises
    ------
    ControlError
        If it asks something of one without saying of which, or also for servos of its own.
    """
    if arguments.inject is None and arguments.clear is None and not arguments.status:
        return False
    if not arguments.control:
        raise ControlError("--inject, --clear and --status need --control FILE of the simulator")
    if arguments.servo or arguments.arm or arguments.rig:
        raise ControlError("--inject, --clear and --status speak to a simulator that runs already")
    return True


def ask(arguments: argparse.Namespace) -> str:
    """Ask, and return the answer for people to read.

    Raises
    ------
    ControlError
        If no simulator answers, or it refuses.
    """
    from firmware_sim.control_client import send  # noqa: PLC0415 - no sockets for a simulator

    if arguments.inject is not None:
        answer = send(arguments.control, "inject", arguments.inject)
        return f"fault {answer['number']} in force: {answer['fault']}"
    if arguments.clear is not None:
        answer = send(arguments.control, "clear", arguments.clear)
        return f"cleared: fault {', '.join(map(str, answer['cleared']))}"
    return _status_in_words(send(arguments.control, "status"))


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
