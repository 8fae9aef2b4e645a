"""Registers' values for people to read."""

from __future__ import annotations

import re
from functools import cache

from firmware_sim.firmware.codes import HardwareError
from firmware_sim.firmware.control_table import ControlTable, Register

_FACTOR_AND_UNIT = re.compile(r"(?:(\d+(?:\.\d+)?) )?(\S+(?: C)?)")
_SHORT_UNITS = {"deg": "°", "deg C": "°C", "rev/min": "rpm"}
_REGISTERS_SHOWN = 9
"""Registers named of a range; of a longer one only their number."""

_X_ERROR_STATUS = 70
"""Where Hardware Error Status has the bits of `HardwareError`; the XL-320's are others."""

_MODES = {
    0: "current",
    1: "velocity",
    3: "position",
    4: "extended",
    5: "current-position",
    16: "PWM",
}

_SIGN_AND_SIZE = frozenset(("Present Speed", "Present Load", "Goal Torque"))
"""Registers of Protocol 1.0 tables whose bit 10 says clockwise, with the size below it."""

_DIRECTION = 0x400


def value_in_words(register: Register, value: int) -> str:
    """Return a register's value with its unit or meaning.

    Parameters
    ----------
    register : Register
        Which one.
    value : int
        What it holds, with its sign.

    Returns
    -------
    str
        Such as ``"12.1 V"``, ``"2048 tick"`` or ``"3 (position)"``.
    """
    if register.name == "Operating Mode":
        return f"{value} ({_MODES.get(value, 'unknown')})"
    if register.name == "Hardware Error Status" and register.address == _X_ERROR_STATUS:
        return f"0x{value:02x} ({hardware_errors(value) or 'none'})"
    factor, unit = _factor_and_unit(register.unit)
    if not unit:
        return str(value)
    if register.name in _SIGN_AND_SIZE and register.maximum > _DIRECTION and value & _DIRECTION:
        value = -(value & (_DIRECTION - 1))
    scaled = value if factor is None else round(value * factor, 3)
    return f"{scaled:g} {unit}" if factor is not None else f"{scaled} {unit}"


@cache
def _factor_and_unit(unit: str) -> tuple[float | None, str]:
    """Return what a count is worth and in what; no unit for what depends on other registers."""
    match = _FACTOR_AND_UNIT.fullmatch(unit)
    if match is None:
        return None, ""
    factor, name = match.groups()
    return (float(factor) if factor else None), _SHORT_UNITS.get(name, name)


def hardware_errors(status: int) -> str:
    """Return the names of the bits of Hardware Error Status(70), joined by commas."""
    names = [error.name.lower().replace("_", " ") for error in HardwareError if status & error]
    return ", ".join(names)


def mode_name(value: int) -> str:
    """Return the name of a value of Operating Mode(11)."""
    return _MODES.get(value, str(value))


def registers_in_words(table: ControlTable, address: int, data: bytes) -> str:
    """Return what bytes at an address mean.

    Parameters
    ----------
    table : ControlTable
        Of the servo that they belong to.
    address : int
        Of the first byte.
    data : bytes
        What is read or written there.

    Returns
    -------
    str
        ``NAME = VALUE``, joined by commas; bytes of no register, or of a part of one, in hex.
    """
    parts: list[str] = []
    at = 0
    while at < len(data):
        register = table.by_address.get(address + at)
        if len(parts) == _REGISTERS_SHOWN:
            parts.append(f"... {len(data) - at} more bytes")
            break
        if register is None or at + register.size > len(data):
            parts.append(f"[{address + at}] {data[at]:02x}")
            at += 1
            continue
        raw = data[at : at + register.size]
        value = int.from_bytes(raw, "little", signed=register.signed)
        parts.append(f"{register.name} = {value_in_words(register, value)}")
        at += register.size
    return ", ".join(parts)


def range_in_words(table: ControlTable | None, address: int, size: int) -> str:
    """Return the names of the registers in a range of addresses, and the range."""
    names = []
    if table is not None and 0 < size <= table.size:
        names = [register.name for register in table.span(address, size).registers]
    if len(names) > _REGISTERS_SHOWN:
        names = [*names[:_REGISTERS_SHOWN], f"... {len(names) - _REGISTERS_SHOWN} more"]
    return f"{', '.join(names) or 'no register'} [{address}..{address + size - 1}]"
