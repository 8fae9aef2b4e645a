"""Writing settings of servos, each read back; how a servo is reached changes last.

Written by sync write, which no servo answers: so it works at every Status Return Level, and the
answer to a change of ID or baud rate need not be guessed. Reading back is what shows that it took.
A request to stop (Ctrl-C) is met between servos, not within one.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace

from armsyn.driver.eeprom import EepromImage, check_limp, read_eeprom, row_of
from armsyn.driver.models import a_model
from armsyn.driver.protocol import MAXIMUM_ID as LAST_ID
from armsyn.driver.scan import CLASSIC_BAUD_RATES, X_BAUD_RATES, FoundServo
from armsyn.driver.scan_probe import Probe
from armsyn.driver.setup_plan import Change, baud_code, place_last
from armsyn.driver.signals import StopRequests
from armsyn.driver.transactions import Bus
from armsyn.errors import (
    BusTimeoutError,
    DescriptionError,
    HardwareFaultError,
    ServoMismatchError,
    ServoStatusError,
)

_LOOKS = 3
"""How often a register is read back before it counts as refused."""


_SETTLING = 0.05
"""Seconds after which a servo is looked for at its new ID, protocol or baud rate."""


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Hold requests to stop back until the block has ended, then raise KeyboardInterrupt."""
    with StopRequests() as stops:
        yield
    if stops.count:
        raise KeyboardInterrupt


def destination(image: EepromImage, changes: tuple[Change, ...]) -> FoundServo:
    """How a servo is reached once it is changed."""
    wanted = {change.name: change.wanted for change in changes}
    found = image.found
    return replace(
        found,
        servo_id=wanted.get("ID", found.servo_id),
        protocol=wanted.get("Protocol Type", found.protocol),
        baud=_baud_of(image, wanted["Baud Rate"]) if "Baud Rate" in wanted else found.baud,
    )


def _baud_of(image: EepromImage, code: int) -> int:
    for baud in (*X_BAUD_RATES, *CLASSIC_BAUD_RATES):
        with contextlib.suppress(DescriptionError):
            if baud_code(image.model, baud) == code:
                return baud
    raise DescriptionError(f"code {code} is no baud rate of {a_model(image.model.name)}")


def check_vacant(bus: Bus, image: EepromImage, target: FoundServo, title: str) -> None:
    """Refuse to give a servo a place on the bus where another one answers.

    Raises
    ------
    ServoMismatchError
        Somebody is there.
    PortLostError
        The port went away.
    """
    here = image.found
    if (here.servo_id, here.protocol, here.baud) == (target.servo_id, target.protocol, target.baud):
        return
    bus.setBaudRate(target.baud)
    probe = Probe(bus, target.protocol)
    answer = probe.ping(target.servo_id)
    # noise that any ID is answered with is what servos make of a baud rate that is not theirs
    talking = answer.garbled and not probe.ping((target.servo_id + 1) % LAST_ID).garbled
    bus.setBaudRate(here.baud)
    if answer.packets or talking:
        raise ServoMismatchError(
            f"{title} cannot become ID {target.servo_id} at {target.baud} baud on"
            f" {bus.port_name}: another servo answers there; connect only the one that is set up"
        )


def write_changes(
    bus: Bus, image: EepromImage, changes: tuple[Change, ...], title: str
) -> EepromImage:
    """Write a servo's changes and read them back.

    Parameters
    ----------
    bus : Bus
        Afterwards at the servo's new baud rate.
    image : EepromImage
        As found.
    changes : tuple of Change
    title : str
        Name of the servo for messages.

    Returns
    -------
    EepromImage
        As it is now, read anew.

    Raises
    ------
    TorqueOnError
        The servo holds: nothing was written.
    HardwareFaultError
        It does not take a value, or fell silent; the message says which and what to do.
    PortLostError
        The port went away.
    KeyboardInterrupt
        A stop was asked for meanwhile; all is written.
    """
    place, done = image.found, 0
    with uninterrupted():
        try:
            bus.setBaudRate(place.baud)
            check_limp(bus, ((place.servo_id, image.model, title),))
            for change in place_last(changes):
                place = _write(bus, image, place, change, title)
                done += 1
            now = read_eeprom(bus, place)
        except BusTimeoutError as error:
            raise HardwareFaultError(
                f"{title} fell silent while it was set up, {done} of {len(changes)} settings"
                " written: check its power and cable, and run the same command again: it finds the"
                " servo wherever it is",
                place.servo_id,
            ) from error
    return now


def _write(
    bus: Bus, image: EepromImage, place: FoundServo, change: Change, title: str
) -> FoundServo:
    """Write one register and read it back; returns where the servo is reached then."""
    register, target = change.register, place
    bus.sync_write(register, {place.servo_id: change.wanted})
    if change.name in ("ID", "Protocol Type", "Baud Rate"):
        target = destination(replace(image, found=place), (change,))
        bus.protocols[target.servo_id] = target.protocol
        _settle(bus)
        if target.baud != place.baud:
            bus.setBaudRate(target.baud)
    value: int | None = None
    for _ in range(_LOOKS):
        with contextlib.suppress(ServoStatusError, *([BusTimeoutError] if target != place else [])):
            value = bus.read(target.servo_id, register)
        if value == change.wanted:
            return target
    if value is None and target != place:
        return _moved_not(bus, image, place, change, title)
    raise _refused(image, change, value, title, place.servo_id)


def _settle(bus: Bus) -> None:
    """Let the adapter send all that it was given, and the servo become who it is told to be."""
    until = bus.serial_port.now() + _SETTLING
    while bus.serial_port.now() < until:
        bus.serial_port.read(until)


def _moved_not(
    bus: Bus, image: EepromImage, place: FoundServo, change: Change, title: str
) -> FoundServo:
    """Say that a servo has not gone where it was sent, if it still answers where it was."""
    bus.protocols[place.servo_id] = place.protocol
    bus.setBaudRate(place.baud)
    value = bus.read(place.servo_id, row_of(image.model.layout, change.name))
    raise _refused(image, change, value, title, place.servo_id)


def _refused(
    image: EepromImage, change: Change, value: int | None, title: str, servo_id: int
) -> HardwareFaultError:
    reads = "cannot be read" if value is None else f"reads {value}"
    return HardwareFaultError(
        f"{title} does not take {change.wanted} as its {change.name} (register"
        f" {change.register.address} {reads}): {a_model(image.model.name)} with firmware"
        f" {image.registers['Firmware Version']} may not know it; settings before it are written",
        servo_id,
    )
