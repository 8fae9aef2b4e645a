"""Frames of Protocol 2.0: CRC, byte stuffing, building.

Source: e-Manual, "DYNAMIXEL Protocol 2.0" (Instruction Packet, Status Packet, Packet Process) and
"CRC Calculation". A frame on the wire::

    FF FF FD 00   header, reserved
    ID            0-252, 254 for all
    LEN LEN       bytes that follow, little-endian, counted after stuffing
    INST          instruction; 55 in a status packet
    PARAM ...     stuffed; a status packet's first one is its error field
    CRC CRC       CRC-16 of everything before it, little-endian, computed after stuffing

The other way, from bytes to frames, is in `parser`.
"""

from __future__ import annotations

HEADER = b"\xff\xff\xfd\x00"
STATUS_INSTRUCTION = 0x55
BROADCAST_ID = 0xFE
MAX_ID = 252

PREFIX_SIZE = 7
"""Bytes before INST: header, ID, LEN."""

CRC_SIZE = 2
"""Bytes after the last parameter."""

MIN_LENGTH = 3
"""Smallest LEN: INST and CRC."""

_STUFFED_MARK = b"\xff\xff\xfd"
_STUFFED = b"\xff\xff\xfd\xfd"


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
    frame = HEADER + bytes((servo_id,)) + (len(body) + MIN_LENGTH).to_bytes(2, "little")
    frame += bytes((instruction,)) + body
    return frame + crc16(frame).to_bytes(2, "little")


def build_status(servo_id: int, error: int, params: bytes = b"") -> bytes:
    """Return a status packet: an answer of a servo with its error field."""
    return build_packet(servo_id, STATUS_INSTRUCTION, bytes((error,)) + params)
