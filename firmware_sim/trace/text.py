"""Lines for people out of what went over a bus.

::

        0.001234 -> 2.0 ID 1     read        Present Position [132..135]      | FF FF FD 00 01 ...
        0.001890 <- 2.0 ID 1     status      Present Position = 2048 tick     | FF FF FD 00 01 ...

Seconds since the start (end of the last byte on the wire), direction (``->`` to the servos, ``<-``
from them, ``??`` bytes that no servo could use, ``!!`` what the client got instead of what the
servos said, ``**`` a fault that struck), protocol, ID, instruction, registers, bytes.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

from firmware_sim.firmware.codes import ALERT, ErrorBit, StatusError
from firmware_sim.firmware.control_table import ControlTable
from firmware_sim.firmware.readable import range_in_words, registers_in_words
from firmware_sim.firmware.servo import Servo
from firmware_sim.wire.observed import Heard, Said
from firmware_sim.wire.packet import BROADCAST_ID, STATUS_INSTRUCTION
from firmware_sim.wire.parser import DamagedPacket, Packet, PacketParser
from firmware_sim.wire.parser1 import PacketParser1
from firmware_sim.wire.protocol1 import Instruction1
from firmware_sim.wire.protocol1_shares import bulk_reads_1, sync_writes_1
from firmware_sim.wire.protocol2 import FAST_READS, SHARES_OF_READS, SHARES_OF_WRITES, Instruction
from firmware_sim.wire.protocol2_shares import ReadShare, WriteShare

_BYTES_SHOWN = 400
_WIDTH = 64
"""Of the words before the bytes, characters, where they are not longer."""


def hex_bytes(data: bytes) -> str:
    """Return bytes in hex with blanks; of very many only the first."""
    shown = data[:_BYTES_SHOWN].hex(" ").upper()
    return shown if len(data) <= _BYTES_SHOWN else f"{shown} ... ({len(data)} bytes)"


class Narrator:
    """Says what frames mean; remembers what was asked, to know what an answer holds.

    Parameters
    ----------
    servos : sequence of Servo
        Whose registers they are about.
    start : float
        The time that lines count from, s.
    """

    def __init__(self, servos: Sequence[Servo], start: float) -> None:
        self._servos = tuple(servos)
        self._start = start
        self._asked: dict[int, ReadShare] = {}
        self._fast: Sequence[ReadShare] = ()
        self._ping = False

    def line(self, when: float, direction: str, words: str, data: bytes = b"") -> str:
        """Return one line, with its end."""
        if data:
            words = f"{words:{_WIDTH}} | {hex_bytes(data)}"
        return f"{when - self._start:14.6f} {direction} {words}\n"

    def heard(self, heard: Heard) -> str:
        """Return the line of a request."""
        packet = heard.packet
        if isinstance(packet, DamagedPacket):
            words = self._words(heard.protocol, packet.servo_id, "DAMAGED", "wrong checksum")
            return self.line(heard.when, "->", words, packet.frame)
        names: type[IntEnum] = Instruction if heard.protocol == 2 else Instruction1
        try:
            name = _plain(names(packet.instruction))
        except ValueError:
            name = f"instruction {packet.instruction:02X}"
        self._asked, self._fast = {}, ()
        self._ping = packet.instruction == Instruction.PING
        about = self._about_2(packet) if heard.protocol == 2 else self._about_1(packet)
        words = self._words(heard.protocol, packet.servo_id, name, about)
        return self.line(heard.when, "->", words, packet.frame)

    def said(self, said: Said) -> str:
        """Return the line of an answer."""
        parser = PacketParser() if said.protocol == 2 else PacketParser1()
        found = parser.feed(said.data)
        packet = found[0] if len(found) == 1 else None
        if not isinstance(packet, Packet) or packet.frame != said.data:
            words = self._words(said.protocol, None, "COLLISION", "servos that talk at once")
        elif said.protocol == 1:
            about = self._answer(packet.servo_id, packet.params, errors_1(packet.instruction))
            words = self._words(1, packet.servo_id, "status", about)
        elif packet.instruction != STATUS_INSTRUCTION or not packet.params:
            words = self._words(2, packet.servo_id, "no status", "")
        elif packet.servo_id == BROADCAST_ID:
            words = self._words(2, packet.servo_id, "status", self._fast_answer(packet.params))
        else:
            about = self._answer(packet.servo_id, packet.params[1:], errors_2(packet.params[0]))
            words = self._words(2, packet.servo_id, "status", about)
        return self.line(said.when, "<-", words, said.data)

    def _words(self, protocol: int, servo_id: int | None, name: str, about: str) -> str:
        whom = "?" if servo_id is None else "all" if servo_id == BROADCAST_ID else f"ID {servo_id}"
        return f"{protocol}.0 {whom:6} {name:14} {about}".rstrip()

    def _table(self, servo_id: int) -> ControlTable | None:
        """Return the table behind an ID; for all, of the first servo."""
        for servo in self._servos:
            if servo_id in (servo.servo_id, BROADCAST_ID):
                return servo.model.table
        return None

    def _about_2(self, packet: Packet) -> str:
        instruction, params = packet.instruction, packet.params
        if instruction in SHARES_OF_READS:
            shares = SHARES_OF_READS[instruction](params)
            return self._reads(shares, fast=instruction in FAST_READS)
        if instruction in SHARES_OF_WRITES:
            return self._writes(SHARES_OF_WRITES[instruction](params))
        if instruction == Instruction.READ and len(params) == 4:
            address, size = (int.from_bytes(params[at : at + 2], "little") for at in (0, 2))
            return self._reads([ReadShare(packet.servo_id, address, size)])
        if instruction in (Instruction.WRITE, Instruction.REG_WRITE) and len(params) > 2:
            address = int.from_bytes(params[:2], "little")
            return self._write(packet.servo_id, address, params[2:])
        return hex_bytes(params)

    def _about_1(self, packet: Packet) -> str:
        instruction, params = packet.instruction, packet.params
        if instruction == Instruction1.READ and len(params) == 2:
            return self._reads([ReadShare(packet.servo_id, params[0], params[1])])
        if instruction in (Instruction1.WRITE, Instruction1.REG_WRITE) and len(params) > 1:
            return self._write(packet.servo_id, params[0], params[1:])
        if instruction == Instruction1.BULK_READ:
            return self._reads(bulk_reads_1(params))
        if instruction == Instruction1.SYNC_WRITE:
            return self._writes(sync_writes_1(params))
        return hex_bytes(params)

    def _reads(self, shares: Sequence[ReadShare], *, fast: bool = False) -> str:
        self._asked = {share.servo_id: share for share in shares}
        self._fast = shares if fast else ()
        ranges = {(share.address, share.size) for share in shares}
        names = [
            range_in_words(self._table(share.servo_id), share.address, share.size)
            for share in shares
        ]
        if len(ranges) == 1 and len(set(names)) == 1:
            whom = " ".join(str(share.servo_id) for share in shares)
            return names[0] if len(shares) == 1 and not fast else f"{names[0]} of {whom}"
        return "; ".join(
            f"{share.servo_id}: {name}" for share, name in zip(shares, names, strict=True)
        )

    def _writes(self, shares: list[WriteShare]) -> str:
        return "; ".join(
            f"{share.servo_id}: {self._write(share.servo_id, share.address, share.data)}"
            for share in shares
        )

    def _write(self, servo_id: int, address: int, data: bytes) -> str:
        table = self._table(servo_id)
        return hex_bytes(data) if table is None else registers_in_words(table, address, data)

    def _answer(self, servo_id: int, data: bytes, errors: str) -> str:
        """Return what an answer holds, given what was asked."""
        share, table = self._asked.get(servo_id), self._table(servo_id)
        if share is None and len(self._asked) == 1 and BROADCAST_ID in self._asked:
            share = self._asked[BROADCAST_ID]
        if self._ping and len(data) == 3:
            words = f"model number {data[0] | data[1] << 8}, firmware {data[2]}"
        elif share is not None and table is not None and len(data) == share.size:
            words = registers_in_words(table, share.address, data)
        else:
            words = hex_bytes(data)
        return ", ".join(filter(None, (errors, words)))

    def _fast_answer(self, params: bytes) -> str:
        """Return what a fast read's one answer holds: error, ID, data, CRC of each servo."""
        parts, at = [], 0
        for share in self._fast:
            block = params[at : at + 2 + share.size]
            if len(block) == 2 + share.size:
                parts.append(f"{block[1]}: {self._answer(block[1], block[2:], errors_2(block[0]))}")
            at += len(block) + 2
        return "; ".join(parts)


def errors_2(error: int) -> str:
    """Return the error field of Protocol 2.0 in words, empty for none."""
    words = ["ALERT"] if error & ALERT else []
    number = error & ~ALERT
    if number:
        known = number in tuple(StatusError)
        words.append(f"ERROR {_plain(StatusError(number)) if known else f'number {number}'}")
    return ", ".join(words)


def errors_1(error: int) -> str:
    """Return the error byte of Protocol 1.0 in words, empty for none."""
    return ", ".join(f"ERROR {_plain(bit)}" for bit in ErrorBit if error & bit)


def _plain(code: IntEnum | ErrorBit) -> str:
    return str(code.name).lower().replace("_", " ")
