"""CRC-16 of Protocol 2.0.

Source: ROBOTIS e-Manual, "CRC Calculation": polynomial 0x8005, initial value 0, most significant
bit first, nothing inverted.
"""

from __future__ import annotations


def _table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ 0x8005 if crc & 0x8000 else crc << 1
        table.append(crc & 0xFFFF)
    return tuple(table)


# a table for pairs of bytes is no faster: between cycles it falls out of the caches
_TABLE = _table()


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
    table = _TABLE
    for byte in data:
        crc = ((crc << 8) & 0xFF00) ^ table[(crc >> 8) ^ byte]
    return crc
