"""Frames of both protocols out of one byte stream."""

from __future__ import annotations

from typing import NamedTuple

from firmware_sim.wire.parser import DamagedPacket, Packet, PacketParser
from firmware_sim.wire.parser1 import PacketParser1


class Arrival(NamedTuple):
    """A frame and where it became known.

    Parameters
    ----------
    protocol : int
        1 or 2.
    packet : Packet or DamagedPacket
        The frame.
    end : int
        Where it ended, in bytes since the chunk's beginning; not above 0 for a frame that an
        earlier chunk held, hidden in a damaged one.
    """

    protocol: int
    packet: Packet | DamagedPacket
    end: int


class Ears:
    """The parsers of both protocols side by side.

    Parameters
    ----------
    restart : bool
        See `PacketParser`.

    Notes
    -----
    A servo of protocol 1.0 may believe that a frame of its own begins within one of protocol 2.0,
    since any ``FF FF`` looks like a header to it: negative numbers do. Such a belief ends with the
    frame of protocol 2.0 that it began in, so that it never takes in the next request.
    """

    def __init__(self, restart: bool = False) -> None:
        self.parser = PacketParser(restart=restart)
        self.parser1 = PacketParser1()

    def feed(self, chunk: bytes, both: bool) -> list[Arrival]:
        """Take bytes and return the frames they complete.

        Parameters
        ----------
        chunk : bytes
            What arrived.
        both : bool
            Whether anybody listens for protocol 1.0.

        Returns
        -------
        list of Arrival
            In the order in which they become known.
        """
        base = self.parser.received
        found = [Arrival(2, packet, packet.end - base) for packet in self.parser.feed(chunk)]
        if both:
            return self._mix(chunk, found)
        self.parser1.discard()
        return found

    def give_up(self, protocol: int) -> None:
        """Drop an unfinished frame of a protocol, as a servo does after a silence."""
        (self.parser1 if protocol == 1 else self.parser).give_up()

    def _mix(self, chunk: bytes, found: list[Arrival]) -> list[Arrival]:
        base = self.parser1.received
        mixed: list[Arrival] = []
        position = 0
        for item in found:
            place = max(position, item.end)
            mixed += self._feed_1(chunk[position:place], base)
            position = place
            if isinstance(item.packet, Packet) and item.end == place:
                self.parser1.discard()
            mixed.append(item)
        return mixed + self._feed_1(chunk[position:], base)

    def _feed_1(self, piece: bytes, base: int) -> list[Arrival]:
        return [Arrival(1, packet, packet.end - base) for packet in self.parser1.feed(piece)]
