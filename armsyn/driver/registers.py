"""Registers of DYNAMIXEL servos that the driver uses: one layout a family, one row a register.

Names are those of the X series' manual pages, also where an older page has another one (CW Angle
Limit is Min Position Limit, Present Speed is Present Velocity, Present Voltage is Present Input
Voltage), so that what is asked of servos reads the same for all. Addresses and sizes: ROBOTIS
e-Manual, "Control Table" of the XM430-W350, XM540-W270, XL430-W250 and XL330-M288 (they agree on
every row below), of the XL-320, of the MX-28, MX-64 and MX-106 (Protocol 1.0), and of the AX-12A.
The simulator has tables of its own; ``tests/contract`` compares both with a third source.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

Coding = Literal["unsigned", "signed", "direction"]
"""How a number is written: as it is, as two's complement, or with its sign in bit 10."""

RETURN_DELAY_UNIT = 2e-6
"""Seconds of one unit of Return Delay Time."""

WATCHDOG_UNIT = 0.020
"""Seconds of one unit of Bus Watchdog."""

TICK_UNIT = 1e-3
"""Seconds of one unit of Realtime Tick."""

WATCHDOG_EXPIRED = -1
"""What Bus Watchdog reads once it has stopped the servo; writing 0 clears it."""

VOLTAGE_UNIT = 0.1
"""V of one unit of the voltage registers."""

VELOCITY_MODE = 1
XL320_JOINT_MODE = 2
POSITION_MODE = 3
EXTENDED_POSITION_MODE = 4
CURRENT_POSITION_MODE = 5

DRIVE_MODE_REVERSE = 0b0001
"""Drive Mode bit 0: positions count the other way round."""

DRIVE_MODE_SLAVE = 0b0010
"""Drive Mode bit 1: the servo follows another one through a dual-joint cable, not its goals."""

DRIVE_MODE_TIME_PROFILE = 0b0100
"""Drive Mode bit 2: profile registers hold milliseconds."""

DRIVE_MODE_TORQUE_BY_GOAL = 0b1000
"""Drive Mode bit 3: a goal that is written switches the torque on."""

LAST_TICK = 4095
"""Of one turn."""

NO_SECONDARY_ID = 253
"""Secondary ID from which on a servo follows nobody."""

HARDWARE_ERRORS = {
    0x01: "input voltage",
    0x04: "overheating",
    0x08: "encoder",
    0x10: "electrical shock",
    0x20: "overload",
}
"""Bits of Hardware Error Status (70)."""

_DIRECTION_BIT = 1 << 10
_UNKNOWN_ERROR = 0x40


def directed(raw: int) -> int:
    """Number whose sign is in bit 10: set is clockwise, which is where positions fall."""
    size = raw & (_DIRECTION_BIT - 1)
    return -size if raw & _DIRECTION_BIT else size


@dataclass(frozen=True)
class Register:
    """One row of a control table.

    Parameters
    ----------
    name : str
        The e-Manual's name.
    address, size : int
        Where it lies, and its bytes.
    coding : Coding
        How its number is written.
    since : int
        Firmware from which on servos have it.
    """

    name: str
    address: int
    size: int
    coding: Coding = "unsigned"
    since: int = 0

    def decode(self, data: bytes) -> int:
        """Value of `size` bytes, in the register's own unit."""
        raw = int.from_bytes(data[: self.size], "little", signed=self.coding == "signed")
        return directed(raw) if self.coding == "direction" else raw

    def encode(self, value: int) -> bytes:
        """Bytes of a value; OverflowError when it does not fit."""
        if self.coding == "direction":
            if abs(value) >= _DIRECTION_BIT:
                raise OverflowError(f"{value} does not fit into {self.name}")
            value = abs(value) | (_DIRECTION_BIT if value < 0 else 0)
        return value.to_bytes(self.size, "little", signed=self.coding == "signed")


