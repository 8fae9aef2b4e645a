"""Replies decoded at one go, when they are exactly the bytes that were asked for.

That is how nearly every cycle ends, so it is worth its own way. Whatever is stuffed, noisy, short,
or an error without data is left to the parsers, which find the same packets in the same bytes.
"""

from __future__ import annotations

from collections.abc import Mapping

from armsyn.driver.crc import crc16
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
    """

    def __init__(self, sizes: Mapping[int, int]) -> None:
        self._parts = []
        at = 0
        for identifier, size in sizes.items():
            prefix = _prefix(identifier, size + 4)
            error = at + _BEFORE_ERROR
            end = error + 1 + size
            self._parts.append((identifier, prefix, crc16(prefix), at, error, end))
            at = end + 2
        self.size = at

    def decode(self, data: bytes) -> dict[int, StatusPacket] | None:
        """ID to packet; None when `data` is not exactly one good packet of each."""
        if len(data) != self.size or data.count(_PATTERN) != len(self._parts):
            return None  # more patterns than headers: something is stuffed
        packets = {}
        for identifier, prefix, crc, at, error, end in self._parts:
            good = crc16(data[error:end], crc) == data[end] | data[end + 1] << 8
            if not good or data[at:error] != prefix:
                return None
            packets[identifier] = StatusPacket(identifier, data[error], data[error + 1 : end])
        return packets


class FastLayout:
    """The one packet with which servos answer a fast sync read.

    It comes from ID 254 and is not stuffed: after the instruction, each servo puts its error
    byte, its ID, its data, and the CRC of everything before them (e-Manual, Protocol 2.0, "Fast
    Sync Read"). It ends early at a servo that is silent.

    Parameters
    ----------
    sizes : mapping of int to int
        ID to bytes of data, in the order of the answers.
    """

    def __init__(self, sizes: Mapping[int, int]) -> None:
        self.size = _BEFORE_ERROR + sum(size + 4 for size in sizes.values())
        self.prefix = _prefix(BROADCAST_ID, self.size - 7)
        self._crc = crc16(self.prefix)
        self._parts = []
        at = _BEFORE_ERROR
        for identifier, size in sizes.items():
            self._parts.append((identifier, at, at + 2 + size))
            at += size + 4
        self.parts = len(self._parts)

    def decode(self, data: bytes) -> dict[int, StatusPacket] | None:
        """ID to packet; None when `data` is not the whole packet, good from end to end."""
        if len(data) != self.size:
            return None
        packets = self.good_parts(data)
        return packets if len(packets) == len(self._parts) else None

    def good_parts(self, data: bytes) -> dict[int, StatusPacket]:
        """Packets of those servos whose part is good, of `data` that may end early.

        Each CRC goes on from the one before it, as that was received: a part is judged by its
        own bytes, and a damaged one spoils the next at most.
        """
        packets: dict[int, StatusPacket] = {}
        if not data.startswith(self.prefix):
            return packets
        crc, start = self._crc, _BEFORE_ERROR
        for identifier, at, end in self._parts:
            if len(data) < end + 2:
                break
            crc = crc16(data[start:end], crc)
            received = data[end] | data[end + 1] << 8
            if crc == received and data[at + 1] == identifier:
                packets[identifier] = StatusPacket(identifier, data[at], data[at + 2 : end])
            crc, start = received, end
        return packets
