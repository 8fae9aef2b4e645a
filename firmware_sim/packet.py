"""Frames of Protocol 2.0: CRC, byte stuffing, building, and an incremental parser.

Source: e-Manual, "DYNAMIXEL Protocol 2.0" (Instruction Packet, Status Packet, Packet Process) and
"CRC Calculation". A frame on the wire::

    FF FF FD 00   header, reserved
    ID            0-252, 254 for all
    LEN LEN       bytes that follow, little-endian, counted after stuffing
    INST          instruction; 55 in a status packet
    PARAM ...     stuffed; a status packet's first one is its error field
    CRC CRC       CRC-16 of everything before it, little-endian, computed after stuffing

Nothing here reads or writes a port, and nothing raises for what is on the wire.
"""

from __future__ import annotations

from dataclasses import dataclass

HEADER = b"\xff\xff\xfd\x00"
STATUS_INSTRUCTION = 0x55
BROADCAST_ID = 0xFE
MAX_ID = 252

_PREFIX = 7  # header, ID, LEN
_CRC_SIZE = 2
_MIN_LENGTH = 3  # INST and CRC
_STUFFED_MARK = b"\xff\xff\xfd"
_STUFFED = b"\xff\xff\xfd\xfd"

LENGTH_CAP = 4096
"""Largest LEN believed, bytes: a sync write of 12 bytes to all 253 servos has 3296."""


def _crc_table() -> tuple[int, ...]:
    """CRC-16 of each single byte: polynomial 0x8005, most significant bit first."""
    table = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = ((crc << 1) ^ 0x8005) & 0xFFFF if crc & 0x8000 else crc << 1
        table.append(crc)
    return tuple(table)


_CRC_TABLE = _crc_table()


def crc16(data: bytes | bytearray) -> int:
    """Return the CRC-16 of a frame up to its CRC field.

    Parameters
    ----------
    data : bytes or bytearray
        From the header to the last parameter, stuffed.

    Returns
    -------
    int
        0 to 65535; start value 0, no final xor (e-Manual, "CRC Calculation").
    """
    crc = 0
    table = _CRC_TABLE
    for byte in data:
        crc = ((crc << 8) & 0xFFFF) ^ table[(crc >> 8) ^ byte]
    return crc


def stuff(params: bytes) -> bytes:
    """Return the parameters with ``FD`` put in after every ``FF FF FD``."""
    return params.replace(_STUFFED_MARK, _STUFFED)


def unstuff(params: bytes) -> bytes:
    """Return the parameters without the bytes that ``stuff`` put in."""
    return params.replace(_STUFFED, _STUFFED_MARK)


def build_packet(servo_id: int, instruction: int, params: bytes = b"") -> bytes:
    """Return a whole frame, stuffed and with its CRC.

    Parameters
    ----------
    servo_id : int
        0 to 252, or 254 for all.
    instruction : int
        0 to 255.
    params : bytes
        Unstuffed parameters.

    Returns
    -------
    bytes
        The frame as it goes out.
    """
    body = stuff(params)
    frame = HEADER + bytes((servo_id,)) + (len(body) + _MIN_LENGTH).to_bytes(2, "little")
    frame += bytes((instruction,)) + body
    return frame + crc16(frame).to_bytes(2, "little")


def build_status(servo_id: int, error: int, params: bytes = b"") -> bytes:
    """Return a status packet: an answer of a servo with its error field."""
    return build_packet(servo_id, STATUS_INSTRUCTION, bytes((error,)) + params)


@dataclass(frozen=True, slots=True)
class Packet:
    """One intact frame.

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
    """

    servo_id: int
    instruction: int
    params: bytes
    end: int


@dataclass(frozen=True, slots=True)
class DamagedPacket:
    """A frame of believable shape whose CRC does not fit.

    Parameters
    ----------
    servo_id : int
        The ID it carries.
    end : int
        Where it ended, in bytes since the parser was made.
    """

    servo_id: int
    end: int


@dataclass(slots=True)
class ParserCounts:
    """What a parser has seen and dropped since it was made.

    Parameters
    ----------
    packets : int
        Intact frames.
    dropped_bytes : int
        Bytes that belonged to no intact frame.
    crc_errors : int
        Whole frames with a wrong CRC.
    bad_heads : int
        Headers followed by an ID or a LEN that cannot be.
    cut_short : int
        Frames in which another header began.
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

    Notes
    -----
    Stuffing keeps ``FF FF FD 00`` out of a frame's parameters, so a header inside a frame means
    that the frame was cut short: the parser starts again there. A LEN that lies therefore never
    swallows the next request. (Only the CRC field's last byte can complete a header honestly.)
    """

    def __init__(self, length_cap: int = LENGTH_CAP) -> None:
        self.counts = ParserCounts()
        self._length_cap = length_cap
        self._buffer = bytearray()
        self._offset = 0  # stream position of the buffer's first byte

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
        self._buffer += chunk
        found: list[Packet | DamagedPacket] = []
        while self._seek_header():
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
            if start:
                self._drop(start)
            return True
        keep = next(n for n in (3, 2, 1, 0) if self._buffer.endswith(HEADER[:n]))
        self._drop(len(self._buffer) - keep)
        return False

    def _frame_size(self) -> int | None:
        """Size of the frame in front; 0 if not known yet, None if it was dropped."""
        buffer = self._buffer
        if len(buffer) > 4 and buffer[4] in (253, 255):
            self._drop_head()
            return None
        if len(buffer) < _PREFIX:
            return 0
        length = buffer[5] | buffer[6] << 8
        if not _MIN_LENGTH <= length <= self._length_cap:
            self._drop_head()
            return None
        total = _PREFIX + length
        restart = buffer.find(HEADER, 1, total - 1)
        if restart < 0:
            return total
        self.counts.cut_short += 1
        self._drop(restart)
        return None

    def _drop_head(self) -> None:
        self.counts.bad_heads += 1
        self._drop(1)

    def _take(self, total: int) -> Packet | DamagedPacket:
        """Remove the whole frame in front; a damaged one only as far as it is surely damaged."""
        frame = bytes(self._buffer[:total])
        end = self._offset + total
        if crc16(frame[:-_CRC_SIZE]) != int.from_bytes(frame[-_CRC_SIZE:], "little"):
            self.counts.crc_errors += 1
            self._drop(1)
            return DamagedPacket(frame[4], end)
        del self._buffer[:total]
        self._offset = end
        self.counts.packets += 1
        return Packet(frame[4], frame[7], unstuff(frame[8:-_CRC_SIZE]), end)
