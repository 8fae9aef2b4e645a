"""What a control table is: registers by address, and which of them a request covers."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Access(Enum):
    """Who may write a register."""

    READ = "R"
    READ_WRITE = "RW"


class Area(Enum):
    """Where a register lives: EEPROM survives a reboot and is locked while torque is on."""

    EEPROM = "EEPROM"
    RAM = "RAM"


@dataclass(frozen=True, slots=True)
class Register:
    """One row of a control table.

    Parameters
    ----------
    address : int
        Of its first byte.
    size : int
        1, 2 or 4 bytes, little-endian, two's complement where ``minimum`` is negative.
    name : str
        As the e-Manual and the SDK's ``.model`` files spell it.
    access : Access
        Who may write it.
    area : Area
        EEPROM or RAM.
    default : int
        After a factory reset (EEPROM) or a boot (RAM).
    minimum, maximum : int
        A value outside is refused with a data range error.
    unit : str
        Of one count, as the e-Manual says; empty for codes and flags.
    """

    address: int
    size: int
    name: str
    access: Access
    area: Area
    default: int
    minimum: int
    maximum: int
    unit: str = ""

    @property
    def end(self) -> int:
        """Address of the byte after the last."""
        return self.address + self.size

    @property
    def signed(self) -> bool:
        """Whether its bytes are two's complement."""
        return self.minimum < 0


def row(
    address: int,
    size: int,
    name: str,
    access: str,
    default: int,
    value_range: tuple[int, int] | None = None,
    unit: str = "",
) -> Register:
    """Return a register written as the e-Manual's tables write it.

    Parameters
    ----------
    address, size, name
        See `Register`.
    access : str
        ``"R"`` or ``"RW"``.
    default : int
        Initial value; 0 where the manual has none.
    value_range : (int, int), optional
        Smallest and largest value; every unsigned value of this size by default.
    unit : str
        Of one count.

    Returns
    -------
    Register
        In EEPROM below address 64, in RAM above, as on the whole X series.
    """
    low, high = value_range or (0, 256**size - 1)
    area = Area.EEPROM if address < 64 else Area.RAM
    return Register(address, size, name, Access(access), area, default, low, high, unit)


def indirect_rows(
    first: int, count: int, address_at: int, data_at: int, last: int
) -> list[Register]:
    """Return one block of indirect addresses and their data.

    Parameters
    ----------
    first, count : int
        Number of the first pair in the block, and how many pairs.
    address_at, data_at : int
        Where the block's first indirect address (2 bytes) and first datum (1 byte) lie.
    last : int
        Highest address that may be aimed at.

    Returns
    -------
    list of Register
        ``2 * count`` rows.
    """
    addresses = [
        row(address_at + 2 * i, 2, f"Indirect Address {first + i}", "RW", data_at + i, (64, last))
        for i in range(count)
    ]
    data = [row(data_at + i, 1, f"Indirect Data {first + i}", "RW", 0) for i in range(count)]
    return addresses + data


@dataclass(frozen=True, slots=True)
class Span:
    """What a range of addresses covers.

    Parameters
    ----------
    registers : tuple of Register
        All that it touches, by address.
    begins_defined : bool
        Whether its first byte belongs to one.
    cuts : bool
        Whether it holds only part of one.
    holes : bool
        Whether some of its bytes belong to none; not said of a span that cuts.
    """

    registers: tuple[Register, ...]
    begins_defined: bool
    cuts: bool
    holes: bool


_SPANS_KEPT = 512
"""Ranges remembered for a table: clients use few, and a hostile one must not make this grow."""


class ControlTable:
    """The registers of one model.

    Parameters
    ----------
    registers : list of Register
        In any order; they must not overlap.

    Raises
    ------
    ValueError
        If two registers share a byte or a name.
    """

    def __init__(self, registers: list[Register]) -> None:
        self.registers = tuple(sorted(registers, key=lambda register: register.address))
        self.by_name = {register.name: register for register in self.registers}
        self.by_address = {register.address: register for register in self.registers}
        self.size = self.registers[-1].end
        self._covering: dict[int, Register] = {}
        self._spans: dict[tuple[int, int], Span] = {}
        for register in self.registers:
            for address in range(register.address, register.end):
                if address in self._covering:
                    raise ValueError(f"{register.name} overlaps {self._covering[address].name}")
                self._covering[address] = register
        if len(self.by_name) != len(self.registers):
            raise ValueError("two registers share a name")

    def __getitem__(self, name: str) -> Register:
        return self.by_name[name]

    def at(self, address: int) -> Register | None:
        """Return the register that a byte belongs to, None for a hole."""
        return self._covering.get(address)

    def span(self, address: int, size: int) -> Span:
        """Return what a range of bytes covers; `address` and `size` in bytes."""
        key = (address, size)
        found = self._spans.get(key)
        if found is None:
            if len(self._spans) >= _SPANS_KEPT:
                self._spans.clear()
            found = self._spans[key] = self._cover(address, address + size)
        return found

    def _cover(self, start: int, end: int) -> Span:
        touched = tuple(r for r in self.registers if r.end > start and r.address < end)
        return Span(
            touched,
            begins_defined=start in self._covering,
            cuts=any(r.address < start or r.end > end for r in touched),
            holes=sum(r.size for r in touched) < end - start,
        )
