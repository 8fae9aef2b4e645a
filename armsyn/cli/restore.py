"""`armsyn restore`: a backup of servos' EEPROM is written back."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from armsyn.cli.prompts import Person
    from armsyn.driver.setup_restore import RestorePlan
    from armsyn.driver.transactions import Bus


@click.command()
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--port", required=True, metavar="PATH", help="Serial port.")
@click.option(
    "--servo",
    "servo_id",
    type=click.IntRange(0, 253),
    metavar="ID",
    help="Only the servo that has, or had, this ID.",
)
@click.option("--dry-run", is_flag=True, help="Show what would be written, write nothing.")
@click.option("--yes", is_flag=True, help="Write without asking.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def restore(**options: Any) -> None:
    """Write a backup (ARM-DATE.eeprom.json) of servos' EEPROM back.

    Each servo is looked for where its set-up put it, then where it was before. What differs is
    shown, written when you say so, and read back; ID and baud rate come last. What the servo holds
    now is backed up first. Another model than the backup's is refused.
    """
    from armsyn.cli.prompts import person
    from armsyn.cli.setup_changes import allowed, entry
    from armsyn.driver.eeprom_file import BackupFile, read_backup
    from armsyn.driver.setup_restore import plan_restore
    from armsyn.driver.transactions import Bus

    path = options["file"]
    backup = read_backup(path)
    asked = person()
    with closing(Bus(options["port"], backup.servo[0].becomes.baud)) as bus:
        plans = plan_restore(bus, backup, path, options["servo_id"])
        for plan in plans:
            _show(plan, asked)
        due = tuple(plan for plan in plans if plan.changes)
        kept = None
        changes = tuple(change for plan in due for change in plan.changes)
        written = bool(due) and allowed(changes, options, asked)
        if written:
            kept = BackupFile(path.resolve().parent, backup.arm, options["port"])
            _write(bus, due, kept, asked)
    if options["as_json"]:
        import json

        entries = [
            entry(plan.image, plan.changes, written=written and bool(plan.changes))
            for plan in plans
        ]
        document = {"file": str(path), "port": options["port"], "servos": entries}
        document["backup"] = None if kept is None else str(kept.path)
        click.echo(json.dumps(document, indent=2, allow_nan=False))


def _show(plan: RestorePlan, asked: Person) -> None:
    from rich.console import Console

    from armsyn.cli.setup_changes import changes_table

    found = plan.image.found
    firmware = plan.image.registers["Firmware Version"]
    asked.say(
        f"{plan.title}, firmware {firmware}, at {found.baud} baud, protocol {found.protocol}.0"
    )
    if firmware != plan.backup.firmware:
        asked.say(f"  the backup is of firmware {plan.backup.firmware}")
    if plan.changes:
        Console(stderr=True).print(changes_table(plan.changes))
    else:
        asked.say("  is as in the backup")


def _write(bus: Bus, due: tuple[RestorePlan, ...], kept: Any, asked: Person) -> None:
    from armsyn.driver.setup_write import write_changes

    for plan in due:
        kept.add(plan.image, plan.backup.was)
    asked.say(f"backup: {kept.path}")
    for plan in due:
        write_changes(bus, plan.image, plan.changes, plan.title)
        asked.say(f"{plan.title}: written and read back")
