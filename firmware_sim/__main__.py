"""The command ``firmware-sim``: servos on a virtual serial port, until it is stopped."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from firmware_sim.command.arguments import build_parser, model_list
from firmware_sim.command.ask import ask, wants_control
from firmware_sim.command.run import serve
from firmware_sim.command.words import complain, say
from firmware_sim.errors import SimulatorError


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
    parser = build_parser()
    arguments = parser.parse_args(argv)
    try:
        if arguments.list_models:
            say(model_list())
        elif arguments.list_faults:
            from firmware_sim.faults.registry import list_faults  # noqa: PLC0415 - not for most

            say(list_faults())
        elif wants_control(arguments):
            say(ask(arguments))
        elif not (arguments.servo or arguments.arm or arguments.rig):
            parser.error("say which servos: --servo, --arm or --rig")
        else:
            serve(arguments)
    except SimulatorError as error:
        complain(str(error))
        return error.exit_status
    return 0


if __name__ == "__main__":
    sys.exit(main())
