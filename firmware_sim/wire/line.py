"""What a serial line makes of bytes: their time, wrong baud rates, and several who talk at once."""

from __future__ import annotations

from collections.abc import Sequence

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
        held against it, but the next start bit comes only after the line has been high: a break
        is one byte, however long.
    """
    return _hear(_levels(data), sent_at / heard_at)


def collide(frames: Sequence[tuple[float, bytes]], baud_rate: float) -> tuple[float, bytes]:
    """Return what is heard of several who talk on one line at once.

    Parameters
    ----------
    frames : sequence of (float, bytes)
        When each begins, s, and what it sends.
    baud_rate : float
        Of all of them, bit/s.

    Returns
    -------
    due : float
        When the last of them falls silent, s.
    data : bytes
        A line is low where anybody pulls it low, so that equal bytes at equal times survive.
    """
    first = min(start for start, _data in frames)
    shifts = [round((start - first) * baud_rate) for start, _data in frames]
    end = max(
        shift + BITS_PER_BYTE * len(data) for shift, (_, data) in zip(shifts, frames, strict=True)
    )
    line = [1] * end
    for shift, (_start, data) in zip(shifts, frames, strict=True):
        for place, level in enumerate(_levels(data), shift):
            line[place] &= level
    return first + end / baud_rate, _hear(line, 1.0)


def _levels(data: bytes) -> list[int]:
    """Return the line's level for each bit of the sender; the idle line is 1."""
    levels: list[int] = []
    for byte in data:
        levels += [0, *(byte >> bit & 1 for bit in range(8)), 1]
    return levels


def _hear(levels: Sequence[int], ratio: float) -> bytes:
    """Return the bytes that a receiver finds, `ratio` bits of the line to one of its own."""
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
        while position < len(levels) and not levels[int(position)]:
            position = int(position) + 1.0
    return bytes(heard)
