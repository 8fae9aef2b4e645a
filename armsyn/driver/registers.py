"""Registers and models of the DYNAMIXEL X series that the driver uses.

One register is one row. Addresses, sizes and units: ROBOTIS e-Manual, "Control Table" of the
XM430-W350, XM540-W270, XL430-W250 and XL330-M288 (they agree on every row below). The
simulator has tables of its own; ``tests/contract`` compares both with a third source.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from armsyn.errors import DescriptionError

VELOCITY_UNIT = 0.229 * 2.0 * math.pi / 60.0
"""rad/s of one unit of the velocity registers (0.229 rev/min)."""

RETURN_DELAY_UNIT = 2e-6
"""Seconds of one unit of Return Delay Time."""

WATCHDOG_UNIT = 0.020
"""Seconds of one unit of Bus Watchdog."""

WATCHDOG_EXPIRED = -1
"""What Bus Watchdog reads once it has stopped the servo; writing 0 clears it."""

POSITION_MODE = 3
EXTENDED_POSITION_MODE = 4

DRIVE_MODE_REVERSE = 0b0001
"""Drive Mode bit 0: positions count the other way round."""

DRIVE_MODE_SLAVE = 0b0010
"""Drive Mode bit 1: the servo follows another one through a dual-joint cable, not its goals."""

DRIVE_MODE_TORQUE_BY_GOAL = 0b1000
"""Drive Mode bit 3: a goal that is written switches the torque on."""

HARDWARE_ERRORS = {
    0x01: "input voltage",
    0x04: "overheating",
    0x08: "encoder",
    0x10: "electrical shock",
    0x20: "overload",
}
"""Bits of Hardware Error Status (70)."""


@dataclass(frozen=True)
class Register:
    """One row of the control table.

    Parameters
    ----------
    name : str
        The e-Manual's name.
    address, size : int
        Where it lies, and its bytes.
    signed : bool
        Two's complement.
    """

    name: str
    address: int
    size: int
    signed: bool = False

    def decode(self, data: bytes) -> int:
        """Value of `size` bytes, in the register's own unit."""
        return int.from_bytes(data[: self.size], "little", signed=self.signed)

    def encode(self, value: int) -> bytes:
        """Bytes of a value; OverflowError when it does not fit."""
        return value.to_bytes(self.size, "little", signed=self.signed)


RETURN_DELAY_TIME = Register("Return Delay Time", 9, 1)
DRIVE_MODE = Register("Drive Mode", 10, 1)
OPERATING_MODE = Register("Operating Mode", 11, 1)
HOMING_OFFSET = Register("Homing Offset", 20, 4, signed=True)
MAX_POSITION_LIMIT = Register("Max Position Limit", 48, 4)
MIN_POSITION_LIMIT = Register("Min Position Limit", 52, 4)
TORQUE_ENABLE = Register("Torque Enable", 64, 1)
HARDWARE_ERROR_STATUS = Register("Hardware Error Status", 70, 1)
BUS_WATCHDOG = Register("Bus Watchdog", 98, 1, signed=True)
PROFILE_ACCELERATION = Register("Profile Acceleration", 108, 4)
PROFILE_VELOCITY = Register("Profile Velocity", 112, 4)
GOAL_POSITION = Register("Goal Position", 116, 4, signed=True)
PRESENT_CURRENT = Register("Present Current", 126, 2, signed=True)
PRESENT_VELOCITY = Register("Present Velocity", 128, 4, signed=True)
PRESENT_POSITION = Register("Present Position", 132, 4, signed=True)

REGISTERS = tuple(row for row in globals().values() if isinstance(row, Register))
"""All rows above."""

STATE_ADDRESS = PRESENT_CURRENT.address
STATE_SIZE = PRESENT_POSITION.address + PRESENT_POSITION.size - STATE_ADDRESS
"""Current, velocity and position lie side by side: one read of 10 bytes."""

HEALTH_ADDRESS = TORQUE_ENABLE.address
HEALTH_SIZE = HARDWARE_ERROR_STATUS.address + HARDWARE_ERROR_STATUS.size - HEALTH_ADDRESS
"""From torque enable to hardware error status: one read of 7 bytes."""


@dataclass(frozen=True)
class ServoModel:
    """What the driver must know of a model.

    Parameters
    ----------
    name : str
        The maker's name in lower case.
    number : int
        What Model Number reads.
    current_unit : float or None
        Amperes of one unit of Present Current; None where the servo reports load instead.
    """

    name: str
    number: int
    current_unit: float | None


MODELS = {
    model.name: model
    for model in (
        ServoModel("xm430-w350", 1020, 2.69e-3),
        ServoModel("xm430-w210", 1030, 2.69e-3),
        ServoModel("xl430-w250", 1060, None),
        ServoModel("xc430-w150", 1070, None),
        ServoModel("xc430-w240", 1080, None),
        ServoModel("2xl430-w250", 1090, None),
        ServoModel("xm540-w270", 1120, 2.69e-3),
        ServoModel("xm540-w150", 1130, 2.69e-3),
        ServoModel("xl330-m077", 1190, 1e-3),
        ServoModel("xl330-m288", 1200, 1e-3),
        ServoModel("xc330-t288", 1220, 1e-3),
        ServoModel("xc330-m288", 1240, 1e-3),
    )
}
"""Models by name (numbers: e-Manual, Model Number; units: e-Manual, Present Current)."""


def servo_model(name: str) -> ServoModel:
    """Facts of a model.

    Parameters
    ----------
    name : str
        Such as ``xm430-w350``.

    Returns
    -------
    ServoModel

    Raises
    ------
    DescriptionError
        A model this driver does not know.
    """
    try:
        return MODELS[name]
    except KeyError:
        known = ", ".join(MODELS)
        raise DescriptionError(
            f"servo model {name!r} is not one the driver knows: {known}"
        ) from None


def model_name(number: int) -> str:
    """Name of a model number, for messages: ``model number 17`` when unknown."""
    for model in MODELS.values():
        if model.number == number:
            return model.name
    return f"model number {number}"


def hardware_error_names(status: int) -> str:
    """Words for the bits of Hardware Error Status, such as ``overheating, overload``."""
    named = [name for bit, name in HARDWARE_ERRORS.items() if status & bit]
    unknown = status & ~sum(HARDWARE_ERRORS)
    return ", ".join([*named, *([f"unknown bits 0x{unknown:02x}"] if unknown else [])]) or "none"
