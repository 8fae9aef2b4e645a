"""`armsyn grip`: open or close an arm's gripper, or grip to a current."""

from __future__ import annotations

import math
from contextlib import closing
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.arm_options import connected
from armsyn.cli.operating import arm_options, ask, print_json, say, yes_option

if TYPE_CHECKING:
    from armsyn.driver.operate_grip import Grip, Gripper

FAULTY = 3


@click.command(context_settings={"ignore_unknown_options": True})  # -5 is a bad width, no option
@click.argument("width", metavar="open|close|WIDTH_MM")
@arm_options
@click.option(
    "--current", type=float, metavar="A", help="To grip with, for servos that measure it."
)
@click.option(
    "--force",
    type=float,
    metavar="PERCENT",
    help="To grip with, for servos that do not; of the servo's greatest.  [default: 30]",
)
@yes_option
def grip(width: str, current: float | None, force: float | None, yes: bool, **options: Any) -> None:
    """Open or close the gripper, to a width or until it holds something.

    The fingers push with a bounded current (or force) all the time. Says how far apart they are
    and whether something is between them; the gripper goes on holding with that force.

    Exit status: 0, also when something is held; 3 when the fingers stopped short for no reason.
    """
    from armsyn.driver.operate_grip import Gripper
    from armsyn.driver.transactions import Bus

    with connected(options) as there, closing(Bus(there.port, there.arm.servo[0].baud)) as bus:
        gripper = Gripper(bus, there.arm)
        goal = _metres(width, gripper)
        bound = gripper.force_of(current, None if force is None else force / 100.0)
        _ask_for_mode(gripper, yes=yes)
        found = _move(gripper, goal, bound)
        if options["as_json"]:
            print_json(_entry(found))
        else:
            say(_words(found), options)
    click.get_current_context().exit(0 if found.arrived or found.held else FAULTY)


def _metres(width: str, gripper: Gripper) -> float:
    from armsyn.errors import InputError

    named = {"open": gripper.description.width_open, "close": gripper.description.width_closed}
    try:
        metres = named[width] if width in named else float(width) * 1e-3
    except ValueError:
        metres = math.nan
    if not math.isfinite(metres):
        raise InputError(f"{width!r} is neither open, close nor a width in mm")
    gripper.check_width(metres)
    return metres


def _ask_for_mode(gripper: Gripper, *, yes: bool) -> None:
    mode = gripper.mode_to_set()
    if mode is None:
        return
    text = f"{gripper.title} must be put into operating mode {mode}"
    if not gripper.holds():
        click.echo(f"{text}; it is limp, so nothing falls", err=True)
        return
    click.echo(f"{text}; its torque goes off for that: what it holds falls", err=True)
    ask("Put it into that mode?", yes=yes)


def _move(gripper: Gripper, goal: float, bound: float) -> Grip:
    """Move with the width shown on a terminal; on Ctrl-C hold where it is."""
    from rich.console import Console

    console = Console(stderr=True)
    try:
        with console.status("") as shown:
            look = (lambda w: shown.update(f"{w * 1e3:z.0f} mm")) if console.is_terminal else None
            return gripper.move(goal, bound, look)
    except KeyboardInterrupt:
        gripper.stop()
        click.echo(f"stopped at {gripper.width() * 1e3:z.1f} mm, holding", err=True)
        raise


def _words(found: Grip) -> str:
    pushing = f"{found.effort:.0%} of what it may push with"
    if found.current is not None:
        pushing = f"{found.current:z.2f} A, {pushing}"
    where = f"fingers {found.width * 1e3:z.1f} mm apart"
    if found.held:
        return f"holds something: {where} ({pushing}); holding on"
    if found.arrived:
        return f"{where}, nothing held; torque on"
    return (
        f"stopped short: {where}, sent to {found.goal_width * 1e3:.1f} mm, not pushing ({pushing}):"
        " more --current or --force, or look what is in its way"
    )


def _entry(found: Grip) -> dict[str, Any]:
    return {
        "width_m": found.width,
        "goal_width_m": found.goal_width,
        "arrived": found.arrived,
        "held": found.held,
        "current_a": found.current,
        "effort": found.effort,
    }
