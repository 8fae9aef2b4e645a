"""CRC-16 of Protocol 2.0, two bytes at a step.

Source: ROBOTIS e-Manual, "CRC Calculation": polynomial 0x8005, initial value 0, most significant
bit first, nothing inverted. A table for every pair of bytes halves the steps of the usual loop.
"""

from __future__ import annotations

import struct

import numpy as np

_MOST_WORDS = 64


def _byte_table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ 0x8005 if crc & 0x8000 else crc << 1
        table.append(crc & 0xFFFF)
    return tuple(table)


def _word_table() -> list[int]:
    """CRC of each pair of bytes, first byte high."""
    table = np.array(_BYTES, dtype=np.uint32)
    words = np.arange(1 << 16, dtype=np.uint32)
    first = table[words >> 8]
    both: list[int] = ((first << 8 & 0xFFFF) ^ table[first >> 8 ^ words & 0xFF]).tolist()
    return both


_BYTES = _byte_table()
_WORDS = _word_table()
_UNPACK = tuple(struct.Struct(f">{count}H").unpack_from for count in range(_MOST_WORDS))


def crc16(data: bytes | bytearray | memoryview, crc: int = 0) -> int:
    """CRC of a packet's bytes before its CRC field.

    Parameters
    ----------
    data : bytes-like
    crc : int
        Of what stands before them; 0 for a packet's first bytes.

    Returns
    -------
    int
        16 bits.
    """
    size = len(data)
    words = size >> 1
    unpack = _UNPACK[words] if words < _MOST_WORDS else struct.Struct(f">{words}H").unpack_from
    table = _WORDS
    for word in unpack(data):
        crc = table[crc ^ word]
    if size & 1:
        crc = (crc << 8 & 0xFF00) ^ _BYTES[crc >> 8 ^ data[-1]]
    return crc
