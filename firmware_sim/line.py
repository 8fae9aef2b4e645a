"""What a serial line makes of bytes that are sent at one baud rate and heard at another."""

from __future__ import annotations

BITS_PER_BYTE = 10
"""Start bit, eight data bits, stop bit."""

BAUD_TOLERANCE = 0.03
"""Relative difference that does no harm (e-Manual, "Baud Rate(8)", note)."""


def same_rate(one: float, other: float) -> bool:
    """Return whether two baud rates understand each other."""
    return abs(one - other) <= BAUD_TOLERANCE * other


def wire_time(byte_count: int, baud_rate: float) -> float:
    """Return how long bytes take on the wire, s, at a rate in bit/s."""
    return byte_count * BITS_PER_BYTE / baud_rate


def garble(data: bytes, sent_at: float, heard_at: float) -> bytes:
    """Return what a receiver with the wrong baud rate makes of bytes on the line.

    Parameters
    ----------
    data : bytes
        What was sent, without pauses.
    sent_at, heard_at : float
        Baud rates of sender and receiver, bit/s.

    Returns
    -------
    bytes
        One byte for each start bit that the receiver believes to see; a missing stop bit is not
        held against it.
    """
    levels: list[int] = []  # one a bit of the sender; the idle line is 1
    for byte in data:
        levels += [0, *(byte >> bit & 1 for bit in range(8)), 1]
    ratio = sent_at / heard_at
    heard = bytearray()
    position = 0.0  # in the sender's bits
    while position < len(levels):
        if levels[int(position)]:
            position = int(position) + 1.0
            continue
        samples = (int(position + (bit + 1.5) * ratio) for bit in range(8))
        bits = [levels[sample] if sample < len(levels) else 1 for sample in samples]
        heard.append(sum(level << bit for bit, level in enumerate(bits)))
        position += (BITS_PER_BYTE - 0.5) * ratio
    return bytes(heard)
