"""Replies to one request, gathered from bytes as they arrive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from armsyn.driver.parser import ParserCounters, StatusPacket
from armsyn.driver.quick import FastDecoding, FastLayout


@dataclass
class BusCounters:
    """What a bus has met so far.

    Attributes
    ----------
    transactions : int
        Requests that wait for replies.
    timeouts : int
        Those that lacked one at their deadline.
    unexpected : int
        Good packets of a servo, or of a size, that was not asked for.
    drained_bytes : int
        Late bytes thrown away after a time-out.
    unsolicited_bytes : int
        Bytes that came when nothing had been asked for: another master's traffic, two servos of
        one ID, or noise.
    echoed_bytes : int
        What the adapter gave back of what was sent.
    """

    transactions: int = 0
    timeouts: int = 0
    unexpected: int = 0
    drained_bytes: int = 0
    unsolicited_bytes: int = 0
    echoed_bytes: int = 0


class Echo:
    """Takes what was sent out of what comes back, where the adapter hears itself.

    Bytes are held back only while they could still be the beginning of an echo; an echo that is
    not whole is left to the parser.
    """

    def __init__(self, sent: bytes) -> None:
        self._sent = sent
        self._held = b""
        self.stripped = 0

    def strip(self, data: bytes) -> bytes:
        """Return `data` without the echo; what may be one of it is held back."""
        if not self._sent:
            return data
        held, sent = self._held + data, self._sent
        if held.startswith(sent):
            self.stripped = len(sent)
            held = held[len(sent) :]
        elif sent.startswith(held):
            self._held = held
            return b""
        self._sent = self._held = b""
        return held

    def rest(self) -> bytes:
        """Return what is still held back."""
        held, self._held, self._sent = self._held, b"", b""
        return held


class Collector(Protocol):
    """Finds replies in bytes."""

    replies: dict[int, StatusPacket]

    @property
    def complete(self) -> bool:
        """Whether nothing more is to come."""
        ...

    def feed(self, data: bytes) -> None:
        """Take bytes in, cut anywhere."""
        ...

    def finish(self) -> None:
        """Use what there is: no more will come."""
        ...


class Parser(Protocol):
    """Status packets out of bytes; of either protocol."""

    def feed(self, data: bytes) -> list[StatusPacket]:
        """Take bytes in and return the packets they complete."""
        ...


class StatusCollector:
    """Waits for one status packet of each servo.

    Parameters
    ----------
    sizes : mapping of int to int
        ID to bytes of data.
    parser : Parser
    counters : BusCounters
        To count packets in that nobody asked for.
    """

    def __init__(self, sizes: Mapping[int, int], parser: Parser, counters: BusCounters) -> None:
        self.replies: dict[int, StatusPacket] = {}
        self._sizes = dict(sizes)
        self._parser = parser
        self._counters = counters

    @property
    def complete(self) -> bool:
        """Whether nothing is missing."""
        return not self._sizes

    def feed(self, data: bytes) -> None:
        """Take bytes in, cut anywhere."""
        for packet in self._parser.feed(data):
            size = self._sizes.get(packet.servo_id)
            if size is None or not (packet.error_number or len(packet.parameters) == size):
                self._counters.unexpected += 1
                continue
            del self._sizes[packet.servo_id]
            self.replies[packet.servo_id] = packet

    def finish(self) -> None:
        """Do nothing: packets are used as they come."""


class FastCollector:
    """Waits for the one packet of a fast sync read.

    Parameters
    ----------
    layout : FastLayout
    counters : ParserCounters
        To count packets in.
    """

    def __init__(self, layout: FastLayout, counters: ParserCounters) -> None:
        self.replies: dict[int, StatusPacket] = {}
        self._counters = counters
        self.complete = False
        self._layout = layout
        self._buffer = b""

    def feed(self, data: bytes) -> None:
        """Take bytes in, cut anywhere."""
        self._buffer += data
        start = self._buffer.find(self._layout.prefix)
        if start >= 0 and len(self._buffer) - start >= self._layout.size:
            self.finish()
            self.complete = True
            self._counters.bad_crc += len(self._layout.parts) - len(self.replies)

    def finish(self) -> None:
        """Use the parts that have come: a silent servo ends the packet early."""
        start = self._buffer.find(self._layout.prefix)
        if start >= 0:
            decoding = FastDecoding(self._layout)
            decoding.look(self._buffer[start:])
            self.replies = decoding.packets
            self._counters.packets += len(self.replies)
