"""Status packets out of a stream of bytes that arrives in any chunks, with anything in between.

What is malformed is dropped and counted, never raised: noise is a fact of a bus, not an error of
the caller. The parser does no input or output.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from fastcrc.crc16 import umts as crc16

from armsyn.driver.protocol import ALERT, HEADER, MAXIMUM_ID, STATUS, STATUS_ERRORS, unstuff
from armsyn.driver.protocol1 import HARDWARE_ERRORS, flag_names

_BEFORE_BODY = 7
"""Header, ID and length."""

_SHORTEST_LENGTH = 3
"""Instruction and CRC."""


class StatusPacket(NamedTuple):
    """What a servo answered.

    Attributes
    ----------
    servo_id : int
    error : int
        The error byte as it came. Protocol 2.0: bit 7 alert, bits 0-6 an error number;
        protocol 1.0: flags.
    parameters : bytes
        Unstuffed.
    protocol : {1, 2}
    """

    servo_id: int
    error: int
    parameters: bytes
    protocol: int = 2

    @property
    def alert(self) -> bool:
        """Whether the servo reports a hardware error."""
        return bool(self.error & (ALERT if self.protocol == 2 else HARDWARE_ERRORS))

    @property
    def error_number(self) -> int:
        """What is wrong with the request; 0 for nothing. Protocol 2.0: a number, 1.0: flags."""
        return self.error & ~(ALERT if self.protocol == 2 else HARDWARE_ERRORS)

    @property
    def error_name(self) -> str:
        """Words for `error_number`."""
        if self.protocol == 1:
            return flag_names(self.error_number)
        return STATUS_ERRORS.get(self.error_number, f"error {self.error_number}")

    @property
    def hardware_error(self) -> int | None:
        """As Hardware Error Status has it, where the packet says it (protocol 1.0), else None."""
        return None if self.protocol == 2 else self.error & HARDWARE_ERRORS


@dataclass
class ParserCounters:
    """What a parser has met so far.

    Attributes
    ----------
    packets : int
        Good status packets.
    foreign : int
        Good packets of another master: no status, and not what was sent.
    echoes : int
        Good packets that were sent by ourselves.
    bad_crc, bad_length : int
        Packets dropped because their CRC or length field is wrong.
    garbage_bytes : int
        Bytes that belong to no good packet, or to a status of no one servo.
    """

    packets: int = 0
    foreign: int = 0
    echoes: int = 0
    bad_crc: int = 0
    bad_length: int = 0
    garbage_bytes: int = 0


class StatusParser:
    """Incremental parser of status packets.

    Parameters
    ----------
    maximum_length : int
        Greatest value of the length field to believe. Waiting for the bytes that a corrupted
        length announces would stall the bus; a caller that knows what it asked for sets
        the attribute accordingly.
    counters : ParserCounters, optional
        To count in.

    Attributes
    ----------
    own : bytes
        What was sent; a packet out of it is an echo.
    """

    def __init__(self, maximum_length: int = 1024, counters: ParserCounters | None = None) -> None:
        self.maximum_length = maximum_length
        self.own = b""
        self.counters = ParserCounters() if counters is None else counters
        self._buffer = bytearray()

    @property
    def pending(self) -> int:
        """Bytes that wait for the rest of their packet."""
        return len(self._buffer)

    def feed(self, data: bytes) -> list[StatusPacket]:
        """Take bytes in and return the packets they complete.

        Parameters
        ----------
        data : bytes
            Any number, cut anywhere.

        Returns
        -------
        list of StatusPacket
        """
        self._buffer += data
        packets = []
        while self._buffer and self._skip_to_header():
            end = self._end_of_packet()
            if end is None:
                break
            if end == 0:
                self._drop(1)
                continue
            packet = self._take(end)
            if packet is not None:
                packets.append(packet)
        return packets

    def reset(self) -> None:
        """Forget what was begun; counted as garbage."""
        self._drop(len(self._buffer))

    def _skip_to_header(self) -> bool:
        """Drop what precedes the next header; False when there is no whole header yet."""
        buffer = self._buffer
        start = buffer.find(HEADER)
        if start < 0:
            kept = next((n for n in (3, 2, 1) if buffer.endswith(HEADER[:n])), 0)
            self._drop(len(buffer) - kept)
            return False
        if start:
            self._drop(start)
        return True

    def _end_of_packet(self) -> int | None:
        """Size of the packet at the buffer's start; None: wait; 0: it is none."""
        buffer = self._buffer
        if len(buffer) < _BEFORE_BODY:
            return None
        length = buffer[5] | buffer[6] << 8
        if not _SHORTEST_LENGTH <= length <= self.maximum_length:
            self.counters.bad_length += 1
            return 0
        end = _BEFORE_BODY + length
        if len(buffer) >= end:
            return end
        # stuffing keeps headers out of packets, so a second one means the first broke off
        return 0 if buffer.find(HEADER, 4) > 0 else None

    def _take(self, end: int) -> StatusPacket | None:
        """Remove the packet of `end` bytes; None when it is damaged or no status."""
        raw = bytes(self._buffer[:end])
        if crc16(raw[:-2]) != raw[-2] | raw[-1] << 8:
            self.counters.bad_crc += 1
            self._drop(1)  # a good packet may begin inside the damaged one
            return None
        del self._buffer[:end]
        body = unstuff(raw[_BEFORE_BODY:-2])
        if body[0] != STATUS:
            self._count_stranger(raw)
            return None
        if len(body) < 2 or raw[4] > MAXIMUM_ID:  # as of a fast read that came too late
            self.counters.garbage_bytes += end
            return None
        self.counters.packets += 1
        return StatusPacket(raw[4], body[1], body[2:])

    def _count_stranger(self, raw: bytes) -> None:
        if raw in self.own:
            self.counters.echoes += 1
        else:
            self.counters.foreign += 1

    def _drop(self, count: int) -> None:
        self.counters.garbage_bytes += count
        del self._buffer[:count]
