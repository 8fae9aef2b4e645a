"""How a hand is to be turned at its target: the options of `reach`, `generate` and `track`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from armsyn.planning import HandOrientation

Command = TypeVar("Command", bound=Callable[..., Any])

_OPTIONS = (
    click.option(
        "--pointing",
        type=float,
        nargs=3,
        metavar="X Y Z",
        help="Where the hand points at the end: a direction in the base frame.",
    ),
    click.option(
        "--orientation",
        type=float,
        nargs=3,
        metavar="ROLL PITCH YAW",
        help="How the hand is turned at the end: degrees, as URDF's rpy of the tip in the base"
        " frame.",
    ),
    click.option(
        "--orientation-tolerance",
        type=float,
        metavar="DEGREES",
        help="How far off that the hand may be.  [default: 2]",
    ),
)


def orientation_options(command: Command) -> Command:
    """Give a command the options that say how the hand is turned."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def tolerance_of(options: dict[str, Any]) -> float:
    """Return the tolerance that is asked for, rad; InputError for one that is none."""
    import math

    from armsyn.errors import InputError
    from armsyn.planning.posing import DEFAULT_TOLERANCE

    tolerance = options["orientation_tolerance"]
    if tolerance is None:
        return DEFAULT_TOLERANCE
    if not 0 < tolerance <= 180:
        raise InputError(
            f"--orientation-tolerance must be above 0 and at most 180 degrees, got {tolerance:g}"
        )
    return math.radians(tolerance)


def orientation_of(options: dict[str, Any]) -> HandOrientation | None:
    """Return how the hand is asked to be turned; None where nothing is asked for.

    Raises
    ------
    InputError
        Both, no direction, or angles that are none.
    """
    import numpy as np

    from armsyn.errors import InputError
    from armsyn.kinematics.rotation import from_rpy
    from armsyn.planning import Pointing, Turned
    from armsyn.planning.checking import FARTHEST

    pointing, turned, tolerance = options["pointing"], options["orientation"], tolerance_of(options)
    if pointing and turned:
        raise InputError(
            "a hand points somewhere or is turned some way: --pointing or --orientation"
        )
    if turned and not all(abs(angle) <= FARTHEST for angle in turned):
        raise InputError(
            f"--orientation must be three finite angles within {FARTHEST:.0f} degrees: {turned}"
        )
    if not (pointing or turned):
        return None
    try:
        if pointing:
            return Pointing(pointing, tolerance)
        return Turned(from_rpy(np.radians(turned)), tolerance)
    except InputError as error:
        raise InputError(f"--{'pointing' if pointing else 'orientation'}: {error}") from error


def asked(orientation: HandOrientation | None) -> dict[str, list[float]] | None:
    """Return how a hand was asked to be turned, ready for JSON."""
    import numpy as np

    from armsyn.kinematics.rotation import to_rpy
    from armsyn.planning import Pointing, Turned

    if isinstance(orientation, Pointing):
        return {"pointing": np.asarray(orientation.direction).tolist()}
    if isinstance(orientation, Turned):
        return {"rpy_rad": to_rpy(np.asarray(orientation.rotation)).tolist()}
    return None
