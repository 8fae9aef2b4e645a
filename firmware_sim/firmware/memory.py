"""The bytes behind a control table."""

from __future__ import annotations

import struct
from collections.abc import Callable

from firmware_sim.firmware.control_table import Area, ControlTable, Register

PLANS_KEPT = 256
"""Ranges of a servo's registers of which readers and writers each remember how to go about them:
clients use few, and a hostile one must not make that grow."""

_UNSIGNED = {1: "<B", 2: "<H", 4: "<I"}
_SIGNED = {1: "<b", 2: "<h", 4: "<i"}


class Memory:
    """Values of one servo's registers.

    Parameters
    ----------
    table : ControlTable
        Which registers there are. All start at their defaults.

    Attributes
    ----------
    data : bytearray
        All bytes, by address; holes read 0.
    value : callable
        Returns what the register of a name holds, with its sign.
    """

    def __init__(self, table: ControlTable) -> None:
        self.table = table
        self.data = bytearray(table.size)
        self._values: dict[str, int] = {}
        """What `data` holds, by name: numbers are asked for far more often than bytes."""
        self.value: Callable[[str], int] = self._values.__getitem__
        self._codecs = {
            register.name: (_codec(register), register.address) for register in table.registers
        }
        self.reset(Area.EEPROM)
        self.reset(Area.RAM)

    def reset(self, area: Area) -> None:
        """Put the registers of one area to their defaults."""
        for register in self.table.registers:
            if register.area is area:
                self.store(register.name, register.default)

    def store(self, name: str, value: int) -> None:
        """Set the register of this name; the value must fit into its bytes."""
        codec, address = self._codecs[name]
        codec.pack_into(self.data, address, value)
        self._values[name] = value

    def filler(self, name: str, measure: Callable[[], int]) -> Callable[[], None]:
        """Return what puts a measured value into the register of this name.

        A value too large for its bytes wraps, as a counter's does.
        """
        codec, address = self._codecs[name]
        register = self.table.by_name[name]
        data, values, pack_into = self.data, self._values, codec.pack_into
        bits = 8 * register.size
        half = 1 << (bits - 1) if register.signed else 0

        def fill() -> None:
            value = measure()
            try:
                pack_into(data, address, value)
            except struct.error:
                value = (value + half) % (1 << bits) - half
                pack_into(data, address, value)
            values[name] = value

        return fill


def _codec(register: Register) -> struct.Struct:
    return struct.Struct((_SIGNED if register.signed else _UNSIGNED)[register.size])