@dataclass(frozen=True)
class Layout:
    """Control table of a family of servos.

    Parameters
    ----------
    name : str
        Of the family.
    rows : mapping of str to Register
        By the registers' names.
    ram : int
        Address from which on registers lie in RAM; those below are EEPROM, which X series and
        XL-320 keep locked while their torque is on.
    errors : mapping of int to int
        Bits of its Hardware Error Status to those of the X series, where they differ.
    """

    name: str
    rows: Mapping[str, Register]
    ram: int
    errors: Mapping[int, int]

    def __contains__(self, name: str) -> bool:
        """Whether the family has a register."""
        return name in self.rows

    def __getitem__(self, name: str) -> Register:
        """Return a register by its name; KeyError where the family has none."""
        return self.rows[name]

    def __hash__(self) -> int:
        """Families differ by their names."""
        return hash(self.name)

    def in_eeprom(self, name: str) -> bool:
        """Whether a register keeps its value without power, and is locked under torque."""
        return self.rows[name].address < self.ram

    def hardware_error(self, status: int) -> int:
        """Hardware Error Status of this family in the bits of the X series; 0x40 for unknown."""
        if not self.errors:
            return status
        known = sum(bit for own, bit in self.errors.items() if status & own)
        return known | (_UNKNOWN_ERROR if status & ~sum(self.errors) else 0)


def _layout(
    name: str, *rows: Register, ram: int = 24, errors: Mapping[int, int] | None = None
) -> Layout:
    named = MappingProxyType({row.name: row for row in rows})
    return Layout(name, named, ram, MappingProxyType(dict(errors or {})))


RETURN_DELAY_TIME = Register("Return Delay Time", 9, 1)
DRIVE_MODE = Register("Drive Mode", 10, 1, since=38)
OPERATING_MODE = Register("Operating Mode", 11, 1)
HOMING_OFFSET = Register("Homing Offset", 20, 4, "signed")
MAX_POSITION_LIMIT = Register("Max Position Limit", 48, 4)
MIN_POSITION_LIMIT = Register("Min Position Limit", 52, 4)
TORQUE_ENABLE = Register("Torque Enable", 64, 1)
HARDWARE_ERROR_STATUS = Register("Hardware Error Status", 70, 1)
BUS_WATCHDOG = Register("Bus Watchdog", 98, 1, "signed", since=38)
PROFILE_ACCELERATION = Register("Profile Acceleration", 108, 4)
PROFILE_VELOCITY = Register("Profile Velocity", 112, 4)
GOAL_POSITION = Register("Goal Position", 116, 4, "signed")
PRESENT_CURRENT = Register("Present Current", 126, 2, "signed")
PRESENT_VELOCITY = Register("Present Velocity", 128, 4, "signed")
PRESENT_POSITION = Register("Present Position", 132, 4, "signed")

X = _layout(
    "X",
    Register("Model Number", 0, 2),
    Register("Firmware Version", 6, 1),
    Register("ID", 7, 1),
    Register("Baud Rate", 8, 1),
    RETURN_DELAY_TIME,
    DRIVE_MODE,
    OPERATING_MODE,
    Register("Secondary ID", 12, 1),
    Register("Protocol Type", 13, 1),
    HOMING_OFFSET,
    Register("Temperature Limit", 31, 1),
    Register("Max Voltage Limit", 32, 2),
    Register("Min Voltage Limit", 34, 2),
    Register("PWM Limit", 36, 2),
    Register("Current Limit", 38, 2),
    Register("Velocity Limit", 44, 4),
    MAX_POSITION_LIMIT,
    MIN_POSITION_LIMIT,
    Register("Shutdown", 63, 1),
    TORQUE_ENABLE,
    Register("Status Return Level", 68, 1),
    HARDWARE_ERROR_STATUS,
    Register("Position D Gain", 80, 2),
    Register("Position I Gain", 82, 2),
    Register("Position P Gain", 84, 2),
    BUS_WATCHDOG,
    Register("Goal PWM", 100, 2, "signed"),
    Register("Goal Current", 102, 2, "signed"),
    Register("Goal Velocity", 104, 4, "signed"),
    PROFILE_ACCELERATION,
    PROFILE_VELOCITY,
    GOAL_POSITION,
    Register("Realtime Tick", 120, 2),
    Register("Moving", 122, 1),
    Register("Moving Status", 123, 1),
    Register("Present PWM", 124, 2, "signed"),
    PRESENT_CURRENT,
    PRESENT_VELOCITY,
    PRESENT_POSITION,
    Register("Position Trajectory", 140, 4, "signed"),
    Register("Present Input Voltage", 144, 2),
    Register("Present Temperature", 146, 1),
    ram=64,
)
"""X series, and MX with Protocol 2.0. Drive Mode and Bus Watchdog came with firmware 38 (e-Manual,
"Bus Watchdog(98)", "Drive Mode(10)"). The XL430 and other models without a current sensor have
Present Load at 126, and no current registers: `armsyn.driver.models` says which."""

