"""Indirect addresses: registers of RAM gathered where one request can reach them.

Source: e-Manual, "Indirect Address, Indirect Data": the byte of Indirect Data N is the byte at the
address that Indirect Address N holds, with its access and range. From the factory each aims at its
own Indirect Data, which is then plain memory. Where the manual is silent: one aimed at another
Indirect Data's byte is that byte's memory, not what that one is aimed at.
"""

from __future__ import annotations

from firmware_sim.firmware.memory import Memory

_ADDRESS = "Indirect Address "
_DATA = "Indirect Data "


class IndirectMap:
    """The indirect addresses of one servo.

    Parameters
    ----------
    memory : Memory
        Its registers; a table without indirect addresses is fine.
    """

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        by_name = memory.table.by_name
        self._aims = {
            by_name[_DATA + name.removeprefix(_ADDRESS)].address: name
            for name in by_name
            if name.startswith(_ADDRESS)
        }
        """Which register says where the byte at an address really is."""

    @property
    def names(self) -> list[str]:
        """Registers that hold the aims."""
        return list(self._aims.values())

    def targets(self, address: int, size: int) -> list[int] | None:
        """Return where the bytes of a range really are, None if all are where they seem."""
        aims, value = self._aims, self._memory.value
        found = [
            value(aims[place]) if place in aims else place
            for place in range(address, address + size)
        ]
        return None if found == list(range(address, address + size)) else found
