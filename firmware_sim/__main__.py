"""The command ``firmware-sim``: servos on a virtual serial port, until it is stopped."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

import firmware_sim
from firmware_sim.errors import RigError, SimulatorError
from firmware_sim.rig import ServoSettings, check_ids, parse_servo, with_baud_rate
from firmware_sim.tables import MODEL_NAMES

_MAX_RETURN_DELAY = 254

_DESCRIPTION = """\
Simulate Dynamixel servos behind a virtual serial port, until SIGINT or SIGTERM.
The first line of the output is the port; it and its link are gone at the end.
With --servo and --rig, what is not said is as the factory sets it: 57600 bit/s, return
delay 500 us; with --arm, as an arm's set-up leaves it: 1 Mbit/s, no return delay."""


class _OneLineParser(argparse.ArgumentParser):
    """Says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


def build_parser() -> argparse.ArgumentParser:
    """Return the command's parser."""
    parser = _OneLineParser(
        prog="firmware-sim",
        description=_DESCRIPTION,
        epilog=(firmware_sim.__doc__ or "").split("\n\n", 2)[2],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    servos = parser.add_mutually_exclusive_group(required=True)
    servos.add_argument(
        "--arm",
        metavar="NAME",
        help="the servos of calibration/NAME.toml",
    )
    servos.add_argument(
        "--rig", metavar="FILE", type=Path, help="the [[servo]] tables of a TOML file"
    )
    servos.add_argument(
        "--servo",
        metavar="MODEL:ID",
        nargs="+",
        action="extend",
        help=f"one or more servos; models: {', '.join(MODEL_NAMES)}",
    )
    parser.add_argument(
        "--link",
        metavar="PATH",
        type=Path,
        help="symbolic link to the port; one left by a simulator that was killed is replaced",
    )
    parser.add_argument(
        "--calibration", metavar="DIR", type=Path, help="the only folder to look for --arm in"
    )
    parser.add_argument(
        "--return-delay", metavar="N", type=int, help="set all Return Delay Times, in 2 us"
    )
    parser.add_argument("--baud", metavar="N", type=int, help="set all baud rates, bit/s")
    parser.add_argument(
        "--exit-with-stdin",
        action="store_true",
        help="also end when standard input does, so that a killed parent leaves nothing behind",
    )
    return parser


def choose_servos(arguments: argparse.Namespace) -> list[ServoSettings]:
    """Return the servos that a command line asks for.

    Raises
    ------
    RigError
        If it asks for the impossible.
    """
    if arguments.servo:
        servos = [parse_servo(text) for text in arguments.servo]
    else:
        servos = _read_servos(arguments)
    check_ids(servos)
    if arguments.baud is not None:
        servos = [with_baud_rate(servo, arguments.baud) for servo in servos]
    if arguments.return_delay is not None:
        if not 0 <= arguments.return_delay <= _MAX_RETURN_DELAY:
            raise RigError(f"--return-delay {arguments.return_delay} is not 0 to 254 (of 2 us)")
        servos = [replace(servo, return_delay=arguments.return_delay) for servo in servos]
    return servos


def _read_servos(arguments: argparse.Namespace) -> list[ServoSettings]:
    from firmware_sim.rig_file import (  # noqa: PLC0415 - no TOML reader for --servo
        SET_UP,
        find_arm,
        read_rig,
    )

    if arguments.rig:
        return read_rig(arguments.rig)
    return read_rig(find_arm(arguments.arm, arguments.calibration), SET_UP)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; the process's own by default.

    Returns
    -------
    int
        Exit status: 0 after a stop, 2 for bad input.
    """
    arguments = build_parser().parse_args(argv)
    try:
        _serve(choose_servos(arguments), arguments.link, arguments.exit_with_stdin)
    except SimulatorError as error:
        print(f"firmware-sim: {error}", file=sys.stderr)
        return error.exit_status
    return 0


def _serve(servos: list[ServoSettings], link: Path | None, exit_with_stdin: bool) -> None:
    from firmware_sim.bus import Bus  # noqa: PLC0415 - bad input is reported without loading these
    from firmware_sim.clock import RealClock  # noqa: PLC0415
    from firmware_sim.pty_port import PtyPort  # noqa: PLC0415
    from firmware_sim.server import Server  # noqa: PLC0415

    now = RealClock().now()
    bus = Bus([servo.build(now) for servo in servos])
    port = PtyPort(link)
    try:
        server = Server(bus, port, sys.stdin.fileno() if exit_with_stdin else None)
        server.run(lambda: _announce(port.name, servos))
    finally:
        port.close()


def _announce(port_name: str, servos: list[ServoSettings]) -> None:
    print(port_name, flush=True)
    names = ", ".join(f"{servo.model.name}:{servo.servo_id}" for servo in servos)
    print(f"firmware-sim: a simulation, no hardware: {names}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
