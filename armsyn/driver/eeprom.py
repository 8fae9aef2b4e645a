"""EEPROM of servos: what keeps its value without power, read whole and as registers.

Rows: ROBOTIS e-Manual, "Control Table of EEPROM Area" of the X series, MX series (both protocols),
AX-12A and XL-320. One list a family: where a model lacks a register, its place reads 0, and as
only differences are ever written, nothing is written there.
"""

from __future__ import annotations

from dataclasses import dataclass

from armsyn.driver.models import ServoModel, find_number
from armsyn.driver.registers import AX, MX1, XL320, Layout, Register, X
from armsyn.driver.scan import FoundServo
from armsyn.driver.transactions import Bus
from armsyn.errors import BusTimeoutError, ServoMismatchError, TorqueOnError


def _eeprom(layout: Layout, *more: Register) -> tuple[Register, ...]:
    """Rows that the driver uses anyway and `more`, by address."""
    used = (row for row in layout.rows.values() if layout.in_eeprom(row.name))
    return tuple(sorted((*used, *more), key=lambda row: row.address))


_ALARM_LED = Register("Alarm LED", 17, 1)

_ROWS = {
    X: _eeprom(
        X,
        Register("Model Information", 2, 4),
        Register("Moving Threshold", 24, 4),
        Register("Acceleration Limit", 40, 4),
        Register("External Port Mode 1", 56, 1),
        Register("External Port Mode 2", 57, 1),
        Register("External Port Mode 3", 58, 1),
        Register("Startup Configuration", 60, 1),
        Register("PWM Slope", 62, 1),
    ),
    XL320: _eeprom(XL320),
    AX: _eeprom(AX, _ALARM_LED),
    MX1: _eeprom(
        MX1,
        _ALARM_LED,
        Register("Drive Mode", 10, 1),
        Register("Multi Turn Offset", 20, 2, "signed"),
        Register("Resolution Divider", 22, 1),
    ),
}
_SIZES = {X: 64, XL320: 19, AX: 19, MX1: 24}

IDENTITY = ("Model Number", "Model Information", "Firmware Version")
"""What cannot be written."""

PLACE = ("ID", "Protocol Type", "Baud Rate")
"""What says how a servo is reached; written last, in this order."""

STATUS_RETURN_LEVEL = "Status Return Level"
"""In RAM of the X series, where it is 2 after power-on."""


def eeprom_rows(layout: Layout) -> tuple[Register, ...]:
    """Registers in the EEPROM of a family, by address."""
    return _ROWS[layout]


def row_of(layout: Layout, name: str) -> Register:
    """Return a register, in EEPROM or, of those the driver uses, in RAM; KeyError for none."""
    for row in _ROWS[layout]:
        if row.name == name:
            return row
    return layout[name]


@dataclass(frozen=True)
class EepromImage:
    """What the EEPROM of a servo holds.

    Attributes
    ----------
    found : FoundServo
        Where it answered.
    model : ServoModel
        In whose table the registers are.
    registers : dict of str to int
        By name, in each register's own unit; the X series' Status Return Level (in RAM) as well.
    """

    found: FoundServo
    model: ServoModel
    registers: dict[str, int]


def model_of(found: FoundServo) -> ServoModel:
    """Facts of a servo's model; ServoMismatchError for one that the driver does not know."""
    model = None if found.model_number is None else find_number(found.model_number)
    if model is not None:
        return model
    if found.model_number is None:
        raise ServoMismatchError(
            f"servo {found.servo_id} at {found.baud} baud answers nothing but pings: its Status"
            " Return Level is 0; set it to 2 with the maker's DYNAMIXEL Wizard"
        )
    raise ServoMismatchError(
        f"servo {found.servo_id} at {found.baud} baud is a model that this driver does not know"
        f" ({found.model}): it is left as it is"
    )


def read_eeprom(bus: Bus, found: FoundServo) -> EepromImage:
    """Read the EEPROM of a servo. The bus is at the servo's baud rate.

    Parameters
    ----------
    bus : Bus
        Told the servo's protocol.
    found : FoundServo

    Returns
    -------
    EepromImage

    Raises
    ------
    ServoMismatchError
        A model that the driver does not know, or a servo that answers nothing but pings.
    BusError, PortLostError
        As the bus.
    """
    model = model_of(found)
    bus.protocols[found.servo_id] = found.protocol
    whole = Register("EEPROM", 0, _SIZES[model.layout])
    try:
        data = whole.encode(bus.read(found.servo_id, whole))
    except BusTimeoutError as error:
        raise ServoMismatchError(
            f"servo {found.servo_id} at {found.baud} baud answers a ping but no read: its Status"
            " Return Level may be 0; switch it off and on, or set it to 2 with DYNAMIXEL Wizard"
        ) from error
    registers = {
        row.name: row.decode(data[row.address : row.address + row.size])
        for row in _ROWS[model.layout]
    }
    if STATUS_RETURN_LEVEL not in registers:
        level = model.layout[STATUS_RETURN_LEVEL]
        registers[STATUS_RETURN_LEVEL] = bus.read(found.servo_id, level)
    return EepromImage(found, model, registers)


def check_limp(bus: Bus, servos: tuple[tuple[int, ServoModel, str], ...]) -> None:
    """Refuse servos under torque: their EEPROM is locked, and letting go is the owner's word.

    Parameters
    ----------
    bus : Bus
    servos : tuple of (int, ServoModel, str)
        ID, model and name for messages of each.

    Raises
    ------
    TorqueOnError
        One holds; nothing was written.
    BusError, PortLostError
        As the bus.
    """
    for servo_id, model, title in servos:
        if bus.read(servo_id, model.layout["Torque Enable"]):
            raise TorqueOnError(
                f"{title} on {bus.port_name} holds with its torque on, and its settings can only be"
                " written without: support the arm, then armsyn release",
                servo_id,
            )