_CLASSIC_BEGIN = (
    Register("Model Number", 0, 2),
    Register("Firmware Version", 2, 1),
    Register("ID", 3, 1),
    Register("Baud Rate", 4, 1),
    Register("Return Delay Time", 5, 1),
)

XL320 = _layout(
    "XL-320",
    *_CLASSIC_BEGIN,
    Register("Min Position Limit", 6, 2),
    Register("Max Position Limit", 8, 2),
    Register("Operating Mode", 11, 1),
    Register("Temperature Limit", 12, 1),
    Register("Min Voltage Limit", 13, 1),
    Register("Max Voltage Limit", 14, 1),
    Register("Max Torque", 15, 2),
    Register("Status Return Level", 17, 1),
    Register("Shutdown", 18, 1),
    Register("Torque Enable", 24, 1),
    Register("Position D Gain", 27, 1),
    Register("Position I Gain", 28, 1),
    Register("Position P Gain", 29, 1),
    Register("Goal Position", 30, 2),
    Register("Moving Speed", 32, 2),
    Register("Torque Limit", 35, 2),
    Register("Present Position", 37, 2),
    Register("Present Velocity", 39, 2, "direction"),
    Register("Present Load", 41, 2, "direction"),
    Register("Present Input Voltage", 45, 1),
    Register("Present Temperature", 46, 1),
    Register("Moving", 49, 1),
    Register("Hardware Error Status", 50, 1),
    errors={0x01: 0x20, 0x02: 0x04, 0x04: 0x01},
)
"""XL-320: Protocol 2.0 with a table of its own. Its Operating Mode (Control Mode) is 2 for
positions, and its hardware errors are numbered otherwise: overload, overheating, input voltage
(e-Manual, XL-320, "Hardware Error Status(50)")."""

_PROTOCOL_1 = (
    *_CLASSIC_BEGIN,
    Register("Min Position Limit", 6, 2),
    Register("Max Position Limit", 8, 2),
    Register("Temperature Limit", 11, 1),
    Register("Min Voltage Limit", 12, 1),
    Register("Max Voltage Limit", 13, 1),
    Register("Max Torque", 14, 2),
    Register("Status Return Level", 16, 1),
    Register("Shutdown", 18, 1),
    Register("Torque Enable", 24, 1),
    Register("Moving Speed", 32, 2),
    Register("Torque Limit", 34, 2),
    Register("Present Velocity", 38, 2, "direction"),
    Register("Present Load", 40, 2, "direction"),
    Register("Present Input Voltage", 42, 1),
    Register("Present Temperature", 43, 1),
    Register("Moving", 46, 1),
    Register("Lock", 47, 1),
)

AX = _layout(
    "AX",
    *_PROTOCOL_1,
    Register("Goal Position", 30, 2),
    Register("Present Position", 36, 2),
)
"""AX series."""

MX1 = _layout(
    "MX, Protocol 1.0",
    *_PROTOCOL_1,
    Register("Position D Gain", 26, 1),
    Register("Position I Gain", 27, 1),
    Register("Position P Gain", 28, 1),
    Register("Goal Position", 30, 2, "signed"),
    Register("Present Position", 36, 2, "signed"),
    Register("Goal Acceleration", 73, 1),
)
"""MX series with Protocol 1.0."""

LAYOUTS = (X, XL320, AX, MX1)
"""All families."""

STATE_ADDRESS = PRESENT_CURRENT.address
STATE_SIZE = PRESENT_POSITION.address + PRESENT_POSITION.size - STATE_ADDRESS
"""Current, velocity and position lie side by side: one read of 10 bytes."""

HEALTH_ADDRESS = TORQUE_ENABLE.address
HEALTH_SIZE = HARDWARE_ERROR_STATUS.address + HARDWARE_ERROR_STATUS.size - HEALTH_ADDRESS
"""From torque enable to hardware error status: one read of 7 bytes."""


def hardware_error_names(status: int) -> str:
    """Words for the bits of Hardware Error Status, such as ``overheating, overload``."""
    named = [name for bit, name in HARDWARE_ERRORS.items() if status & bit]
    unknown = status & ~sum(HARDWARE_ERRORS)
    return ", ".join([*named, *([f"unknown bits 0x{unknown:02x}"] if unknown else [])]) or "none"
