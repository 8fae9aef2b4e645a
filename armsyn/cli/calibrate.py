"""`armsyn calibrate`: zero, direction and range of an arm's joints, found by hand."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.arm.calibration_file import ArmCalibration
    from armsyn.driver.transactions import Bus


@click.command()
@click.option("--arm", "arm_name", required=True, metavar="NAME", help="Which arm it is.")
@click.option("--port", required=True, metavar="PATH", help="Serial port.")
@click.option(
    "--method",
    type=click.Choice(["rest", "hand"]),
    default="rest",
    show_default=True,
    help="rest: zeros from the rest posture. hand: directions and ranges by hand as well.",
)
@click.option("--name", metavar="NAME", help="Which of several arms of this kind, such as left.")
@click.option("--check", is_flag=True, help="Compare the arm with its calibration; write nothing.")
@click.option("--at-rest", is_flag=True, help="With --check: the arm is in its rest posture now.")
@click.option(
    "--calibration",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The only folder to look for the arm's files in, its description as well, and where the"
    " calibration goes.",
)
@click.option("--yes", is_flag=True, help="Write without asking (you still move the arm).")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def calibrate(**options: Any) -> None:
    """Find how one real arm is assembled, while you move it by hand.

    The arm must be limp; support it. You put it into its rest posture, and with --method hand you
    also move each joint as you are told and to both its ends. The result goes into
    ARM.calibration.json (ARM.NAME.calibration.json with --name), which every command lays over the
    arm's description from then on; an older one is kept beside it. No servo is written to, unless
    the second servo of a dual joint must be aligned: that is shown and asked for.

    Exit status of --check: 3 when the arm differs from its calibration.
    """
    from armsyn.arm import load_arm
    from armsyn.driver.transactions import Bus
    from armsyn.errors import DescriptionError

    arm = load_arm(options["arm_name"], options["calibration"], calibrated=False)
    if not arm.servo:
        raise DescriptionError(f"{arm.name} has no servos: it is a model only")
    if options["check"]:
        from armsyn.cli.calibrate_check import check

        check(arm, options)
        return
    target = _target(arm, options)
    with closing(Bus(options["port"], arm.servo[0].baud)) as bus:
        calibration = _find(bus, arm, options)
    _report(arm, calibration, target, options)


def _target(arm: ArmDescription, options: dict[str, Any]) -> Path:
    """Where the calibration goes; known to be a good name before anybody moves anything."""
    from armsyn.arm.calibration_file import SUFFIX, file_stem, folder_for_writing

    stem = file_stem(arm.name, options["name"])
    folder = folder_for_writing(arm.name, options["calibration"]).absolute()
    return folder / f"{stem}{SUFFIX}"


def _find(bus: Bus, arm: ArmDescription, options: dict[str, Any]) -> ArmCalibration:
    from armsyn.cli.calibrate_dialogue import Dialogue
    from armsyn.cli.prompts import person
    from armsyn.driver.calibrating import ArmCalibrator

    dialogue = Dialogue(ArmCalibrator(bus, arm), person(), options)
    dialogue.rest()
    dialogue.align()
    if options["method"] == "hand":
        for joint in dialogue.calibrator.joints:
            dialogue.joint(joint)
        dialogue.rest_again()
    return dialogue.calibrator.result(options["method"], options["name"])


def _report(
    arm: ArmDescription, calibration: ArmCalibration, target: Path, options: dict[str, Any]
) -> None:
    from armsyn.arm.calibration_file import is_found_from_everywhere, with_calibration
    from armsyn.cli.calibrate_report import document, show, write
    from armsyn.cli.prompts import next_command, person
    from armsyn.errors import InputError, ServoMismatchError

    show(arm, calibration)
    try:
        with_calibration(arm, calibration)
    except InputError as error:
        raise ServoMismatchError(f"nothing was written: {error}") from error
    asked = person()
    replaces = f" (the one there is kept as {target.name}.old)" if target.exists() else ""
    written = options["yes"] or asked.confirm(f"Write {target}{replaces}?")
    if written:
        write(calibration, target)
    asked.say(f"wrote {target}" if written else "nothing was written")
    if written and not is_found_from_everywhere(target):
        asked.say(
            "commands that run in another folder do not find it there: give them --calibration"
            f" {target.parent}, or set ARMSYN_CALIBRATION to that"
        )
    if written:
        command = next_command("status --watch", options)
        asked.say(f"next: {command}; move each joint and look whether its angle follows")
    if options["as_json"]:
        import json

        result = document(calibration, target if written else None)
        click.echo(json.dumps(result, indent=2, allow_nan=False))
