"""The bytes behind a control table."""

from __future__ import annotations

from firmware_sim.control_table import Area, ControlTable


class Memory:
    """Values of one servo's registers.

    Parameters
    ----------
    table : ControlTable
        Which registers there are. All start at their defaults.
    """

    def __init__(self, table: ControlTable) -> None:
        self.table = table
        self.data = bytearray(table.size)
        """All bytes, by address; holes read 0."""
        self.reset(Area.EEPROM)
        self.reset(Area.RAM)

    def reset(self, area: Area) -> None:
        """Put the registers of one area to their defaults."""
        for register in self.table.registers:
            if register.area is area:
                self.store(register.name, register.default)

    def value(self, name: str) -> int:
        """Return what the register of this name holds, with its sign."""
        register = self.table.by_name[name]
        raw = self.data[register.address : register.end]
        return int.from_bytes(raw, "little", signed=register.signed)

    def store(self, name: str, value: int) -> None:
        """Set the register of this name, unchecked; values wrap at its size."""
        register = self.table.by_name[name]
        wrapped = value & (256**register.size - 1)
        self.data[register.address : register.end] = wrapped.to_bytes(register.size, "little")
