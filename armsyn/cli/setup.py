"""`armsyn setup`: servos get their IDs, baud rate and settings."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.baud import BAUD

if TYPE_CHECKING:
    from collections.abc import Sequence

    from armsyn.arm import ArmDescription, ServoDescription
    from armsyn.cli.prompts import Person
    from armsyn.driver.setup import ServoPlan
    from armsyn.driver.setup_plan import Change
    from armsyn.driver.transactions import Bus


@click.command()
@click.option("--arm", "arm_name", required=True, metavar="NAME", help="Whose servos they become.")
@click.option("--port", required=True, metavar="PATH", help="Serial port.")
@click.option(
    "--servo",
    "ids",
    type=click.IntRange(0, 252),
    multiple=True,
    metavar="ID",
    help="Only the servo that is to have this ID; may be given several times.",
)
@click.option(
    "--all",
    "together",
    is_flag=True,
    help="The servos are together on one bus and have their IDs: write what differs.",
)
@click.option(
    "--baud",
    type=BAUD,
    metavar="N",
    help="Rate that they have now, bit/s (1M: 1000000); with --all the description's is tried"
    " as well  [default: found out; with --all only the description's].",
)
@click.option(
    "--calibration",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The only folder to look for the arm's files in, its description as well, and where the"
    " backup goes.",
)
@click.option("--dry-run", is_flag=True, help="Show what would be written, write nothing.")
@click.option("--yes", is_flag=True, help="Write without asking.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def setup(**options: Any) -> None:
    """Give servos the IDs, baud rate and settings that an arm's description asks for.

    One at a time: connect only the servo that is asked for, and it is found at whatever ID, baud
    rate and protocol it has. What differs is shown, written when you say so, and read back. Before
    anything is written, all of the servo's EEPROM goes into ARM-DATE.eeprom.json, which armsyn
    restore writes back. A servo that holds with its torque on is refused.
    """
    from armsyn.arm import load_arm
    from armsyn.arm.calibration_file import folder_for_writing
    from armsyn.cli.prompts import person
    from armsyn.driver.eeprom_file import BackupFile
    from armsyn.driver.transactions import Bus
    from armsyn.errors import DescriptionError

    arm = load_arm(options["arm_name"], options["calibration"], calibrated=False)
    if not arm.servo:
        raise DescriptionError(f"{arm.name} has no servos: it is a model only")
    servos = _chosen(arm, options["ids"])
    folder = folder_for_writing(arm.name, options["calibration"])
    backup = BackupFile(folder, arm.name, options["port"])
    work = _Setup(arm, servos, backup, person(), options)
    with closing(Bus(options["port"], options["baud"] or servos[0].baud)) as bus:
        if options["together"]:
            work.together(bus)
        else:
            work.one_by_one(bus)
    work.tell_next()
    if options["as_json"]:
        import json

        click.echo(json.dumps(work.document, indent=2, allow_nan=False))


def _chosen(arm: ArmDescription, ids: Sequence[int]) -> tuple[ServoDescription, ...]:
    from armsyn.errors import InputError

    known = {servo.id: servo for servo in arm.servo}
    for servo_id in ids:
        if servo_id not in known:
            raise InputError(
                f"--servo {servo_id}: {arm.name} has the servos {', '.join(map(str, known))}"
            )
    return tuple(known[i] for i in ids) if ids else arm.servo


class _Setup:
    """The dialogue, and what came of it."""

    def __init__(
        self,
        arm: ArmDescription,
        servos: tuple[ServoDescription, ...],
        backup: Any,
        person: Person,
        options: dict[str, Any],
    ) -> None:
        self._arm = arm
        self._servos = servos
        self._backup = backup
        self._person = person
        self._options = options
        self.document: dict[str, Any] = {"arm": arm.name, "port": options["port"], "servos": []}

    def one_by_one(self, bus: Bus) -> None:
        from armsyn.driver.setup import find_lone_servo, plan_servo

        for servo in self._servos:
            if not self._connected(servo):
                self._person.say(f"servo {servo.id} ({servo.joint}) left out")
                continue
            with _progress() as show:
                bauds = (self._options["baud"],) if self._options["baud"] else None
                found = find_lone_servo(bus, servo, bauds, show)
            plan = plan_servo(bus, self._arm, servo, found)
            self._carry_out(bus, (plan,))

    def _connected(self, servo: ServoDescription) -> bool:
        """Ask for a servo to be connected, unless it is the only one and --yes says it is."""
        from armsyn.driver.models import a_model

        if self._options["yes"] and len(self._servos) == 1:
            return True
        answer = self._person.ask(
            f"Switch the power off, connect only the servo for {servo.joint}"
            f" ({a_model(servo.model)}, to become ID {servo.id}), switch it on, and press"
            " Enter (s: leave it out)"
        )
        return answer not in ("s", "skip")

    def together(self, bus: Bus) -> None:
        from armsyn.driver.setup import plan_arm

        self._carry_out(bus, plan_arm(bus, self._arm, self._servos))

    def tell_next(self) -> None:
        """Name the next step when all servos of the arm are set up."""
        from armsyn.cli.prompts import next_command

        done = [s for s in self.document["servos"] if s["written"] or not s["changes"]]
        if len(done) < len(self._arm.servo):
            return
        together = "" if self._options["together"] else "connect all servos to each other, then "
        self._person.say(f"next: {together}{next_command('calibrate', self._options)}")

    def _carry_out(self, bus: Bus, plans: tuple[ServoPlan, ...]) -> None:
        from armsyn.cli.setup_changes import allowed
        from armsyn.driver.setup_write import write_changes

        for plan in plans:
            self._show(plan)
        due = tuple(plan for plan in plans if plan.changes)
        changes = tuple(change for plan in due for change in plan.changes)
        written = bool(due) and allowed(changes, self._options, self._person)
        self.document["servos"] += [_entry(plan, written=written) for plan in plans]
        if not written:
            return
        for plan in due:
            self._backup.add(plan.image, _reach(plan))
        self.document["backup"] = str(self._backup.path)
        self._person.say(f"backup: {self._backup.path}")
        images = {plan.servo.id: plan.image for plan in due}
        for step in (_settings, _rate):  # a new rate cuts a servo off from the others
            for plan in due:
                changes = step(plan.changes, alone=len(plans) == 1)
                if changes:
                    image = images[plan.servo.id]
                    images[plan.servo.id] = write_changes(bus, image, changes, plan.title)
        for plan in due:
            self._person.say(f"{plan.title}: written and read back")
        if any(_counts_anew(plan) for plan in due):
            self._person.say("positions count another way than before: run armsyn calibrate")

    def _show(self, plan: ServoPlan) -> None:
        from rich.console import Console

        from armsyn.cli.setup_changes import changes_table
        from armsyn.driver.models import a_model

        found = plan.image.found
        self._person.say(
            f"{plan.title}: {a_model(found.model)}, firmware"
            f" {plan.image.registers['Firmware Version']}, found as ID"
            f" {found.servo_id} at {found.baud} baud, protocol {found.protocol}.0"
        )
        if plan.changes:
            Console(stderr=True).print(changes_table(plan.changes))
        else:
            self._person.say("  is set up already")


def _settings(changes: tuple[Change, ...], *, alone: bool) -> tuple[Change, ...]:
    return tuple(change for change in changes if alone or change.name != "Baud Rate")


def _rate(changes: tuple[Change, ...], *, alone: bool) -> tuple[Change, ...]:
    return tuple(change for change in changes if not alone and change.name == "Baud Rate")


def _counts_anew(plan: ServoPlan) -> bool:
    return any(
        change.name == "Homing Offset"
        or (change.name == "Drive Mode" and (change.found ^ change.wanted) & 1)
        for change in plan.changes
    )


def _reach(plan: ServoPlan) -> Any:
    from armsyn.driver.eeprom_file import Reach

    target = plan.target
    return Reach(target.servo_id, 1 if target.protocol == 1 else 2, target.baud)


def _entry(plan: ServoPlan, *, written: bool) -> dict[str, Any]:
    from armsyn.cli.setup_changes import entry

    servo = plan.servo
    described = {"id": servo.id, "joint": servo.joint}
    return described | entry(plan.image, plan.changes, written=written)


def _progress() -> Any:
    from armsyn.cli.scan import progress_bar

    return progress_bar()
