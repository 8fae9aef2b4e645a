"""Faults that damage packets on the wire: noise, lost and flipped bits, fields that lie."""

from __future__ import annotations

import re
from random import Random
from typing import ClassVar

from firmware_sim.faults.argument import TO, Argument
from firmware_sim.faults.fault import Line, Piece
from firmware_sim.faults.frames import (
    head_size,
    is_protocol_2,
    with_error,
    with_length,
    without_stuffing,
)
from firmware_sim.faults.spec import FaultKind
from firmware_sim.faults.striking import PacketFault
from firmware_sim.firmware.codes import ALERT

_OVERLOAD_BIT = 0x20
"""Of the error byte of protocol 1.0, which has no alert bit."""


class Damage(PacketFault):
    """Makes other bytes of a packet's bytes; its time stays."""

    def change(self, piece: Piece, _line: Line) -> list[Piece] | None:
        """Return the damaged packet, None where this packet cannot be damaged so."""
        data = self.damaged(piece.data)
        if data == piece.data:
            return None
        return [Piece(data, piece.when, piece.servo_id, piece.deaf)]

    def damaged(self, data: bytes) -> bytes:
        """Return what becomes of the bytes; the same where nothing can."""
        raise NotImplementedError


class Noise(Damage):
    """Random bytes before, within or after a packet."""

    def damaged(self, data: bytes) -> bytes:
        """Return the packet with noise."""
        noise = self.random.randbytes(self.spec.whole("bytes"))
        place = {"before": 0, "inside": self.random.randint(1, max(1, len(data) - 1))}
        at = place.get(self.spec.choice("place"), len(data))
        return data[:at] + noise + data[at:]


class Truncation(Damage):
    """The end of a packet is lost."""

    def damaged(self, data: bytes) -> bytes:
        """Return the packet without its last bytes."""
        wanted = self.spec.optional("bytes")
        cut = self.random.randint(1, max(1, len(data) - 1)) if wanted is None else int(wanted)
        return data[: max(0, len(data) - cut)]


class LostBytes(Damage):
    """Single bytes of a packet are lost, as when a buffer overruns."""

    def damaged(self, data: bytes) -> bytes:
        """Return the packet without some bytes."""
        count = min(self.spec.whole("bytes"), len(data))
        gone = set(self.random.sample(range(len(data)), count))
        return bytes(byte for place, byte in enumerate(data) if place not in gone)


class CrcError(Damage):
    """Flipped bits behind a packet's length field, so that its check surely fails."""

    def damaged(self, data: bytes) -> bytes:
        """Return the packet with bits flipped."""
        first = head_size(data)
        if not first or len(data) <= first:
            return data
        return flip(data, self.spec.whole("bits"), first, self.random)


def flip(data: bytes, count: int, first: int, random: Random) -> bytes:
    """Return bytes with as many different bits flipped, none before byte `first`."""
    places = range(8 * first, 8 * len(data))
    flipped = bytearray(data)
    for place in random.sample(places, min(count, len(places))):
        flipped[place // 8] ^= 1 << place % 8
    return bytes(flipped)


class BitErrors(Damage):
    """Each bit is flipped with a small probability, wherever it is."""

    def damaged(self, data: bytes) -> bytes:
        """Return the packet with bits flipped by chance; often with none."""
        rate = self.spec.number("rate")
        count = sum(self.random.random() < rate for _ in range(8 * len(data)))
        return flip(data, count, 0, self.random) if count else data


class MissingStuffing(Damage):
    """A sender of protocol 2.0 that knows nothing of stuffing."""

    _stuffed: ClassVar[re.Pattern[bytes]] = re.compile(rb"\xff\xff\xfd\xfd")

    def damaged(self, data: bytes) -> bytes:
        """Return the packet without stuffing, its length and CRC right for what is in it."""
        if is_protocol_2(data) and self._stuffed.search(data, head_size(data)):
            return without_stuffing(data)
        return data


class LyingLength(Damage):
    """The length field says something else."""

    def damaged(self, data: bytes) -> bytes:
        """Return the packet with another length; its CRC stays as it was."""
        if len(data) <= head_size(data) or not head_size(data):
            return data
        return with_length(data, self.spec.whole("length"))


class AlertBit(Damage):
    """The error field of a reply says that something is wrong with the hardware."""

    def damaged(self, data: bytes) -> bytes:
        """Return the reply with the bit, and a right check."""
        return with_error(data, ALERT if is_protocol_2(data) else _OVERLOAD_BIT)


def _bytes(meaning: str, default: int | None) -> Argument:
    return Argument("bytes", meaning, default, "bytes", low=1, high=4096, whole=True)


KINDS = (
    FaultKind(
        "noise",
        (1,),
        "random bytes in front of, within or behind a packet",
        Noise,
        (
            _bytes("how many", 4),
            Argument("place", "where", "before", choices=("before", "inside", "after")),
            TO,
        ),
    ),
    FaultKind(
        "truncated-status",
        (2,),
        "the end of a packet is lost",
        Truncation,
        (_bytes("how many; by chance where not given", None), TO),
    ),
    FaultKind(
        "lost-bytes",
        (2,),
        "single bytes of a packet are lost, as when a buffer overruns",
        LostBytes,
        (_bytes("how many", 1), TO),
    ),
    FaultKind(
        "crc-error",
        (3,),
        "bits behind a packet's length field are flipped, so that its CRC or checksum fails",
        CrcError,
        (Argument("bits", "how many", 1, low=1, high=64, whole=True), TO),
    ),
    FaultKind(
        "bit-errors",
        (1, 3, 5),
        "any bit of a packet may be flipped, its header and length too",
        BitErrors,
        (Argument("rate", "probability for each bit", 1.0e-4, high=1.0), TO),
    ),
    FaultKind(
        "missing-stuffing",
        (4,),
        "packets that need stuffing come without it, length and CRC right for what is in them",
        MissingStuffing,
        (TO,),
    ),
    FaultKind(
        "lying-length",
        (5,),
        "the length field of a packet says something else",
        LyingLength,
        (Argument("length", "what it says", 0xFFFF, "bytes", high=0xFFFF, whole=True), TO),
    ),
    FaultKind(
        "alert-bit",
        (20,),
        "replies carry the alert bit (protocol 1.0: the overload bit), with a right CRC",
        AlertBit,
    ),
)
