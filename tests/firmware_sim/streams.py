"""Byte streams out of recipes: strings of bytes, which hypothesis makes and shrinks fast."""

from collections.abc import Callable, Iterator
from itertools import pairwise

from firmware_sim.wire.packet import HEADER, build_packet
from firmware_sim.wire.packet1 import build_packet_1

Take = Callable[[], int]
_LIKELY = b"\xff\xff\xff\xfd\xfd\x00\x00\x01\x02\x55\xfe"
_LENGTHS = (0, 1, 2, 3, 20, 255, 4096, 4097, 0xFFFF)


def likely(recipe: bytes) -> bytes:
    """Bytes in which headers and the stuffed pattern are likely."""
    return bytes(value if value > 127 else _LIKELY[value % len(_LIKELY)] for value in recipe)


def values(take: Take, longest: int) -> bytes:
    count = take() % (longest + 1)
    return likely(bytes(take() for _ in range(count)))


def frame_1(take: Take) -> bytes:
    return build_packet_1(take() % 255, take(), values(take, 12))


def frame_2(take: Take) -> bytes:
    servo_id = take() % 254
    return build_packet(254 if servo_id == 253 else servo_id, take(), values(take, 12))


def noise(take: Take) -> bytes:
    return values(take, 9)


def lie(take: Take) -> bytes:
    """A header of protocol 2.0 or 1.0 with a LEN that does not fit what follows."""
    length = _LENGTHS[take() % len(_LENGTHS)]
    if take() % 2:
        return b"\xff\xff\x01" + bytes((length & 0xFF, 0x03))
    return HEADER + b"\x01" + length.to_bytes(2, "little") + b"\x03"


def cook(recipe: bytes, *kinds: Callable[[Take], bytes]) -> list[bytes]:
    """Return the parts of a stream that a recipe says, of the kinds given."""
    rest: Iterator[int] = iter(recipe)
    return [kinds[kind % len(kinds)](lambda: next(rest, 0)) for kind in rest]


def cut(stream: bytes, cuts: bytes) -> list[bytes]:
    """Cut a stream where the numbers, stretched over its length, say."""
    places = sorted({0, len(stream), *(place * len(stream) // 256 for place in cuts)})
    return [stream[start:end] for start, end in pairwise(places)]
