"""DYNAMIXEL Protocol 1.0: instruction packets as bytes, without input or output.

Source: ROBOTIS e-Manual, "Protocol 1.0". A packet is, byte by byte::

    FF FF      header
    ID         0-253, or 254 for all
    LEN        bytes that follow: instruction (or error), parameters, checksum
    INST       in a status packet the error byte: flags, not a number
    params
    CHECKSUM   ones' complement of the sum from ID to the last parameter

Nothing is stuffed, and nothing in a packet tells an instruction from a status: who strips echoes
must know what was sent. Status packets come back through `armsyn.driver.parser1`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

HEADER = b"\xff\xff"
BROADCAST_ID = 254
MAXIMUM_ID = 253

PING = 0x01
READ = 0x02
WRITE = 0x03
SYNC_WRITE = 0x83
BULK_READ = 0x92

HARDWARE_ERRORS = 0x25
"""Flags of an error byte that speak of the servo's state: the bits of Hardware Error Status."""

STATUS_FLAGS = {
    0x01: "input voltage error",
    0x02: "angle limit error",
    0x04: "overheating error",
    0x08: "range error",
    0x10: "checksum error",
    0x20: "overload error",
    0x40: "instruction error",
}
"""Flags of a status packet's error byte (e-Manual, Protocol 1.0, "Error")."""


def checksum(data: bytes | bytearray | memoryview) -> int:
    """Ones' complement of the sum of bytes, 8 bits (e-Manual, "Instruction Checksum")."""
    return ~sum(data) & 0xFF


def packet(identifier: int, instruction: int, parameters: bytes = b"") -> bytes:
    """Build a packet.

    Parameters
    ----------
    identifier : int
        ID, 0-253, or 254 for all.
    instruction : int
    parameters : bytes
        At most 253.

    Returns
    -------
    bytes
        Ready to be sent.

    Raises
    ------
    ValueError
        An ID that no servo can have, or too many parameters.
    """
    if not 0 <= identifier <= BROADCAST_ID:
        raise ValueError(f"ID {identifier} is neither 0-{MAXIMUM_ID} nor {BROADCAST_ID}")
    if len(parameters) > 253:
        raise ValueError(f"{len(parameters)} parameters do not fit a packet of protocol 1.0")
    body = bytes((identifier, len(parameters) + 2, instruction)) + parameters
    return HEADER + body + bytes((checksum(body),))


def ping(identifier: int) -> bytes:
    """Ask whether a servo is there; the answer has no parameters."""
    return packet(identifier, PING)


def read(identifier: int, address: int, size: int) -> bytes:
    """Ask a servo for `size` bytes from `address`."""
    return packet(identifier, READ, bytes((address, size)))


def write(identifier: int, address: int, data: bytes) -> bytes:
    """Write `data` at `address` of one servo."""
    return packet(identifier, WRITE, bytes((address,)) + data)


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
        `data` does not hold `size` bytes a servo, or they do not fit one packet.
    """
    if len(data) != size * len(identifiers):
        raise ValueError(f"{len(data)} bytes are not {size} for each of {len(identifiers)} servos")
    starts = range(0, len(data), size)
    shares = (bytes((i,)) + data[at : at + size] for i, at in zip(identifiers, starts, strict=True))
    return sync_write_shares(address, size, b"".join(shares))


def sync_write_shares(address: int, size: int, shares: bytes) -> bytes:
    """Write at several servos as `sync_write`; `shares` has each one's ID, then its bytes."""
    return packet(BROADCAST_ID, SYNC_WRITE, bytes((address, size)) + shares)


def bulk_read(blocks: Mapping[int, tuple[int, int]]) -> bytes:
    """Ask several MX servos for bytes of their own: ID to (address, size); AX do not know it."""
    shares = (bytes((size, identifier, at)) for identifier, (at, size) in blocks.items())
    return packet(BROADCAST_ID, BULK_READ, b"\0" + b"".join(shares))


def flag_names(error: int) -> str:
    """Words for an error byte, such as ``overheating error, overload error``."""
    named = [name for flag, name in STATUS_FLAGS.items() if error & flag]
    unknown = error & ~sum(STATUS_FLAGS)
    return ", ".join([*named, *([f"unknown flag 0x{unknown:02x}"] if unknown else [])])
