"""Checking writes: which registers a request covers, and what must hold for each of them."""

from __future__ import annotations

from collections.abc import Callable

from firmware_sim.codes import StatusError
from firmware_sim.control_table import Access, Area, Register
from firmware_sim.firmware import Values
from firmware_sim.indirect import IndirectMap
from firmware_sim.memory import Memory

_PLANS_KEPT = 256
"""Ranges remembered for a servo: clients use few, and a hostile one must not make this grow."""

Plan = tuple[StatusError, tuple[tuple[Register, slice | tuple[int, ...]], ...]]
"""Why every write to a range is refused; or its registers, and where in the data each lies."""


class WriteChecker:
    """What all families' writes have in common: whole registers, writable, within their ranges.

    Parameters
    ----------
    memory : Memory
        The servo's registers.
    refuse : callable
        Says what else there is against a register's new value, `StatusError.NONE` if nothing.
    """

    def __init__(self, memory: Memory, refuse: Callable[[Register, int], StatusError]) -> None:
        self._memory = memory
        self._refuse = refuse
        self._indirect = IndirectMap(memory)
        self._plans: dict[int, Plan] = {}

    def check(self, address: int, data: bytes, ram_only: bool) -> tuple[StatusError, Values]:
        """Return the first reason to refuse a write, or none and what it writes.

        Parameters
        ----------
        address : int
            Of the first byte.
        data : bytes
            What is to be written; a refused write changes no register, not even those that fit.
        ram_only : bool
            Whether registers in EEPROM are out of reach.
        """
        plan = self._plans.get(address << 16 | len(data))
        if plan is None:
            plan = self._plan(address, len(data))
        error, parts = plan
        if error:
            return error, []
        values = []
        for register, place in parts:
            raw = data[place] if isinstance(place, slice) else bytes([data[i] for i in place])
            value = int.from_bytes(raw, "little", signed=register.minimum < 0)
            error = self._check_value(register, value, ram_only)
            if error:
                return error, []
            values.append((register, value))
        return StatusError.NONE, values

    def forget(self) -> None:
        """Find out anew where indirect addresses aim."""
        self._plans.clear()

    def _check_value(self, register: Register, value: int, ram_only: bool) -> StatusError:
        if register.access is Access.READ:
            return StatusError.ACCESS
        if register.area is Area.EEPROM and (ram_only or self._memory.value("Torque Enable")):
            return StatusError.ACCESS
        if not register.minimum <= value <= register.maximum:
            return StatusError.DATA_RANGE
        return self._refuse(register, value)

    def _plan(self, address: int, size: int) -> Plan:
        places = self._indirect.targets(address, size) if size <= self._memory.table.size else None
        plan = self._aimed(places) if places else self._straight(address, size)
        if len(self._plans) >= _PLANS_KEPT:
            self._plans.clear()
        self._plans[address << 16 | size] = plan
        return plan

    def _straight(self, address: int, size: int) -> Plan:
        if not size:
            return StatusError.DATA_LENGTH, ()
        span = self._memory.table.span(address, size)
        if not span.begins_defined:
            return StatusError.ACCESS, ()
        if span.cuts:
            return StatusError.DATA_LENGTH, ()
        if span.holes:
            return StatusError.ACCESS, ()
        return StatusError.NONE, tuple(
            (register, slice(register.address - address, register.end - address))
            for register in span.registers
        )

    def _aimed(self, places: list[int]) -> Plan:
        """Plan for bytes that lie apart: a register must get all of its own, in any order."""
        given = {place: index for index, place in enumerate(places)}
        registers: dict[int, Register] = {}
        for place in places:
            register = self._memory.table.at(place)
            if register is None:
                return StatusError.ACCESS, ()
            registers[register.address] = register
        parts = []
        for register in registers.values():
            bytes_of = range(register.address, register.end)
            if any(place not in given for place in bytes_of):
                return StatusError.DATA_LENGTH, ()
            parts.append((register, tuple(given[place] for place in bytes_of)))
        return StatusError.NONE, tuple(parts)
