"""Which writes the older servos refuse, and why.

Sources: e-Manual, Protocol 1.0, "Error" (range, angle limit); docs/en/dxl/ax/ax-12a, "Lock (47)";
docs/en/dxl/x/xl320 and Protocol 2.0, "Error", for XL-320. Robotis, AX-12 User's Manual, 3-4, lists
the two bytes of a register apart, so that one of them can be written alone; holes between
registers take whatever is written and read 0. Where they are silent: a read-only or locked register
is answered with a range error in protocol 1.0, which has no other bit for it; a refused write
changes nothing; torque does not lock the EEPROM of AX and MX ("Torque Enable(24)" of their pages
does not say that it did, as that of XL-320 does), Lock(47) does.
"""

from __future__ import annotations

from firmware_sim.classic.counting import Mode, mode_of
from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.control_table import Access, Area, Register
from firmware_sim.firmware.family import Values
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.writing import WriteChecker


def check_write(memory: Memory, address: int, data: bytes) -> tuple[StatusError, Values]:
    """Return why a servo with protocol 1.0 refuses a write, and what it writes if it does not.

    Parameters
    ----------
    memory : Memory
        Its registers.
    address : int
        Of the first byte.
    data : bytes
        What is to be written.

    Returns
    -------
    error : StatusError
        `DATA_LIMIT` for a goal outside the angle limits, `DATA_RANGE` for all else.
    values : list of (Register, int)
        By address, each whole; empty with an error.
    """
    if not data or address + len(data) > memory.table.size:
        return StatusError.DATA_RANGE, []
    values = []
    for register in memory.table.span(address, len(data)).registers:
        value = _merged(memory, register, address, data)
        error = _refuse_value(memory, register, value)
        if error:
            return error, []
        values.append((register, value))
    return StatusError.NONE, values


def xl320_checker(memory: Memory) -> WriteChecker:
    """Return what refuses an XL-320's writes, with the errors of protocol 2.0."""

    def refuse(goal: int) -> StatusError:
        return StatusError.NONE if _is_within_limits(memory, goal) else StatusError.DATA_LIMIT

    return WriteChecker(memory, {"Goal Position": refuse})


def _refuse_value(memory: Memory, register: Register, value: int) -> StatusError:
    if register.access is Access.READ or _is_locked(memory, register):
        return StatusError.DATA_RANGE
    if not register.minimum <= value <= register.maximum:
        return StatusError.DATA_RANGE
    if register.name == "Goal Position" and not _is_within_limits(memory, value):
        return StatusError.DATA_LIMIT
    return StatusError.NONE


def _is_locked(memory: Memory, register: Register) -> bool:
    if not memory.value("Lock"):
        return False
    return register.area is Area.EEPROM or register.name == "Lock"


def _merged(memory: Memory, register: Register, address: int, data: bytes) -> int:
    """Return a register's value with those of its bytes replaced that `data` covers."""
    raw = bytearray(memory.data[register.address : register.end])
    for position in range(len(raw)):
        index = register.address + position - address
        if 0 <= index < len(data):
            raw[position] = data[index]
    return int.from_bytes(raw, "little", signed=register.signed)


def _is_within_limits(memory: Memory, goal: int) -> bool:
    if mode_of(memory) is not Mode.JOINT:
        return True
    return memory.value("CW Angle Limit") <= goal <= memory.value("CCW Angle Limit")
