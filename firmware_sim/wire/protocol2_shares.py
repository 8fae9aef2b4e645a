"""Protocol 2.0: whose share is what, in the parameters of instructions to several servos.

Source: e-Manual, "DYNAMIXEL Protocol 2.0", Sync Read, Sync Write, Bulk Read, Bulk Write. Nothing
here raises: a share that is cut off is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

_BULK_HEAD = 5
"""Bytes of ID, address and length in a bulk instruction."""

_READS_KEPT = 64
"""Requests whose shares are remembered: clients repeat their reads byte for byte."""


class ReadShare(NamedTuple):
    """What one servo is to read.

    Parameters
    ----------
    servo_id : int
        Who.
    address, size : int
        The range, bytes.
    """

    servo_id: int
    address: int
    size: int


class WriteShare(NamedTuple):
    """What one servo is to write.

    Parameters
    ----------
    servo_id : int
        Who.
    address : int
        Of the first byte.
    data : bytes
        Never empty.
    """

    servo_id: int
    address: int
    data: bytes


@lru_cache(_READS_KEPT)
def sync_reads(params: bytes) -> Sequence[ReadShare]:
    """Return the shares of a (fast) sync read: address, length, IDs."""
    if len(params) < 4:
        return ()
    address, size = _two_numbers(params, 0)
    return tuple(ReadShare(servo_id, address, size) for servo_id in params[4:])


@lru_cache(_READS_KEPT)
def bulk_reads(params: bytes) -> Sequence[ReadShare]:
    """Return the shares of a (fast) bulk read: ID, address, length of each."""
    starts = range(0, len(params) - _BULK_HEAD + 1, _BULK_HEAD)
    return tuple(ReadShare(params[start], *_two_numbers(params, start + 1)) for start in starts)


def sync_writes(params: bytes) -> list[WriteShare]:
    """Return the shares of a sync write: address, length, then ID and data of each."""
    if len(params) < 4:
        return []
    address, size = _two_numbers(params, 0)
    if not size:
        return []
    starts = range(4, len(params) - size, size + 1)
    return [
        WriteShare(params[start], address, params[start + 1 : start + 1 + size]) for start in starts
    ]


def bulk_writes(params: bytes) -> list[WriteShare]:
    """Return the shares of a bulk write: ID, address, length and data of each.

    "The same ID cannot be used multiple times" (Bulk Write): a second share of an ID is left out.
    """
    shares: dict[int, WriteShare] = {}
    start = 0
    while start + _BULK_HEAD < len(params):
        servo_id = params[start]
        address, size = _two_numbers(params, start + 1)
        data = params[start + _BULK_HEAD : start + _BULK_HEAD + size]
        if size and len(data) == size:
            shares.setdefault(servo_id, WriteShare(servo_id, address, data))
        start += _BULK_HEAD + size
    return list(shares.values())


def _two_numbers(params: bytes, start: int) -> tuple[int, int]:
    """Return two little-endian numbers of two bytes."""
    return (
        params[start] | params[start + 1] << 8,
        params[start + 2] | params[start + 3] << 8,
    )
