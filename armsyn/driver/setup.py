"""Setting an arm's servos up: one at a time on the line, or all of an arm that is together."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass

from armsyn.arm import ArmDescription, ServoDescription
from armsyn.driver.eeprom import EepromImage, check_limp, read_eeprom
from armsyn.driver.models import a_model, servo_model
from armsyn.driver.scan import BAUD_RATES, FoundServo, ScanProgress, ScanResult, restored_baud, scan
from armsyn.driver.servos import title_of
from armsyn.driver.setup_plan import Change, changes_of, wanted_settings
from armsyn.driver.setup_write import check_vacant, destination
from armsyn.driver.transactions import Bus
from armsyn.errors import (
    BusTimeoutError,
    ServoMismatchError,
    ServoMissingError,
)

_FACTORY_BAUD_RATES = (57_600, 1_000_000)
"""X and MX series; AX series and XL-320 (e-Manual, initial values of Baud Rate)."""


@dataclass(frozen=True)
class ServoPlan:
    """What is to be written to a servo.

    Attributes
    ----------
    servo : ServoDescription
        What it is to be.
    image : EepromImage
        What it is.
    changes : tuple of Change
        None if it is set up already.
    """

    servo: ServoDescription
    image: EepromImage
    changes: tuple[Change, ...]

    @property
    def title(self) -> str:
        """Name for messages."""
        return title_of(self.servo)

    @property
    def target(self) -> FoundServo:
        """How the servo is reached afterwards."""
        return destination(self.image, self.changes)


def find_lone_servo(
    bus: Bus,
    servo: ServoDescription,
    bauds: Sequence[int] | None = None,
    on_progress: ScanProgress | None = None,
) -> FoundServo:
    """Find the only servo on the line, at whatever baud rate and ID, in either protocol.

    The arm's rate and those that servos leave the factory with are tried first, all of them even
    when one has answered; then the others until one answers.

    Parameters
    ----------
    bus : Bus
        At the servo's baud rate afterwards.
    servo : ServoDescription
        That it is to become.
    bauds : sequence of int, optional
        Look only here.
    on_progress : callable, optional
        As of `armsyn.driver.scan.scan`.

    Returns
    -------
    FoundServo

    Raises
    ------
    ServoMissingError
        Nobody answers.
    ServoMismatchError
        More than one servo, or another model.
    PortLostError
        The port went away.
    """
    usual = tuple(dict.fromkeys((servo.baud, *_FACTORY_BAUD_RATES)))
    first = tuple(bauds) if bauds else usual
    others = () if bauds else tuple(baud for baud in BAUD_RATES if baud not in usual)
    result = scan(bus, first, on_progress=on_progress)
    for baud in others:
        if result.servos or result.suspects:
            break
        result = scan(bus, (baud,), on_progress=on_progress)
    found = _only_one(bus, servo, result)
    bus.setBaudRate(found.baud)
    bus.protocols[found.servo_id] = found.protocol
    _check_model(bus, servo, found)
    return found


def _only_one(bus: Bus, servo: ServoDescription, result: ScanResult) -> FoundServo:
    if result.suspects:
        suspect = result.suspects[0]
        raise ServoMismatchError(
            f"what ID {suspect.servo_id} at {suspect.baud} baud on {bus.port_name} answers is"
            f" garbled: two servos of that ID, most likely; connect only the one for {servo.joint}"
        )
    if not result.servos:
        raise ServoMissingError(
            f"no servo answers on {bus.port_name} at any baud rate: check its power and cable, and"
            f" that the one for {servo.joint} is connected",
            (servo.id,),
        )
    if len(result.servos) > 1:
        named = ", ".join(f"{s.servo_id} ({s.model}, {s.baud} baud)" for s in result.servos)
        raise ServoMismatchError(
            f"{len(result.servos)} servos answer on {bus.port_name}: {named}; connect only the one"
            f" for {servo.joint}"
        )
    return result.servos[0]


def _check_model(bus: Bus, servo: ServoDescription, found: FoundServo) -> None:
    model = servo_model(servo.model, servo.protocol)
    if found.model_number is not None and found.model_number != model.number:
        raise ServoMismatchError(
            f"servo {found.servo_id} on {bus.port_name} is {a_model(found.model)},"
            f" {servo.joint} needs {a_model(servo.model)} that speaks protocol {servo.protocol}:"
            " connect the right one, or correct the description; nothing was written"
        )


def plan_servo(
    bus: Bus, arm: ArmDescription, servo: ServoDescription, found: FoundServo
) -> ServoPlan:
    """Read a servo's settings and say what is to be written.

    The bus is at the rate where it was found afterwards.

    Raises
    ------
    TorqueOnError
        It holds.
    ServoMismatchError, DescriptionError
        It cannot be read, or not become what is described; somebody answers in its new place.
    BusError, PortLostError
        As the bus.
    """
    bus.setBaudRate(found.baud)
    image = read_eeprom(bus, found)
    check_limp(bus, ((found.servo_id, image.model, title_of(servo)),))
    plan = ServoPlan(servo, image, changes_of(image, wanted_settings(arm, servo, image)))
    check_vacant(bus, image, plan.target, plan.title)
    return plan


def plan_arm(
    bus: Bus, arm: ArmDescription, servos: Sequence[ServoDescription] | None = None
) -> tuple[ServoPlan, ...]:
    """Plan the servos of an arm that is on one bus, with IDs as described. Nothing is written.

    Each is looked for at the bus's rate, then at its described one: a set-up that was cut short
    leaves an arm with both.

    Parameters
    ----------
    bus : Bus
    arm : ArmDescription
    servos : sequence of ServoDescription, optional
        Only these.

    Returns
    -------
    tuple of ServoPlan
        One a servo.

    Raises
    ------
    ServoMissingError
        Some do not answer: all of them are named.
    ServoMismatchError, TorqueOnError, BusError, PortLostError
        As `plan_servo`.
    """
    chosen = tuple(arm.servo if servos is None else servos)
    found = _find_described(bus, chosen)
    missing = [servo for servo in chosen if servo.id not in found]
    if missing:
        named = ", ".join(f"{servo.id} ({servo.joint})" for servo in missing)
        rates = " or ".join(map(str, dict.fromkeys((bus.baudrate, *(s.baud for s in missing)))))
        raise ServoMissingError(
            f"no answer from servo {named} of {arm.name} on {bus.port_name} at {rates} baud:"
            " armsyn scan shows who answers; armsyn setup --servo ID sets up one at a time",
            tuple(servo.id for servo in missing),
        )
    for servo in chosen:
        _check_model(bus, servo, found[servo.id])
    return tuple(plan_servo(bus, arm, servo, found[servo.id]) for servo in chosen)


def _find_described(bus: Bus, servos: Sequence[ServoDescription]) -> dict[int, FoundServo]:
    """Servos that answer under their ID, at the bus's present rate or the described one."""
    found: dict[int, FoundServo] = {}
    with restored_baud(bus):
        for baud in dict.fromkeys((bus.baudrate, *(servo.baud for servo in servos))):
            bus.setBaudRate(baud)
            for servo in servos:
                if servo.id in found:
                    continue
                bus.protocols[servo.id] = servo.protocol
                with contextlib.suppress(BusTimeoutError):
                    number, firmware = bus.ping(servo.id)
                    found[servo.id] = FoundServo(baud, servo.protocol, servo.id, number, firmware)
    return found
