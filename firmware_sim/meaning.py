"""What goes over a bus, for people to read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum

from firmware_sim.codes import ALERT, StatusError
from firmware_sim.packet import BROADCAST_ID, STATUS_INSTRUCTION
from firmware_sim.parser import DamagedPacket, Packet, PacketParser
from firmware_sim.parser1 import PacketParser1
from firmware_sim.protocol1_single import ErrorBit, Instruction1
from firmware_sim.protocol2_shares import (
    ReadShare,
    WriteShare,
    bulk_reads,
    bulk_writes,
    sync_reads,
    sync_writes,
)
from firmware_sim.protocol2_single import Instruction


def _plain(name: IntEnum) -> str:
    return name.name.lower().replace("_", " ")


_SHARES_OF_READS: dict[int, Callable[[bytes], Sequence[ReadShare]]] = {
    Instruction.SYNC_READ: sync_reads,
    Instruction.FAST_SYNC_READ: sync_reads,
    Instruction.BULK_READ: bulk_reads,
    Instruction.FAST_BULK_READ: bulk_reads,
}
_SHARES_OF_WRITES: dict[int, Callable[[bytes], list[WriteShare]]] = {
    Instruction.SYNC_WRITE: sync_writes,
    Instruction.BULK_WRITE: bulk_writes,
}
_ERROR_NAMES = {int(error): f"{_plain(error)} error" for error in StatusError}


@dataclass(frozen=True, slots=True)
class Heard:
    """A frame of the client, as the servos of one protocol took it.

    Parameters
    ----------
    when : float
        The end of its last byte on the wire, s.
    protocol : int
        1 or 2.
    packet : Packet or DamagedPacket
        It; its ``frame`` has the bytes.
    """

    when: float
    protocol: int
    packet: Packet | DamagedPacket

    @property
    def data(self) -> bytes:
        """The bytes on the wire."""
        return self.packet.frame

    @property
    def meaning(self) -> str:
        """For instance ``all: sync read 132, 4 bytes of 1 2 3``."""
        return _request(self.protocol, self.packet)


@dataclass(frozen=True, slots=True)
class Said:
    """An answer of the servos, one packet of one or of several.

    Parameters
    ----------
    when : float
        When its last byte has left the wire, s.
    protocol : int
        1 or 2.
    data : bytes
        The bytes on the wire.
    """

    when: float
    protocol: int
    data: bytes

    @property
    def meaning(self) -> str:
        """For instance ``ID 1: status, 1F 08 00 00``."""
        parser = PacketParser() if self.protocol == 2 else PacketParser1()
        found = parser.feed(self.data)
        if len(found) == 1 and isinstance(found[0], Packet) and found[0].frame == self.data:
            return _status(self.protocol, found[0])
        return f"unreadable, {len(self.data)} bytes"


def _request(protocol: int, packet: Packet | DamagedPacket) -> str:
    if isinstance(packet, DamagedPacket):
        return f"{_whom(packet.servo_id)}: damaged, {len(packet.frame)} bytes"
    names: type[IntEnum] = Instruction if protocol == 2 else Instruction1
    try:
        name = _plain(names(packet.instruction))
    except ValueError:
        name = f"instruction {packet.instruction:02X}"
    details = _details_2(packet) if protocol == 2 else _details_1(packet)
    return f"{_whom(packet.servo_id)}: {name}{details and ' '}{details}"


def _whom(servo_id: int) -> str:
    return "all" if servo_id == BROADCAST_ID else f"ID {servo_id}"


def _details_2(packet: Packet) -> str:
    """Return what an instruction of protocol 2.0 is about."""
    instruction, params = packet.instruction, packet.params
    if instruction in _SHARES_OF_READS:
        return _reads(_SHARES_OF_READS[instruction](params))
    if instruction in _SHARES_OF_WRITES:
        return _writes(_SHARES_OF_WRITES[instruction](params))
    if instruction == Instruction.READ and len(params) == 4:
        address, size = (int.from_bytes(params[at : at + 2], "little") for at in (0, 2))
        return f"{address}, {size} bytes"
    if instruction in (Instruction.WRITE, Instruction.REG_WRITE) and len(params) > 2:
        return f"{int.from_bytes(params[:2], 'little')}: {_hex(params[2:])}"
    return _hex(params)


def _details_1(packet: Packet) -> str:
    """Return what an instruction of protocol 1.0 is about."""
    instruction, params = packet.instruction, packet.params
    if instruction == Instruction1.READ and len(params) == 2:
        return f"{params[0]}, {params[1]} bytes"
    if instruction in (Instruction1.WRITE, Instruction1.REG_WRITE) and len(params) > 1:
        return f"{params[0]}: {_hex(params[1:])}"
    if instruction == Instruction1.BULK_READ:
        starts = range(1, len(params) - 2, 3)
        return _reads([ReadShare(params[at + 1], params[at + 2], params[at]) for at in starts])
    if instruction == Instruction1.SYNC_WRITE and len(params) > 1:
        spread = bytes((params[0], 0, params[1], 0)) + params[2:]
        return _writes(sync_writes(spread))
    return _hex(params)


def _reads(shares: Sequence[ReadShare]) -> str:
    ranges = {(share.address, share.size) for share in shares}
    if len(ranges) == 1:
        ((address, size),) = ranges
        return f"{address}, {size} bytes of {' '.join(str(s.servo_id) for s in shares)}"
    return "; ".join(f"{s.address}, {s.size} bytes of {s.servo_id}" for s in shares)


def _writes(shares: list[WriteShare]) -> str:
    return "; ".join(f"{s.servo_id} at {s.address}: {_hex(s.data)}" for s in shares)


def _status(protocol: int, packet: Packet) -> str:
    if protocol == 1:
        error, data = packet.instruction, packet.params
    elif packet.instruction == STATUS_INSTRUCTION and packet.params:
        error, data = packet.params[0], packet.params[1:]
    else:
        return f"unreadable, {len(packet.frame)} bytes"
    who = "together" if packet.servo_id == BROADCAST_ID else _whom(packet.servo_id)
    parts = ["status", _errors_1(error) if protocol == 1 else _errors_2(error), _hex(data)]
    return f"{who}: {', '.join(part for part in parts if part)}"


def _errors_2(error: int) -> str:
    """Return the error field of protocol 2.0 in words."""
    number = error & ~ALERT
    words = ["alert"] if error & ALERT else []
    if number:
        words.append(_ERROR_NAMES.get(number, f"error {number}"))
    return ", ".join(words)


_HARDWARE_BITS = {0x01: "input voltage", 0x04: "overheating", 0x20: "overload"}


def _errors_1(error: int) -> str:
    """Return the error byte of protocol 1.0 in words."""
    names = _HARDWARE_BITS | {bit: _plain(bit) for bit in ErrorBit}
    return ", ".join(f"{name} error" for bit, name in sorted(names.items()) if error & bit)


def _hex(data: bytes) -> str:
    return data.hex(" ").upper()
