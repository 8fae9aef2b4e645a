"""Registers that lie apart, read at once: indirect addresses bring them side by side.

Each Indirect Address register names one byte of RAM, which the Indirect Data register of the same
number then shows (e-Manual, X series, "Indirect Address, Indirect Data"). They are RAM: a reboot
points each of them at its own data byte again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from armsyn.driver.plans import Kind, ReadPlan
from armsyn.driver.registers import Register
from armsyn.driver.transactions import Bus

FIRST_INDIRECT_FIRMWARE_X330 = 53
"""Firmware from which on the X330's indirect registers lie as those of the other X series."""


@dataclass(frozen=True)
class IndirectArea:
    """Where a servo's first indirect registers lie.

    Parameters
    ----------
    addresses, data : int
        Of Indirect Address 1 (2 bytes each) and Indirect Data 1 (1 byte each).
    slots : int
        How many there are side by side.
    """

    addresses: int
    data: int
    slots: int


_X = IndirectArea(168, 224, 28)
_EARLY_X330 = IndirectArea(168, 208, 20)


def indirect_area(model: str, firmware: int) -> IndirectArea:
    """Where a model of the X series, or an MX of protocol 2.0, has them; others have none.

    Parameters
    ----------
    model : str
        Such as ``xl330-m288``.
    firmware : int
        Its version.
    """
    early = "330" in model and firmware < FIRST_INDIRECT_FIRMWARE_X330
    return _EARLY_X330 if early else _X


class IndirectBlock:
    """Registers of the same address in several servos, brought side by side.

    Parameters
    ----------
    area : IndirectArea
    registers : sequence of Register
        In RAM, in the order in which they are to stand.

    Raises
    ------
    ValueError
        They have more bytes than there are slots.

    Attributes
    ----------
    address, size : int
        Where they then stand side by side.
    """

    def __init__(self, area: IndirectArea, registers: Sequence[Register]) -> None:
        self.size = sum(register.size for register in registers)
        if self.size > area.slots:
            raise ValueError(f"{self.size} bytes do not fit {area.slots} indirect addresses")
        self._registers = tuple(registers)
        self.address = area.data
        self._addresses = Register("Indirect Address 1 and on", area.addresses, 2 * self.size)
        places = [r.address + n for r in registers for n in range(r.size)]
        self._wanted = int.from_bytes(b"".join(p.to_bytes(2, "little") for p in places), "little")

    def point(self, bus: Bus, servo_ids: tuple[int, ...]) -> tuple[int, ...]:
        """Let the indirect addresses of servos point at the registers, and read them back.

        Returns
        -------
        tuple of int
            Those of the servos that have taken them. They are told twice: nobody says that a sync
            write came damaged.

        Raises
        ------
        BusError, PortLostError
            As `Bus.read_all`.
        """
        pointed: tuple[int, ...] = ()
        for _ in range(2):
            if left := tuple(i for i in servo_ids if i not in pointed):
                bus.sync_write(self._addresses, dict.fromkeys(left, self._wanted))
                pointed += self.pointed(bus, left)
        return pointed

    def pointed(self, bus: Bus, servo_ids: tuple[int, ...]) -> tuple[int, ...]:
        """Return those of the servos whose indirect addresses point at the registers already.

        Raises
        ------
        BusError, PortLostError
            As `Bus.read_all`.
        """
        values = bus.read_all(self._addresses, servo_ids)
        return tuple(i for i, value in values.items() if value == self._wanted)

    def plan(self, servo_ids: tuple[int, ...], kind: Kind = "sync") -> ReadPlan:
        """Return how to read the block of servos whose indirect addresses point at it."""
        return ReadPlan(kind, 2, self.address, self.size, servo_ids)

    def decode(self, data: bytes) -> dict[str, int]:
        """Values by the registers' names, of what a servo answered to `plan`."""
        values, at = {}, 0
        for register in self._registers:
            values[register.name] = register.decode(data[at : at + register.size])
            at += register.size
        return values
