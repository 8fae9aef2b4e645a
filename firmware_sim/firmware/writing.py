"""Checking writes: which registers a request covers, and what must hold for each of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.control_table import Access, Area, Register
from firmware_sim.firmware.family import Values
from firmware_sim.firmware.indirect import IndirectMap
from firmware_sim.firmware.memory import PLANS_KEPT, Memory

Guard = Callable[[int], StatusError]
"""Says what there is against a new value that the register's own range allows."""


class Part(NamedTuple):
    """One register of a range that is written.

    Parameters
    ----------
    register : Register
        Which.
    place : slice or tuple of int
        Where in the data its bytes are.
    signed : bool
        Whether they are two's complement.
    locked : bool
        Whether it can be read-only or locked EEPROM.
    guard : callable or None
        Its guard, if it has one.
    """

    register: Register
    place: slice | tuple[int, ...]
    signed: bool
    locked: bool
    guard: Guard | None


Plan = tuple[StatusError, tuple[Part, ...]]
"""Why every write to a range is refused; or its registers."""


class WriteChecker:
    """What all families' writes have in common: whole registers, writable, within their ranges.

    Parameters
    ----------
    memory : Memory
        The servo's registers.
    guards : mapping of str to callable
        What says more against new values, by the name of the register.
    """

    def __init__(self, memory: Memory, guards: Mapping[str, Guard]) -> None:
        self._memory = memory
        self._guards = guards
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
        for register, place, signed, locked, guard in parts:
            raw = data[place] if isinstance(place, slice) else bytes([data[i] for i in place])
            value = int.from_bytes(raw, "little", signed=signed)
            if locked and not self._is_open(register, ram_only):
                return StatusError.ACCESS, []
            if not register.minimum <= value <= register.maximum:
                return StatusError.DATA_RANGE, []
            error = guard(value) if guard is not None else StatusError.NONE
            if error:
                return error, []
            values.append((register, value))
        return StatusError.NONE, values

    def forget(self) -> None:
        """Find out anew where indirect addresses aim."""
        self._plans.clear()

    def _is_open(self, register: Register, ram_only: bool) -> bool:
        """Whether a register can be written, and is not locked at present."""
        if register.access is Access.READ:
            return False
        locked = ram_only or self._memory.value("Torque Enable")
        return not (locked and register.area is Area.EEPROM)

    def _plan(self, address: int, size: int) -> Plan:
        places = self._indirect.targets(address, size) if size <= self._memory.table.size else None
        plan = self._aimed(places) if places else self._straight(address, size)
        if len(self._plans) >= PLANS_KEPT:
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
            self._part(register, slice(register.address - address, register.end - address))
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
            parts.append(self._part(register, tuple(given[place] for place in bytes_of)))
        return StatusError.NONE, tuple(parts)

    def _part(self, register: Register, place: slice | tuple[int, ...]) -> Part:
        locked = register.access is Access.READ or register.area is Area.EEPROM
        return Part(register, place, register.signed, locked, self._guards.get(register.name))
