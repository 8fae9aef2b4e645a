"""Frames of Protocol 2.0 out of a byte stream, however it is cut into chunks.

Source: e-Manual, "DYNAMIXEL Protocol 2.0", Processing Order of Reception. Nothing here reads a
port, and nothing raises for what is on the wire: malformed bytes are dropped and counted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from firmware_sim.wire.packet import CRC_SIZE, HEADER, MIN_LENGTH, PREFIX_SIZE, crc16, unstuff

LENGTH_CAP = 4096
"""Largest LEN believed, bytes: a sync write of 12 bytes to all 253 servos has 3296."""

_REMEMBERED = 256
"""How many requests are known by their bytes; all are forgotten when there are more."""

_READS = frozenset((0x01, 0x02, 0x82, 0x8A, 0x92, 0x9A))
"""Instructions that a client repeats byte for byte: ping, read, and the reads of several."""


class Packet(NamedTuple):
    """One intact frame, of either protocol.

    Parameters
    ----------
    servo_id : int
        Whom it addresses, or who sent it.
    instruction : int
        Its INST byte.
    params : bytes
        Unstuffed.
    end : int
        Where it ended, in bytes since the parser was made.
    frame : bytes
        All of it, as it was on the wire.
    """

    servo_id: int
    instruction: int
    params: bytes
    end: int
    frame: bytes


class DamagedPacket(NamedTuple):
    """A frame of believable shape whose CRC or checksum does not fit.

    Parameters
    ----------
    servo_id : int
        The ID it carries.
    end : int
        Where it ended, in bytes since the parser was made.
    frame : bytes
        All of it, as it was on the wire.
    """

    servo_id: int
    end: int
    frame: bytes


@dataclass(slots=True)
class ParserCounts:
    """What a parser has seen and dropped since it was made.

    Parameters
    ----------
    packets : int
        Intact frames.
    dropped_bytes : int
        Bytes that belonged to no intact frame of the parser's protocol.
    crc_errors : int
        Whole frames with a wrong CRC or checksum.
    bad_heads : int
        Headers followed by an ID or a LEN that cannot be.
    cut_short : int
        Frames in which another header began, where headers restart.
    gaps : int
        Frames given up for a silence in them.
    """

    packets: int = 0
    dropped_bytes: int = 0
    crc_errors: int = 0
    bad_heads: int = 0
    cut_short: int = 0
    gaps: int = 0


class PacketParser:
    """Frames out of a byte stream that arrives in chunks of any size.

    Parameters
    ----------
    length_cap : int
        A LEN above it is not believed, bytes.
    restart : bool
        Whether a header within a frame begins a new one, which no servo does; see the notes.

    Notes
    -----
    A servo that has found a header with a valid ID takes as many bytes as LEN says, then looks at
    the CRC, and goes on behind them (Processing Order of Reception): a frame that was cut short
    swallows the beginning of what follows it at once. A silence is the way out: `give_up`.

    Where nobody notices silences, `restart` lets no LEN that lies hold up a bus for ever: stuffing
    keeps ``FF FF FD 00`` out of a frame's parameters, so that a header inside a frame means that
    the frame was cut short. (Only the CRC field's last byte can complete a header honestly.) A
    frame with a wrong CRC is then looked through again from its second byte on.
    """

    def __init__(self, length_cap: int = LENGTH_CAP, restart: bool = False) -> None:
        self.counts = ParserCounts()
        self._length_cap = length_cap
        self._restart = restart
        self._buffer = bytearray()
        self._offset = 0  # stream position of the buffer's first byte
        self._known: dict[bytes, Packet] = {}

    @property
    def received(self) -> int:
        """How many bytes were fed since the parser was made."""
        return self._offset + len(self._buffer)

    @property
    def pending(self) -> int:
        """How many bytes wait for the rest of their frame."""
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
        if not self._buffer and chunk in self._known:
            self._offset += len(chunk)
            self.counts.packets += 1
            return [_seen_again(self._known[chunk], self._offset)]
        self._buffer += chunk
        found: list[Packet | DamagedPacket] = []
        while self._buffer.startswith(HEADER) or self._seek_header():
            total = self._frame_size()
            if total is None:
                continue
            if total == 0 or len(self._buffer) < total:
                break
            found.append(self._take(total))
        return found

    def give_up(self) -> None:
        """Drop an unfinished frame, as a servo does after a silence on the line."""
        if self._buffer:
            self.counts.gaps += 1
            self._drop(len(self._buffer))

    def _drop(self, count: int) -> None:
        del self._buffer[:count]
        self._offset += count
        self.counts.dropped_bytes += count

    def _seek_header(self) -> bool:
        """Bring a header to the front of the buffer; False when none is whole yet."""
        start = self._buffer.find(HEADER)
        if start >= 0:
            self._drop(start)
            return True
        keep = next(n for n in (3, 2, 1, 0) if self._buffer.endswith(HEADER[:n]))
        if len(self._buffer) > keep:
            self._drop(len(self._buffer) - keep)
        return False

    def _frame_size(self) -> int | None:
        """Size of the frame in front; 0 if not known yet, None if it was dropped."""
        buffer = self._buffer
        if len(buffer) > 4 and buffer[4] in (253, 255):
            self._drop_head()
            return None
        if len(buffer) < PREFIX_SIZE:
            return 0
        length = buffer[5] | buffer[6] << 8
        if not MIN_LENGTH <= length <= self._length_cap:
            self._drop_head()
            return None
        total = PREFIX_SIZE + length
        header = buffer.find(HEADER, 1, total - 1) if self._restart else -1
        if header < 0:
            return total
        self.counts.cut_short += 1
        self._drop(header)
        return None

    def _drop_head(self) -> None:
        self.counts.bad_heads += 1
        self._drop(1)

    def _take(self, total: int) -> Packet | DamagedPacket:
        """Remove the whole frame in front; where headers restart, a damaged one's first byte."""
        frame = bytes(self._buffer[:total])
        end = self._offset + total
        known = self._known.get(frame)
        if known is None and crc16(frame[:-CRC_SIZE]) != frame[-2] | frame[-1] << 8:
            self.counts.crc_errors += 1
            self._drop(1 if self._restart else total)
            return DamagedPacket(frame[4], end, frame)
        del self._buffer[:total]
        self._offset = end
        self.counts.packets += 1
        if known is not None:
            return _seen_again(known, end)
        body = unstuff(frame[PREFIX_SIZE:-CRC_SIZE])
        packet = Packet(frame[4], body[0], body[1:], end, frame)
        if body[0] in _READS:
            self._remember(packet)
        return packet

    def _remember(self, packet: Packet) -> None:
        """Know the frame again by its bytes, which saves its CRC."""
        if len(self._known) >= _REMEMBERED:
            self._known.clear()
        self._known[packet.frame] = packet


def _seen_again(packet: Packet, end: int) -> Packet:
    servo_id, instruction, params, _end, frame = packet
    return Packet(servo_id, instruction, params, end, frame)
