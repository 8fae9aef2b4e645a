"""Status packets of Protocol 1.0 out of a stream of bytes that arrives in any chunks.

As `armsyn.driver.parser`, but the checksum is weak and the length one byte: a packet is believed
only if its length is one that the request can be answered with.
"""

from __future__ import annotations

from collections.abc import Container

from armsyn.driver.parser import ParserCounters, StatusPacket
from armsyn.driver.protocol1 import HEADER, MAXIMUM_ID, checksum

_BEFORE_BODY = 4
"""Header, ID and length."""

_ANY_LENGTH = range(2, 256)


class StatusParser1:
    """Incremental parser of status packets of Protocol 1.0.

    Parameters
    ----------
    counters : ParserCounters, optional
        To count in.

    Attributes
    ----------
    lengths : container of int
        Values of the length field to believe.
    own : bytes
        What was sent; a packet out of it is an echo.
    """

    def __init__(self, counters: ParserCounters | None = None) -> None:
        self.lengths: Container[int] = _ANY_LENGTH
        self.own = b""
        self.counters = ParserCounters() if counters is None else counters
        self._buffer = bytearray()

    @property
    def pending(self) -> int:
        """Bytes that wait for the rest of their packet."""
        return len(self._buffer)

    def feed(self, data: bytes) -> list[StatusPacket]:
        """Take bytes in, any number, cut anywhere; return the packets they complete."""
        buffer = self._buffer
        buffer += data
        packets = []
        while self._skip_to_header() and len(buffer) >= _BEFORE_BODY:
            end = _BEFORE_BODY + buffer[3]
            if buffer[2] > MAXIMUM_ID or buffer[3] < 2 or buffer[3] not in self.lengths:
                self.counters.bad_length += 1
                self._drop(1)
            elif len(buffer) < end:
                break
            elif (packet := self._take(end)) is not None:
                packets.append(packet)
        return packets

    def reset(self) -> None:
        """Forget what was begun; counted as garbage."""
        self._drop(len(self._buffer))

    def _skip_to_header(self) -> bool:
        """Drop what precedes the next header and ID; False when they are not there yet."""
        buffer = self._buffer
        start = buffer.find(HEADER)
        while start >= 0 and buffer[start + 2 : start + 3] == b"\xff":
            start += 1  # FF FF FF: the header ends with the last of them
        if start < 0:
            self._drop(len(buffer) - buffer.endswith(HEADER[:1]))
            return False
        if start:
            self._drop(start)
        return True

    def _take(self, end: int) -> StatusPacket | None:
        """Remove the packet of `end` bytes; None when it is damaged or an echo."""
        raw = bytes(self._buffer[:end])
        if checksum(raw[2:-1]) != raw[-1]:
            self.counters.bad_crc += 1
            self._drop(1)
            return None
        del self._buffer[:end]
        if raw in self.own:
            self.counters.echoes += 1
            return None
        self.counters.packets += 1
        return StatusPacket(raw[2], raw[4], raw[5:-1], 1)

    def _drop(self, count: int) -> None:
        self.counters.garbage_bytes += count
        del self._buffer[:count]
