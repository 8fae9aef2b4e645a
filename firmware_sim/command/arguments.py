"""The command line of ``firmware-sim``."""

from __future__ import annotations

import argparse
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

import firmware_sim
from firmware_sim.errors import RigError
from firmware_sim.tables import MODEL_NAMES, find_model

_DESCRIPTION = """\
Simulate Dynamixel servos behind a virtual serial port, until SIGINT or SIGTERM.
The first line of the output is the port; it and its link are gone at the end.
With --servo and --rig, what is not said is as the factory sets it; with --arm, as an arm's
set-up leaves it: 1 Mbit/s, no return delay."""

_USAGE = """\
firmware-sim --servo MODEL[@FIRMWARE]:ID ... | --arm NAME | --rig FILE [options]
       firmware-sim --control FILE --inject SPEC | --clear NAME | --status | --log
       firmware-sim --list-models | --list-faults"""


_FORMATS = """\
A rig file (--rig), all fields but id and model optional:

  [supply]
  voltage = 12.0              # V; resistance = 0.03 (ohm)
  [[servo]]
  id = 1
  model = "xm430-w350"        # firmware, protocol, baud, return_delay_us, drive_mode, start_tick,
  backlash = 0.25             # supply_voltage, joint, direction, zero_tick; degrees
  registers = { "Min Position Limit" = 1024 }
  [[servo]]                   # a second one on the joint of the first, which follows its goals
  id = 2
  model = "xm430-w350"
  shadow_of = 1
  drive_mode = 1              # mirrored; with direction = -1 instead it fights its leader

A scenario (--scenario), with the arguments that --list-faults names:

  seed = 7
  [[fault]]
  name = "crc-error"
  at = 2.0                    # s since the start; or after, for, every, count, probability
  id = 3

"""


class _OneLineParser(argparse.ArgumentParser):
    """Says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


class _Version(argparse.Action):
    """Prints the version, which takes long to find, only when asked."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object, **__: object) -> NoReturn:
        from importlib.metadata import version  # noqa: PLC0415 - 50 ms of a start

        print(f"firmware-sim {version('armsyn')}")
        parser.exit(0)


def build_parser() -> argparse.ArgumentParser:
    """Return the command's parser."""
    parser = _OneLineParser(
        prog="firmware-sim",
        usage=_USAGE,
        description=_DESCRIPTION,
        epilog=_FORMATS + (firmware_sim.__doc__ or "").split("\n\n", 2)[2],
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    _add_servos(parser)
    _add_port(parser)
    _add_physics(parser)
    _add_faults(parser)
    _add_output(parser)
    return parser


def _baud_rate(text: str) -> int:
    """Bits a second, a whole number; k and M are thousands and millions."""
    factor = {"k": 1e3, "M": 1e6}.get(text[-1:], 1.0)
    digits = text[:-1] if factor > 1.0 else text
    if not digits.replace(".", "", 1).isdecimal() or not (rate := float(digits) * factor):
        raise argparse.ArgumentTypeError(f"{text!r} is no baud rate: such as 57600, 57.6k or 1M")
    return round(rate)


def _add_servos(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("which servos")
    which = group.add_mutually_exclusive_group()
    which.add_argument("--arm", metavar="NAME", help="the servos of calibration/NAME.toml")
    which.add_argument(
        "--rig", metavar="FILE", type=Path, help="the [[servo]] tables of a TOML file"
    )
    which.add_argument(
        "--servo",
        metavar="MODEL[@FIRMWARE]:ID",
        nargs="+",
        action="extend",
        help="one or more servos; --list-models names the models",
    )
    which.add_argument("--list-models", action="store_true", help="list the models, and end")
    group.add_argument(
        "--calibration", metavar="DIR", type=Path, help="the only folder to look for --arm in"
    )
    group.add_argument(
        "--protocol",
        type=int,
        choices=(1, 2),
        help="let all servos speak Protocol 1.0 or 2.0; by default each speaks its factory's",
    )
    group.add_argument(
        "--baud", metavar="N", type=_baud_rate, help="set all baud rates, bit/s; 1M too"
    )
    group.add_argument(
        "--return-delay", metavar="N", type=int, help="set all Return Delay Times, in 2 us"
    )
    group.add_argument(
        "--state",
        metavar="FILE",
        type=Path,
        help="keep EEPROM, backup and angles here from one run to the next; what is written to"
        " EEPROM is in the file 0.1 s later, also if the simulator is killed then; --baud,"
        " --protocol and --return-delay count more",
    )


def _add_port(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the port")
    group.add_argument(
        "--link",
        metavar="PATH",
        type=Path,
        help="symbolic link to the port; one left by a simulator that was killed is replaced",
    )
    group.add_argument(
        "--no-gap-rule",
        action="store_true",
        help="let servos wait for the rest of an instruction after a silence of 1.5 ms in it",
    )
    group.add_argument(
        "--exit-with-stdin",
        action="store_true",
        help="also end when standard input does, so that a killed parent leaves nothing behind",
    )


def _add_physics(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("physics")
    group.add_argument(
        "--plant",
        choices=("joints", "mujoco"),
        default="joints",
        help="independent joints, or the rig file's arm under gravity (needs mujoco)",
    )


def _add_faults(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("faults")
    group.add_argument(
        "--fault",
        metavar="NAME[:ARGS]",
        action="append",
        default=[],
        help="let something go wrong; may be given several times",
    )
    group.add_argument(
        "--scenario", metavar="FILE", type=Path, help="faults with their times, a TOML file"
    )
    group.add_argument(
        "--seed", metavar="N", type=int, help="of all chance; the scenario's, or 0, by default"
    )
    group.add_argument("--list-faults", action="store_true", help="list the faults, and end")
    group.add_argument(
        "--control",
        metavar="FILE",
        type=Path,
        help="take faults at run time: the address and token of a loopback socket go into FILE;"
        " with one of the next four, speak to the simulator that wrote it",
    )
    deeds = group.add_mutually_exclusive_group()
    deeds.add_argument("--inject", metavar="SPEC", help="begin a fault")
    deeds.add_argument("--clear", metavar="NAME", help="end a fault; all for every one")
    deeds.add_argument("--status", action="store_true", help="say which faults are in force")
    deeds.add_argument("--log", action="store_true", help="say what faults did last, and when")


def _add_output(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is shown")
    group.add_argument(
        "--trace", metavar="FILE", type=Path, help="write every packet here, for people to read"
    )
    group.add_argument(
        "--no-table",
        action="store_true",
        help="show no table of the servos where standard error is a terminal",
    )
    group.add_argument(
        "--version", action=_Version, nargs=0, default=argparse.SUPPRESS, help="say it, and end"
    )


def model_list() -> str:
    """Return a line for each model that can be simulated."""
    return "\n".join(
        f"{name:12}  firmware {find_model(name).firmware:3}  Protocol {_protocols(name)}"
        for name in MODEL_NAMES
    )


def _protocols(name: str) -> str:
    """Return the protocols that a model can speak, the factory's first."""
    native = find_model(name).protocol
    spoken = [f"{native}.0"]
    with suppress(RigError):
        find_model(name, protocol=3 - native)
        spoken.append(f"{3 - native}.0")
    return " or ".join(spoken)
