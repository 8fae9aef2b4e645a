"""Frames of Protocol 1.0 out of a byte stream, however it is cut into chunks.

Source: e-Manual, "DYNAMIXEL Protocol 1.0", Instruction Packet. Nothing here reads a port, and
nothing raises for what is on the wire: malformed bytes are dropped and counted.
"""

from __future__ import annotations

from firmware_sim.wire.packet1 import HEADER_1, MIN_LENGTH_1, PREFIX_SIZE_1
from firmware_sim.wire.parser import DamagedPacket, Packet, ParserCounts


class PacketParser1:
    """Frames out of a byte stream that arrives in chunks of any size.

    Notes
    -----
    Nothing is stuffed in this protocol, so that ``FF FF`` within a frame says nothing. A frame
    with a wrong checksum is dropped only as far as its first byte: what a LEN that lies took in is
    looked through again. The header of Protocol 2.0 reads as ID 253 with LEN 0, which cannot be,
    and is passed over.
    """

    def __init__(self) -> None:
        self.counts = ParserCounts()
        self._buffer = bytearray()
        self._offset = 0  # stream position of the buffer's first byte

    @property
    def received(self) -> int:
        """How many bytes were fed since the parser was made."""
        return self._offset + len(self._buffer)

    @property
    def pending(self) -> int:
        """How many bytes wait for the rest of their frame; 258 at most."""
        return len(self._buffer)

    def feed(self, chunk: bytes) -> list[Packet | DamagedPacket]:
        """Take bytes and return the frames they complete, in order.

        Parameters
        ----------
        chunk : bytes
            What arrived.

        Returns
        -------
        list of Packet or DamagedPacket
            The same for any chunking of the same stream.
        """
        self._buffer += chunk
        found: list[Packet | DamagedPacket] = []
        while self._seek_header() and len(self._buffer) >= PREFIX_SIZE_1:
            length = self._buffer[3]
            if length < MIN_LENGTH_1:
                self.counts.bad_heads += 1
                self._drop(1)
            elif len(self._buffer) >= PREFIX_SIZE_1 + length:
                found.append(self._take(PREFIX_SIZE_1 + length))
            else:
                break
        return found

    def give_up(self) -> None:
        """Drop an unfinished frame, as a servo does after a silence on the line."""
        if self._buffer:
            self.counts.gaps += 1
            self._drop(len(self._buffer))

    def discard(self) -> None:
        """Drop what waits: it has turned out to belong to a frame of the other protocol."""
        self._drop(len(self._buffer))

    def _drop(self, count: int) -> None:
        del self._buffer[:count]
        self._offset += count
        self.counts.dropped_bytes += count

    def _seek_header(self) -> bool:
        """Bring a header to the front of the buffer; False when none is whole yet."""
        buffer = self._buffer
        start = buffer.find(HEADER_1)
        if start < 0:
            keep = 1 if buffer.endswith(HEADER_1[:1]) else 0
            self._drop(len(buffer) - keep)
            return False
        while len(buffer) > start + 2 and buffer[start + 2] == HEADER_1[0]:
            start += 1  # an ID is never FF: the header ends later
        self._drop(start)
        return True

    def _take(self, total: int) -> Packet | DamagedPacket:
        """Remove the whole frame in front; of a damaged one, only its first byte."""
        frame = bytes(self._buffer[:total])
        end = self._offset + total
        if sum(frame[2:]) & 0xFF != 0xFF:  # with its checksum, a frame sums up to FF
            self.counts.crc_errors += 1
            self._drop(1)
            return DamagedPacket(frame[2], end, frame)
        del self._buffer[:total]
        self._offset = end
        self.counts.packets += 1
        return Packet(frame[2], frame[4], frame[5:-1], end, frame)
