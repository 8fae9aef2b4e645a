"""`armsyn calibrate --check`: an arm beside its calibration file."""

from __future__ import annotations

import math
from contextlib import closing
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from pathlib import Path

    from armsyn.arm import ArmDescription
    from armsyn.arm.calibration_file import ArmCalibration
    from armsyn.driver.calibrating_check import CheckedArm


def check(arm: ArmDescription, options: dict[str, Any]) -> None:
    """Compare, tell, and end the command with 3 when something differs."""
    from armsyn.arm.calibration_file import find_calibration, read_calibration
    from armsyn.driver.calibrating_check import check_calibration
    from armsyn.driver.transactions import Bus
    from armsyn.errors import DescriptionError

    path = find_calibration(arm.name, options["name"], options["calibration"])
    if path is None:
        raise DescriptionError(f"{arm.name} is not calibrated: run armsyn calibrate")
    calibration = read_calibration(path)
    with closing(Bus(options["port"], arm.servo[0].baud)) as bus:
        found = check_calibration(bus, arm, calibration, at_rest=options["at_rest"])
    if options["as_json"]:
        import json

        click.echo(json.dumps(_document(path, found), indent=2, allow_nan=False))
    else:
        _show(path, calibration, found)
    click.get_current_context().exit(3 if found.problems else 0)


def _show(path: Path, calibration: ArmCalibration, found: CheckedArm) -> None:
    from rich.console import Console
    from rich.table import Table

    click.echo(f"{path}: of {calibration.date}, method {calibration.method}")
    if found.servos:
        table = Table("servo", "joint", "tick", "deg", "off rest, deg", box=None)
        for servo in found.servos:
            table.add_row(
                str(servo.calibration.id),
                servo.calibration.joint,
                str(servo.present),
                f"{math.degrees(servo.angle):z.1f}",
                f"{math.degrees(servo.angle - servo.rest):+z.1f}",
            )
        Console().print(table)
    for problem in found.problems:
        click.echo(f"problem: {problem}")
    if not found.problems:
        click.echo("as calibrated")


def _document(path: Path, found: CheckedArm) -> dict[str, Any]:
    return {
        "file": str(path),
        "servos": [
            {
                "id": servo.calibration.id,
                "joint": servo.calibration.joint,
                "tick": servo.present,
                "angle_rad": servo.angle,
                "rest_rad": servo.rest,
            }
            for servo in found.servos
        ],
        "problems": list(found.problems),
    }
