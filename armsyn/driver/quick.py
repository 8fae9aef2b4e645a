"""Replies decoded as they come, when they are exactly the bytes that were asked for.

That is how nearly every cycle goes, so it is worth its own way: each servo's bytes are decoded
while the next servo still talks. Whatever is stuffed, noisy, short, or an error without data is
left to the parsers, which find the same packets in the same bytes.
"""

from __future__ import annotations

from collections.abc import Mapping

from fastcrc.crc16 import umts as crc16

from armsyn.driver.parser import StatusPacket
from armsyn.driver.protocol import BROADCAST_ID, HEADER, STATUS

_PATTERN = HEADER[:3]
_BEFORE_ERROR = 8
"""Header, ID, length and instruction."""


def _prefix(identifier: int, length: int) -> bytes:
    return HEADER + bytes((identifier, length & 0xFF, length >> 8, STATUS))


class StatusLayout:
    """Status packets one after the other.

    Parameters
    ----------
    sizes : mapping of int to int
        ID to bytes of data, in the order of the answers.

    Attributes
    ----------
    size : int
        Bytes in all.
    """

    def __init__(self, sizes: Mapping[int, int]) -> None:
        parts = []
        at = 0
        for identifier, size in sizes.items():
            prefix = _prefix(identifier, size + 4)
            error = at + _BEFORE_ERROR
            end = error + 1 + size
            parts.append((identifier, prefix, crc16(prefix), at, error, end))
            at = end + 2
        self.parts = tuple(parts)
        self.size = at


class StatusDecoding:
    """Decodes status packets as they come.

    Parameters
    ----------
    layout : StatusLayout

    Attributes
    ----------
    packets : dict of int to StatusPacket
        Good ones so far.
    """

    __slots__ = ("_layout", "packets")

    def __init__(self, layout: StatusLayout) -> None:
        self._layout = layout
        self.packets: dict[int, StatusPacket] = {}

    def look(self, data: bytes) -> None:
        """Decode what is new in `data`: all that has come so far."""
        packets, available = self.packets, len(data) - 2
        for identifier, prefix, crc, at, error, end in self._layout.parts[len(packets) :]:
            if (
                available < end
                or data[at:error] != prefix
                or crc16(data[error:end], crc) != data[end] | data[end + 1] << 8
            ):
                return
            packets[identifier] = StatusPacket(identifier, data[error], data[error + 1 : end])

    def result(self, data: bytes) -> dict[int, StatusPacket] | None:
        """ID to packet; None when `data` is not exactly one good packet of each."""
        self.look(data)
        parts = len(self._layout.parts)
        whole = len(self.packets) == parts and len(data) == self._layout.size
        # more patterns than headers: something is stuffed
        return self.packets if whole and data.count(_PATTERN) == parts else None


class FastLayout:
    """The one packet with which servos answer a fast sync read.

    It comes from ID 254 and is not stuffed: after the instruction, each servo puts its error
    byte, its ID, its data, and the CRC of everything before them (e-Manual, Protocol 2.0, "Fast
    Sync Read"). It ends early at a servo that is silent.

    Parameters
    ----------
    sizes : mapping of int to int
        ID to bytes of data, in the order of the answers.

    Attributes
    ----------
    size : int
        Bytes in all.
    prefix : bytes
        With which it begins.
    """

    def __init__(self, sizes: Mapping[int, int]) -> None:
        self.size = _BEFORE_ERROR + sum(size + 4 for size in sizes.values())
        self.prefix = _prefix(BROADCAST_ID, self.size - 7)
        self.crc = crc16(self.prefix)
        parts = []
        at = _BEFORE_ERROR
        for identifier, size in sizes.items():
            parts.append((identifier, at, at + 2 + size))
            at += size + 4
        self.parts = tuple(parts)


class FastDecoding:
    """Decodes the parts of a fast answer as they come.

    Each CRC goes on from the one before it, as that was received: a part is judged by its own
    bytes, and a damaged one spoils the next at most.

    Parameters
    ----------
    layout : FastLayout

    Attributes
    ----------
    packets : dict of int to StatusPacket
        Of those servos whose part is good, so far.
    """

    __slots__ = ("_crc", "_layout", "_next", "_start", "packets")

    def __init__(self, layout: FastLayout) -> None:
        self._layout = layout
        self._crc, self._start, self._next = layout.crc, _BEFORE_ERROR, 0
        self.packets: dict[int, StatusPacket] = {}

    def look(self, data: bytes) -> None:
        """Decode what is new in `data`: all that has come so far."""
        if not data.startswith(self._layout.prefix):
            return
        crc, start, available = self._crc, self._start, len(data) - 2
        for identifier, at, end in self._layout.parts[self._next :]:
            if available < end:
                break
            crc = crc16(data[start:end], crc)
            received = data[end] | data[end + 1] << 8
            if crc == received and data[at + 1] == identifier:
                self.packets[identifier] = StatusPacket(identifier, data[at], data[at + 2 : end])
            crc, start = received, end
            self._next += 1
        self._crc, self._start = crc, start

    def result(self, data: bytes) -> dict[int, StatusPacket] | None:
        """ID to packet; None when `data` is not the whole answer, good from end to end."""
        self.look(data)
        whole = len(self.packets) == len(self._layout.parts) and len(data) == self._layout.size
        return self.packets if whole else None
