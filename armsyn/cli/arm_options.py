"""The options that commands for an arm share, and the port that they lead to.

A real arm is named by ``--port`` and ``--arm``. Without a port a simulated one is started, and the
first line says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription

DEFAULT_ARM = "human7"
PLANTS = ("joints", "mujoco")

Command = TypeVar("Command", bound=Callable[..., Any])


@dataclass(frozen=True)
class Connection:
    """An arm and the port it is on.

    Attributes
    ----------
    arm : ArmDescription
    port : str
    simulated : bool
    calibration : Path or None
        File that was laid over the arm's description, if one was.
    """

    arm: ArmDescription
    port: str
    simulated: bool
    calibration: Path | None = None


arm_option = click.option(
    "--arm", "arm_name", metavar="NAME", help=f"[default: {DEFAULT_ARM}, simulated]"
)
port_option = click.option(
    "--port", metavar="PATH", help="Serial port of a real arm; without it, simulated."
)
calibration_option = click.option(
    "--calibration",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The only folder to look for the arm's files in.",
)
unit_option = click.option(
    "--name",
    "unit",
    metavar="NAME",
    help="Which of several arms of this kind, such as left: its own calibration is used.",
)
plant_option = click.option(
    "--plant",
    type=click.Choice(PLANTS),
    help="Of a simulated arm: independent joints, or its bodies under gravity (needs MuJoCo)."
    "  [default: joints]",
)
json_option = click.option(
    "--json", "as_json", is_flag=True, help="One JSON document on standard output."
)


def arm_options(command: Command) -> Command:
    """Give a command the options that say which arm, where, and whether in JSON."""
    return which_arm_options(json_option(command))


def which_arm_options(command: Command) -> Command:
    """Give a command the options that say which arm, and where."""
    for option in (plant_option, calibration_option, unit_option, arm_option, port_option):
        command = option(command)
    return command


def arm_of(options: dict[str, Any]) -> ArmDescription:
    """Load the arm that options mean.

    A simulated one has the zeros of its description, whatever a real one's calibration says, and
    no weight where its joints are independent.

    Parameters
    ----------
    options : dict
        As `arm_options` gives.

    Raises
    ------
    InputError
        A port without an arm, or with a plant; a unit without a port.
    DescriptionError
        No such arm, or an unusable file.
    """
    import msgspec

    from armsyn.arm import load_arm
    from armsyn.errors import InputError

    port, name = options["port"], options["arm_name"]
    if port and not name:
        raise InputError("--port needs --arm: which arm is connected there?")
    if port and options["plant"]:
        raise InputError("--plant is of simulated arms: leave out --port, or --plant")
    if options["unit"] and not port:
        raise InputError("--name is of real arms, which have calibrations: it needs --port")
    arm = load_arm(
        name or DEFAULT_ARM, options["calibration"], unit=options["unit"], calibrated=bool(port)
    )
    if port or options["plant"] == "mujoco":
        return arm
    return msgspec.structs.replace(arm, gravity=(0.0, 0.0, 0.0))


def calibration_of(arm: ArmDescription, options: dict[str, Any]) -> Path | None:
    """Which calibration file a real arm is used with; None for none."""
    from armsyn.arm.calibration_file import find_calibration

    overlay = find_calibration(arm.name, options["unit"], options["calibration"])
    return None if overlay is None else overlay.absolute()


def port_text(arm: ArmDescription, port: str, calibration: Path | None) -> str:
    """The first line of a command on a real arm."""
    zeros = "not calibrated: the description's zeros"
    return f"{arm.name} on {port}, " + (f"calibrated by {calibration}" if calibration else zeros)


@contextmanager
def connected(options: dict[str, Any]) -> Iterator[Connection]:
    """Load the arm, and start a simulated one if no port is given; the first line says which.

    Parameters
    ----------
    options : dict
        As `arm_options` gives.

    Yields
    ------
    Connection
        The port is not opened yet, and ends with the block if it is a simulated arm's.

    Raises
    ------
    InputError
        As `arm_of`.
    DescriptionError
        No such arm, or none that has servos.
    PortError, PortLostError
        Of a simulator that does not start, or ends by itself.
    """
    from armsyn.errors import DescriptionError

    port, arm = options["port"], arm_of(options)
    if not arm.servo:
        raise DescriptionError(f"{arm.name} has no servos: it is a model only")
    if port:
        overlay = calibration_of(arm, options)
        _say(port_text(arm, port, overlay), options)
        yield Connection(arm, port, simulated=False, calibration=overlay)
        return
    with started(arm, options["calibration"], options["plant"]) as simulated:
        bodies = " under gravity" if options["plant"] == "mujoco" else ""
        where = f"simulated {arm.name}{bodies} on {simulated} (firmware_sim; no hardware moves)"
        _say(where, options)
        yield Connection(arm, simulated, simulated=True)


def started(
    arm: ArmDescription, calibration: Path | None, plant: str | None
) -> AbstractContextManager[str]:
    """Start a simulated arm with one of the `PLANTS`: a context manager that yields its port."""
    from armsyn.arm import find_file
    from armsyn.cli.simulator import simulated_arm, simulated_bodies

    if plant == "mujoco":
        return simulated_bodies(arm)
    return simulated_arm(find_file(arm.name, ".toml", calibration))


def _say(where: str, options: dict[str, Any]) -> None:
    click.echo(where, err=options["as_json"])
