"""`armsyn arms show`: all that is known of one arm."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

NARROWEST = 100
"""Columns that the tables need: they are not cut where a terminal has fewer, or there is none."""


@click.command()
@click.argument("name")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
@click.option(
    "--plot",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE.png",
    help="Draw the arm at rest and at zero.",
)
@click.option(
    "--calibration",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The only folder to look for arms in.",
)
@click.pass_context
def show(
    context: click.Context, name: str, as_json: bool, plot: Path | None, calibration: Path | None
) -> None:
    """Show what is known of an arm: joints, servos, gripper, landmarks, weight, files.

    The droop is how far a joint sags under the arm's own weight in its worst posture when its
    servos run with their initial gains and nothing is done about it.
    """
    from armsyn.cli.arms_facts import arm_facts

    folder = calibration or context.obj
    facts = arm_facts(name, folder)
    if plot is not None:
        from armsyn.arm import load_arm
        from armsyn.cli.arms_plot import draw_arm

        draw_arm(load_arm(name, folder), plot)
        click.echo(f"wrote {plot}", err=True)
    if as_json:
        import json

        click.echo(json.dumps(facts, indent=2, allow_nan=False))
    else:
        _show(facts)


def _show(facts: dict[str, Any]) -> None:
    from rich.console import Console

    console = Console(highlight=False, markup=False)
    console = Console(highlight=False, markup=False, width=max(console.width, NARROWEST))
    console.print(f"{facts['name']}: {facts['title']}")
    for kind, file in facts["files"].items():
        console.print(f"  {kind}: {file or 'none'}")
    console.print()
    console.print(_joint_table(facts["joints"]))
    if facts["servos"]:
        console.print(_servo_table(facts["servos"]))
    console.print(_landmark_table(facts["landmarks"]))
    for line in _remarks(facts):
        console.print(line)


def _joint_table(joints: list[dict[str, Any]]) -> Any:
    table = _table(
        "joint", "limits, deg", "rest", "limits, rad", "rad/s", "kg", "at most N m", "droop, deg"
    )
    for joint in joints:
        low, high = joint["lower"], joint["upper"]
        limits, rest = f"{_degrees(low)} to {_degrees(high)}", _degrees(joint["rest"])
        if joint["kind"] != "revolute":
            limits, rest = "slides, m, N", f"{joint['rest']:.3f}"
        _add(
            table,
            joint["name"],
            limits,
            rest,
            f"{low:.3f} to {high:.3f}",
            f"{joint['max_velocity']:.2f}",
            _known(joint["mass_kg"], "{:.3f}"),
            _known(joint["worst_torque"], "{:.2f}"),
            "-" if joint["droop"] is None else _degrees(joint["droop"]),
        )
    return table


def _servo_table(servos: list[dict[str, Any]]) -> Any:
    table = _table(
        "ID", "model", "moves", "protocol", "supply", "direction", "zero", "rest", "mode"
    )
    for servo in servos:
        shadow = f", shadow of {servo['shadow_of']}" if servo["role"] == "shadow" else ""
        _add(
            table,
            str(servo["id"]),
            servo["model"],
            servo["joint"] + shadow,
            f"{servo['protocol']}.0",
            f"{servo['supply_voltage']:g} V",
            f"{servo['direction']:+d}",
            str(servo["zero_tick"]),
            str(servo["rest_tick"]),
            str(servo["drive_mode"]),
        )
    return table


def _landmark_table(landmarks: list[dict[str, Any]]) -> Any:
    table = _table("landmark", "frame", "x", "y", "z at zero, m")
    for landmark in landmarks:
        position = (f"{value:.4f}" for value in landmark["zero_m"])
        _add(table, landmark["name"], landmark["frame"], *position)
    return table


def _remarks(facts: dict[str, Any]) -> list[str]:
    at_rest = ", ".join(f"{value:.3f}" for value in facts["hand_at_rest_m"])
    mass = facts["moving_mass_kg"]
    weight = f"; {mass:.2f} kg move" if mass is not None else "; masses unknown"
    lines = [f"reach {facts['reach_m']:.3f} m; hand at rest at {at_rest} m{weight}"]
    gripper = facts["gripper"]
    if gripper is not None:
        current = gripper["max_current_a"]
        lines.append(
            f"gripper {gripper['name']}: open {_degrees(gripper['open'])} deg"
            f" ({1e3 * gripper['width_open_m']:.0f} mm), closed {_degrees(gripper['closed'])} deg"
            f" ({1e3 * gripper['width_closed_m']:.0f} mm),"
            f" {f'at most {current:g} A' if current else 'does not control its current'}"
        )
    droop = facts["droop"]
    if droop["hand_m"] is not None:
        lines.append(
            f"droop at worst, uncorrected: the hand by {1e3 * droop['hand_m']:.0f} mm."
            f" Droop = {droop['formula']}"
        )
    collision = facts["collision"]
    around = [*collision["planes"], *collision["boxes"]]
    lines.append(
        f"collision: shapes of {len(collision['described'])} of {len(facts['joints'])} links"
        f" described, {collision['pairs_judged']} pairs judged;"
        f" around it: {', '.join(around) or 'nothing'}"
    )
    return lines


def _table(*headings: str) -> Any:
    from rich.table import Table

    return Table(*headings, box=None, pad_edge=False)


def _add(table: Any, *cells: str) -> None:
    from rich.text import Text

    table.add_row(*(Text(cell, no_wrap=True) for cell in cells))


def _degrees(radians: float) -> str:
    return f"{math.degrees(radians):.1f}"


def _known(value: float | None, form: str) -> str:
    return "-" if value is None else form.format(value)
