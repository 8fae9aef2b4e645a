"""The backup of a control table that a servo keeps in itself.

Source: e-Manual, Protocol 2.0, "Control Table Backup": stored and restored with the torque off
only, else a result fail; covers the EEPROM and of RAM the gains, the profile and the indirect
addresses; a restore puts the EEPROM back and reboots. X-series pages, "Startup Configuration(60)":
with bit 1 a boot takes the RAM registers from it.
"""

from __future__ import annotations

from collections.abc import Mapping

from firmware_sim.firmware.control_table import Access, Area
from firmware_sim.firmware.memory import Memory

_RAM_NAMES = (
    "Velocity I Gain",
    "Velocity P Gain",
    "Position D Gain",
    "Position I Gain",
    "Position P Gain",
    "Feedforward 2nd Gain",
    "Feedforward 1st Gain",
    "Profile Acceleration",
    "Profile Velocity",
)


class Backup:
    """What was stored, if anything.

    Parameters
    ----------
    memory : Memory
        The servo's registers.
    """

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self.values: dict[str, int] | None = None
        """Registers by name; None before the first backup."""
        self._eeprom: list[str] = []
        self._ram: list[str] = []
        for register in memory.table.registers:
            name = register.name
            if register.area is Area.EEPROM and register.access is Access.READ_WRITE:
                self._eeprom.append(name)
            elif name in _RAM_NAMES or name.startswith("Indirect Address"):
                self._ram.append(name)

    @property
    def names(self) -> set[str]:
        """Which registers it covers."""
        return {*self._eeprom, *self._ram}

    def store(self) -> None:
        """Copy the registers."""
        self.values = {name: self._memory.value(name) for name in self._eeprom + self._ram}
        self.show()

    def show(self) -> None:
        """Let Backup Ready(147) tell whether there is a copy."""
        if "Backup Ready" in self._memory.table.by_name:
            self._memory.store("Backup Ready", int(self.values is not None))

    def restore_eeprom(self) -> None:
        """Put the EEPROM registers back, if there is a copy."""
        self._put_back(self._eeprom)

    def restore_ram(self) -> None:
        """Put the RAM registers back, if there is a copy."""
        self._put_back(self._ram)

    def _put_back(self, names: list[str]) -> None:
        values: Mapping[str, int] = self.values or {}
        for name in names:
            if name in values:
                self._memory.store(name, values[name])
