"""Reading registers: which bytes a request covers, and which of them must be measured first.

Where the manual is silent: a read may span holes between registers, which read 0, but not begin in
one, except in AX and MX with protocol 1.0, which know no access error.
"""

from __future__ import annotations

from collections.abc import Callable

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.family import Firmware
from firmware_sim.firmware.indirect import IndirectMap
from firmware_sim.firmware.memory import PLANS_KEPT, Memory

_REFUSED = (StatusError.ACCESS, b"")

Plan = tuple[tuple[Callable[[], None], ...], int, int, tuple[int, ...] | None]
"""What to measure; begin and end of the bytes; where each of them is, if not there."""


class Reader:
    """Reads the registers of one servo.

    Parameters
    ----------
    memory : Memory
        Its registers.
    firmware : Firmware
        What measures.
    indirect : IndirectMap
        Its indirect addresses; `forget` is to be called when one changes.
    from_holes : bool
        Whether a read may begin between registers.
    """

    def __init__(
        self, memory: Memory, firmware: Firmware, indirect: IndirectMap, from_holes: bool = False
    ) -> None:
        self._memory = memory
        self._from_holes = from_holes
        self._data = memory.data
        self._indirect = indirect
        self._plans: dict[int, Plan] = {}
        self._fillers: dict[str, Callable[[], None]] = {}
        for register in memory.table.registers:
            measure = firmware.present(register.name)
            if measure is not None:
                self._fillers[register.name] = memory.filler(register.name, measure)

    def read(self, address: int, size: int) -> tuple[StatusError, bytes]:
        """Return registers' bytes; see `Servo.read`."""
        plan = self._plans.get(address << 16 | size)
        if plan is None:
            if not self._is_readable(address, size):
                return _REFUSED
            plan = self._plan(address, size)
        fillers, begin, end, places = plan
        for fill in fillers:
            fill()
        data = self._data
        if places is None:
            return StatusError.NONE, bytes(data[begin:end])
        return StatusError.NONE, bytes([data[place] for place in places])

    def measure(self) -> None:
        """Bring all measured registers up to date in memory."""
        for fill in self._fillers.values():
            fill()

    def forget(self) -> None:
        """Find out anew where bytes are."""
        self._plans.clear()

    def _is_readable(self, address: int, size: int) -> bool:
        table = self._memory.table
        if size <= 0 or address + size > table.size:
            return False
        return self._from_holes or table.at(address) is not None

    def _plan(self, address: int, size: int) -> Plan:
        places = self._indirect.targets(address, size)
        covered = {
            register.name: None
            for place in places or range(address, address + size)
            if (register := self._memory.table.at(place)) is not None
        }
        fillers = tuple(self._fillers[name] for name in covered if name in self._fillers)
        plan = (fillers, address, address + size, None if places is None else tuple(places))
        if len(self._plans) >= PLANS_KEPT:
            self._plans.clear()
        self._plans[address << 16 | size] = plan
        return plan
