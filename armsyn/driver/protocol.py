"""DYNAMIXEL Protocol 2.0: instruction packets as bytes, without input or output.

Source: ROBOTIS e-Manual, "Protocol 2.0". A packet is, byte by byte::

    FF FF FD 00   header
    ID            0-252, or 254 for all
    LEN_L LEN_H   bytes that follow: instruction, stuffed parameters, CRC
    INST
    params        with FD put in after every FF FF FD
    CRC_L CRC_H   CRC-16, polynomial 0x8005, over everything before it

Status packets come back through `armsyn.driver.parser`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fastcrc.crc16 import umts as crc16

HEADER = b"\xff\xff\xfd\x00"
BROADCAST_ID = 254
MAXIMUM_ID = 252

PING = 0x01
READ = 0x02
WRITE = 0x03
REBOOT = 0x08
STATUS = 0x55
SYNC_READ = 0x82
SYNC_WRITE = 0x83
FAST_SYNC_READ = 0x8A
BULK_READ = 0x92

ALERT = 0x80
"""Bit 7 of a status packet's error byte: look at Hardware Error Status."""

STATUS_ERRORS = {
    1: "result fail",
    2: "instruction error",
    3: "CRC error",
    4: "data range error",
    5: "data length error",
    6: "data limit error",
    7: "access error",
}
"""Bits 0-6 of a status packet's error byte: a number, not flags."""

_PATTERN = b"\xff\xff\xfd"
_STUFFED = b"\xff\xff\xfd\xfd"


def stuff(body: bytes) -> bytes:
    """Put FD in after every FF FF FD, so that no header appears inside a packet."""
    return body.replace(_PATTERN, _STUFFED)


def unstuff(body: bytes) -> bytes:
    """Undo `stuff`."""
    return body.replace(_STUFFED, _PATTERN)


def packet(identifier: int, instruction: int, parameters: bytes = b"") -> bytes:
    """Build a packet.

    Parameters
    ----------
    identifier : int
        ID, 0-252, or 254 for all.
    instruction : int
    parameters : bytes
        Not yet stuffed.

    Returns
    -------
    bytes
        Ready to be sent.

    Raises
    ------
    ValueError
        An ID that no servo can have.
    """
    if not (0 <= identifier <= MAXIMUM_ID or identifier == BROADCAST_ID):
        raise ValueError(f"ID {identifier} is neither 0-{MAXIMUM_ID} nor {BROADCAST_ID}")
    body = stuff(bytes((instruction,)) + parameters)
    length = len(body) + 2
    start = HEADER + bytes((identifier, length & 0xFF, length >> 8)) + body
    return start + crc16(start).to_bytes(2, "little")


def ping(identifier: int) -> bytes:
    """Ask a servo for its model number and firmware version."""
    return packet(identifier, PING)


def read(identifier: int, address: int, size: int) -> bytes:
    """Ask a servo for `size` bytes from `address`."""
    return packet(identifier, READ, _words(address, size))


def write(identifier: int, address: int, data: bytes) -> bytes:
    """Write `data` at `address` of one servo."""
    return packet(identifier, WRITE, _words(address) + data)


def reboot(identifier: int) -> bytes:
    """Let a servo start anew; it answers first, if its Status Return Level lets it."""
    return packet(identifier, REBOOT)


def sync_read(address: int, size: int, identifiers: Sequence[int]) -> bytes:
    """Ask several servos for the same `size` bytes; they answer in this order."""
    return packet(BROADCAST_ID, SYNC_READ, _words(address, size) + bytes(identifiers))


def fast_sync_read(address: int, size: int, identifiers: Sequence[int]) -> bytes:
    """Ask several servos for the same `size` bytes; they answer with one packet together."""
    return packet(BROADCAST_ID, FAST_SYNC_READ, _words(address, size) + bytes(identifiers))


def bulk_read(blocks: Mapping[int, tuple[int, int]]) -> bytes:
    """Ask several servos for bytes of their own: ID to (address, size); they answer in order."""
    shares = (bytes((identifier,)) + _words(*block) for identifier, block in blocks.items())
    return packet(BROADCAST_ID, BULK_READ, b"".join(shares))


def sync_write(address: int, size: int, identifiers: Sequence[int], data: bytes) -> bytes:
    """Write `size` bytes each at `address` of several servos; none of them answers.

    Parameters
    ----------
    address, size : int
    identifiers : sequence of int
    data : bytes
        `size` bytes for the first servo, then for the next, and so on.

    Returns
    -------
    bytes

    Raises
    ------
    ValueError
        `data` does not hold `size` bytes a servo.
    """
    if len(data) != size * len(identifiers):
        raise ValueError(f"{len(data)} bytes are not {size} for each of {len(identifiers)} servos")
    starts = range(0, len(data), size)
    shares = (bytes((i,)) + data[at : at + size] for i, at in zip(identifiers, starts, strict=True))
    return sync_write_shares(address, size, b"".join(shares))


def sync_write_shares(address: int, size: int, shares: bytes) -> bytes:
    """Write at several servos as `sync_write`; `shares` has each one's ID, then its bytes."""
    return packet(BROADCAST_ID, SYNC_WRITE, _words(address, size) + shares)


def _words(*values: int) -> bytes:
    return b"".join(value.to_bytes(2, "little") for value in values)
