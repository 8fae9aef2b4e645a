"""Writing a backup of servos' EEPROM back."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from armsyn.driver.eeprom import (
    IDENTITY,
    STATUS_RETURN_LEVEL,
    EepromImage,
    check_limp,
    eeprom_rows,
    read_eeprom,
)
from armsyn.driver.eeprom_file import Backup, Reach, ServoBackup
from armsyn.driver.models import a_model, find_number, model_name
from armsyn.driver.scan import FoundServo
from armsyn.driver.setup_plan import Change, changes_of, place_last
from armsyn.driver.setup_write import check_vacant, destination
from armsyn.driver.transactions import Bus
from armsyn.errors import BusTimeoutError, FormatError, ServoMismatchError, ServoMissingError


@dataclass(frozen=True)
class RestorePlan:
    """What is to be written to a servo.

    Attributes
    ----------
    backup : ServoBackup
    image : EepromImage
        What the servo holds now.
    changes : tuple of Change
    """

    backup: ServoBackup
    image: EepromImage
    changes: tuple[Change, ...]

    @property
    def title(self) -> str:
        """Name for messages."""
        return f"servo {self.image.found.servo_id} ({self.backup.model})"


def plan_restore(
    bus: Bus, backup: Backup, path: Path, servo_id: int | None = None
) -> tuple[RestorePlan, ...]:
    """Find the servos of a backup and say what is to be written. Nothing is written.

    A servo is looked for where its set-up put it, then where it was before. Servos of these
    families have no serial number: the model, and Model Information where the servo has it, are
    what tells that it is the one.

    Parameters
    ----------
    bus : Bus
    backup : Backup
    path : Path
        Of the backup, for messages.
    servo_id : int, optional
        Only the servo with that ID, new or old.

    Returns
    -------
    tuple of RestorePlan

    Raises
    ------
    FormatError
        A backup of registers that its models do not have, or none of `servo_id`.
    ServoMissingError
        A servo answers in neither place.
    ServoMismatchError
        Another model answers there, or several servos would get one ID; the old place is taken.
    TorqueOnError
        One holds.
    BusError, PortLostError
        As the bus.
    """
    chosen = [s for s in backup.servo if servo_id in (None, s.was.id, s.becomes.id)]
    if not chosen:
        raise FormatError(f"{path}: no servo with ID {servo_id} in it")
    for servo in chosen:
        _check_registers(servo, path)
    goals = [(s.was.baud, s.was.protocol, s.was.id) for s in chosen]
    if len(set(goals)) < len(goals):
        raise ServoMismatchError(
            f"{path}: several of its servos had one ID, and would answer all at once: connect one"
            " at a time, and name it by --servo ID (the ID it has now)"
        )
    return tuple(_plan(bus, servo, path) for servo in chosen)


def _check_registers(servo: ServoBackup, path: Path) -> None:
    model = find_number(servo.model_number)
    if model is None:
        raise FormatError(f"{path}: model number {servo.model_number} is not one the driver knows")
    rows = {row.name: row for row in eeprom_rows(model.layout)}
    for name, value in servo.registers.items():
        if name == STATUS_RETURN_LEVEL and name not in rows:
            continue  # in RAM, where the power-on value is right
        if name not in rows:
            raise FormatError(f"{path}: {a_model(servo.model)} has no {name} in its EEPROM")
        try:
            rows[name].encode(value)
        except OverflowError as error:
            raise FormatError(f"{path}: {value} does not fit into {name}") from error


def _plan(bus: Bus, backup: ServoBackup, path: Path) -> RestorePlan:
    found = _find(bus, backup)
    _check_identity(bus, backup, found, path)
    image = read_eeprom(bus, found)
    information = backup.registers.get("Model Information", 0)
    if image.registers.get("Model Information", 0) != information:
        raise ServoMismatchError(
            f"servo {found.servo_id} on {bus.port_name} is another one than {path} is of (Model"
            f" Information reads {image.registers.get('Model Information')}, not {information})"
        )
    check_limp(bus, ((found.servo_id, image.model, f"servo {found.servo_id}"),))
    changes = place_last(changes_of(image, _wanted(backup, image)))
    plan = RestorePlan(backup, image, changes)
    check_vacant(bus, image, destination(image, changes), plan.title)
    return plan


def _find(bus: Bus, backup: ServoBackup) -> FoundServo:
    for place in dict.fromkeys((backup.becomes, backup.was)):
        found = _ask(bus, place)
        if found is not None:
            return found
    was, becomes = backup.was, backup.becomes
    raise ServoMissingError(
        f"no answer on {bus.port_name} from the {backup.model} that was ID {was.id} at"
        f" {was.baud} baud and became ID {becomes.id} at {becomes.baud} baud: armsyn scan shows who"
        " answers; --servo ID restores one of several",
        (becomes.id,),
    )


def _ask(bus: Bus, place: Reach) -> FoundServo | None:
    bus.setBaudRate(place.baud)
    bus.protocols[place.id] = place.protocol
    try:
        number, firmware = bus.ping(place.id)
    except BusTimeoutError:
        return None
    return FoundServo(place.baud, place.protocol, place.id, number, firmware)


def _check_identity(bus: Bus, backup: ServoBackup, found: FoundServo, path: Path) -> None:
    if found.model_number != backup.model_number:
        there = "unknown" if found.model_number is None else model_name(found.model_number)
        raise ServoMismatchError(
            f"servo {found.servo_id} on {bus.port_name} is {a_model(there)}, {path} is of"
            f" {a_model(backup.model)}: nothing was written"
        )


def _wanted(backup: ServoBackup, image: EepromImage) -> dict[str, int]:
    names = {row.name for row in eeprom_rows(image.model.layout)}
    wanted = {
        name: value
        for name, value in backup.registers.items()
        if name in names and name not in IDENTITY
    }
    if STATUS_RETURN_LEVEL in wanted:  # at level 0 nothing could be read back any more
        wanted[STATUS_RETURN_LEVEL] = max(1, wanted[STATUS_RETURN_LEVEL])
    return wanted
