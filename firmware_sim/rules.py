"""Which writes a servo refuses, and with which error number.

Source: e-Manual, Protocol 2.0, "Error": data range for a value outside the register's own range,
data limit for one outside a limit register, data length for part of a register, access for
read-only, undefined, and EEPROM while torque is on; "Bus Watchdog(98)": goals are refused with a
data range error after it expired.
"""

from __future__ import annotations

from firmware_sim.codes import OperatingMode, StatusError
from firmware_sim.control_table import Access, Area, Register
from firmware_sim.memory import Memory
from firmware_sim.model import ServoModel

WATCHDOG_EXPIRED = 0xFF
"""What Bus Watchdog(98) reads after it expired: -1."""

GOAL_NAMES = frozenset(("Goal PWM", "Goal Current", "Goal Velocity", "Goal Position"))

_LIMITED_BY = {
    "Goal PWM": "PWM Limit",
    "Goal Current": "Current Limit",
    "Goal Velocity": "Velocity Limit",
}

_ONLY_MODELLED = {
    "Operating Mode": frozenset(OperatingMode),
    "Protocol Type": frozenset((2,)),
    "Startup Configuration": frozenset((0,)),
    "Secondary(Shadow) ID": frozenset((253, 254, 255)),
}
"""Settings whose other values are refused with a data range error: they would change what the servo
does, and are not modelled."""


Values = list[tuple[Register, int]]
"""Registers, each with what is to be written there."""


def check_write(
    model: ServoModel, memory: Memory, address: int, data: bytes
) -> tuple[StatusError, Values]:
    """Return why a write is refused, `StatusError.NONE` if it is not, and what it writes.

    Parameters
    ----------
    model : ServoModel
        Whose registers they are.
    memory : Memory
        Their present values.
    address : int
        Of the first byte.
    data : bytes
        What is to be written; a refused write changes no register, not even those that fit.

    Returns
    -------
    error : StatusError
        The first reason found.
    values : list of (Register, int)
        By address; empty with an error.
    """
    span = memory.table.span(address, len(data))
    if not data:
        return StatusError.DATA_LENGTH, []
    if not span.begins_defined:
        return StatusError.ACCESS, []
    if span.cuts:
        return StatusError.DATA_LENGTH, []
    if span.holes:
        return StatusError.ACCESS, []
    values = []
    for register in span.registers:
        raw = data[register.address - address : register.end - address]
        value = int.from_bytes(raw, "little", signed=register.signed)
        error = _refuse_value(model, memory, register, value)
        if error:
            return error, []
        values.append((register, value))
    return StatusError.NONE, values


def _refuse_value(model: ServoModel, memory: Memory, register: Register, value: int) -> StatusError:
    if register.access is Access.READ:
        return StatusError.ACCESS
    if register.area is Area.EEPROM and memory.value("Torque Enable"):
        return StatusError.ACCESS
    if not register.minimum <= value <= register.maximum or _unmodelled(model, register, value):
        return StatusError.DATA_RANGE
    name = register.name
    if name in GOAL_NAMES:
        return _refuse_goal(memory, name, value)
    if name == "Bus Watchdog" and value and memory.value(name) == WATCHDOG_EXPIRED:
        return StatusError.DATA_RANGE
    return StatusError.NONE


def _unmodelled(model: ServoModel, register: Register, value: int) -> bool:
    if register.name == "Drive Mode":
        return bool(value & ~model.drive_mode_bits)
    allowed = _ONLY_MODELLED.get(register.name)
    return allowed is not None and value not in allowed


def _refuse_goal(memory: Memory, name: str, value: int) -> StatusError:
    if memory.value("Bus Watchdog") == WATCHDOG_EXPIRED:
        return StatusError.DATA_RANGE
    if name == "Goal Position":
        if memory.value("Operating Mode") != OperatingMode.POSITION:
            return StatusError.NONE
        low, high = memory.value("Min Position Limit"), memory.value("Max Position Limit")
        return StatusError.NONE if low <= value <= high else StatusError.DATA_LIMIT
    limit = memory.value(_LIMITED_BY[name])
    return StatusError.NONE if abs(value) <= limit else StatusError.DATA_LIMIT
