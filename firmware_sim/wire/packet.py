"""Frames of Protocol 2.0: CRC, byte stuffing, building.

Source: e-Manual, "DYNAMIXEL Protocol 2.0" (Instruction Packet, Status Packet, Packet Process, Fast
Sync Read) and "CRC Calculation". A frame on the wire::

    FF FF FD 00   header, reserved
    ID            0-252, 254 for all
    LEN LEN       bytes that follow, little-endian, counted after stuffing
    INST          instruction; 55 in a status packet
    PARAM ...     stuffed, INST included; a status packet's first one is its error field
    CRC CRC       CRC-16 of everything before it, little-endian, computed after stuffing

The other way, from bytes to frames, is in `parser`.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from functools import lru_cache
from struct import Struct

HEADER = b"\xff\xff\xfd\x00"
STATUS_INSTRUCTION = 0x55
BROADCAST_ID = 0xFE

PREFIX_SIZE = 7
"""Bytes before INST: header, ID, LEN."""

CRC_SIZE = 2
"""Bytes after the last parameter."""

MIN_LENGTH = 3
"""Smallest LEN: INST and CRC."""

MAX_LENGTH = 0xFFFF
"""Largest LEN that its two bytes can say."""

FAST_OVERHEAD = 4
"""Bytes that a servo's part of a fast answer has beside its data: ERR, ID, CRC."""

_STUFFED_MARK = b"\xff\xff\xfd"
_STUFFED = b"\xff\xff\xfd\xfd"


def _byte_table() -> list[int]:
    """CRC-16 of each single byte: polynomial 0x8005, most significant bit first."""
    table = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = ((crc << 1) ^ 0x8005) & 0xFFFF if crc & 0x8000 else crc << 1
        table.append(crc)
    return table


def _word_table() -> array[int]:
    """CRC-16 of each pair of bytes: it takes half the steps, which are this module's cost.

    As a list it would take 2 MB, and lie outside the caches whenever it is needed.
    """
    table: array[int] = array("H")
    for first in _BYTE_TABLE:
        high, low = first >> 8, (first << 8) & 0xFFFF
        table.extend(low ^ _BYTE_TABLE[high ^ byte] for byte in range(256))
    return table


_BYTE_TABLE = _byte_table()
_WORD_TABLE = _word_table()
_WORDS = tuple(Struct(f">{count}H").unpack_from for count in range(32))
"""What takes so many pairs of bytes out of a short piece; for a long one it is made when needed."""

_HEADS_KEPT = 4096
"""Beginnings of status packets remembered: a bus has few, and a hostile client makes no more."""

_NO_ERROR_FIELD = 0xFF
"""The one error field that may be part of what is stuffed; no servo has it."""


def crc16(data: bytes | bytearray, start: int = 0) -> int:
    """Return the CRC-16 of a frame up to its CRC field.

    Parameters
    ----------
    data : bytes or bytearray
        From the header to the last parameter, stuffed.
    start : int
        The CRC of what went before, where `data` goes on from there.

    Returns
    -------
    int
        0 to 65535; start value 0, no final xor (e-Manual, "CRC Calculation").
    """
    size = len(data)
    count = size >> 1
    table = _WORD_TABLE
    crc = start
    words = _WORDS[count] if count < len(_WORDS) else Struct(f">{count}H").unpack_from
    for word in words(data):
        crc = table[crc ^ word]
    if size & 1:
        crc = (crc << 8) & 0xFFFF ^ _BYTE_TABLE[crc >> 8 ^ data[-1]]
    return crc


def stuff(body: bytes) -> bytes:
    """Return instruction and parameters with ``FD`` put in after every ``FF FF FD``."""
    return body.replace(_STUFFED_MARK, _STUFFED)


def unstuff(body: bytes) -> bytes:
    """Return instruction and parameters without the bytes that ``stuff`` put in."""
    return body.replace(_STUFFED, _STUFFED_MARK)


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
    body = stuff(bytes((instruction,)) + params)
    length = len(body) + CRC_SIZE
    frame = b"%b%c%c%c%b" % (HEADER, servo_id, length & 0xFF, length >> 8, body)
    return frame + crc16(frame).to_bytes(2, "little")


def build_status(servo_id: int, error: int, params: bytes = b"") -> bytes:
    """Return a status packet: an answer of a servo with its error field."""
    if _STUFFED_MARK in params or error == _NO_ERROR_FIELD:
        return build_packet(servo_id, STATUS_INSTRUCTION, bytes((error,)) + params)
    head, crc = _status_head(servo_id, error, len(params))
    return head + params + crc16(params, crc).to_bytes(2, "little")


@lru_cache(_HEADS_KEPT)
def _status_head(servo_id: int, error: int, size: int) -> tuple[bytes, int]:
    """Return a status packet up to its error field, and the CRC of that, for data of a size."""
    length = MIN_LENGTH + 1 + size
    prefix = (servo_id, length & 0xFF, length >> 8, STATUS_INSTRUCTION, error)
    head = HEADER + bytes(prefix)
    return head, crc16(head)


def build_fast_status(length: int, parts: Iterable[tuple[int, int, bytes]]) -> bytes:
    """Return the one status packet that servos build together for a fast read.

    Parameters
    ----------
    length : int
        Its LEN, as the first servo reckons it from the request: 1 and each servo's part.
    parts : iterable of (int, int, bytes)
        Error field, ID and data of each servo, in order. Where fewer come than `length` counts,
        the packet stays unfinished.

    Returns
    -------
    bytes
        Not stuffed. Each part ends with the CRC of everything before it, the earlier CRCs
        included, as the manual's example bytes have it.
    """
    head = HEADER + bytes((BROADCAST_ID, length & 0xFF, length >> 8, STATUS_INSTRUCTION))
    pieces = [head]
    crc, tail = crc16(head), b""
    for error, servo_id, data in parts:
        piece = b"%b%c%c%b" % (tail, error, servo_id, data)
        crc = crc16(piece, crc)
        tail = crc.to_bytes(2, "little")
        pieces.append(piece)
    return b"".join((*pieces, tail))
