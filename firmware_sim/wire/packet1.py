"""Frames of Protocol 1.0: checksum and building.

Source: e-Manual, "DYNAMIXEL Protocol 1.0" (Instruction Packet, Status Packet). A frame on the
wire::

    FF FF       header
    ID          0-253, 254 for all
    LEN         bytes that follow: parameters and 2
    INST        instruction; the error byte in a status packet
    PARAM ...   never stuffed
    CHK         complement of the low byte of the sum of ID to the last parameter

The other way, from bytes to frames, is in `parser1`.
"""

from __future__ import annotations

HEADER_1 = b"\xff\xff"
BROADCAST_ID_1 = 0xFE

PREFIX_SIZE_1 = 4
"""Bytes before INST: header, ID, LEN."""

MIN_LENGTH_1 = 2
"""Smallest LEN: INST and checksum."""

MAX_PARAMS_1 = 253
"""Most parameters that a frame can hold."""


def checksum(body: bytes | bytearray) -> int:
    """Return the checksum of a frame.

    Parameters
    ----------
    body : bytes or bytearray
        From the ID to the last parameter.

    Returns
    -------
    int
        0 to 255 (e-Manual, "Instruction Checksum").
    """
    return ~sum(body) & 0xFF


def build_packet_1(servo_id: int, instruction: int, params: bytes = b"") -> bytes:
    """Return a whole frame with its checksum.

    Parameters
    ----------
    servo_id : int
        0 to 253, or 254 for all.
    instruction : int
        0 to 255; the error byte of a status packet.
    params : bytes
        At most `MAX_PARAMS_1`.

    Returns
    -------
    bytes
        The frame as it goes out.
    """
    body = bytes((servo_id, len(params) + MIN_LENGTH_1, instruction)) + params
    return HEADER_1 + body + bytes((checksum(body),))
