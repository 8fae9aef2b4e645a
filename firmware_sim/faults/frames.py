"""Packets of both protocols as faults look at them: who, how long, and checked anew.

Sources: e-Manual, "DYNAMIXEL Protocol 1.0" and "DYNAMIXEL Protocol 2.0". Apart from the codecs on
purpose: a fault makes packets that no codec would.
"""

from __future__ import annotations

from firmware_sim.wire.packet import CRC_SIZE, HEADER, PREFIX_SIZE, crc16, stuff, unstuff
from firmware_sim.wire.parser import LENGTH_CAP

HEADER_1 = b"\xff\xff"
"""Of protocol 1.0; the ID that follows is never FF."""

HELD_CAP = PREFIX_SIZE + LENGTH_CAP
"""Most bytes of an unfinished packet that are kept, bytes."""


def is_protocol_2(frame: bytes | bytearray) -> bool:
    """Return whether bytes begin with a header of protocol 2.0."""
    return frame.startswith(HEADER)


def owner(frame: bytes) -> int | None:
    """Return the ID in a packet's head, None where there is none."""
    if is_protocol_2(frame):
        return frame[4] if len(frame) > 4 else None
    if frame.startswith(HEADER_1) and len(frame) > 2 and frame[2] != 0xFF:
        return frame[2]
    return None


def head_size(frame: bytes) -> int:
    """Return how many bytes stand before a packet's instruction or error."""
    if owner(frame) is None:
        return 0
    return PREFIX_SIZE if is_protocol_2(frame) else 4


def with_right_check(frame: bytes) -> bytes:
    """Return a packet with the CRC or checksum that fits what is before it."""
    if is_protocol_2(frame):
        return frame[:-CRC_SIZE] + crc16(frame[:-CRC_SIZE]).to_bytes(2, "little")
    return frame[:-1] + bytes((~sum(frame[2:-1]) & 0xFF,))


def with_length(frame: bytes, length: int) -> bytes:
    """Return a packet whose length field says something else; its check stays as it was."""
    if is_protocol_2(frame):
        return frame[:5] + length.to_bytes(2, "little") + frame[7:]
    return frame[:3] + bytes((min(length, 0xFF),)) + frame[4:]


def without_stuffing(frame: bytes) -> bytes:
    """Return a packet of protocol 2.0 as a sender makes it that knows nothing of stuffing."""
    if not is_protocol_2(frame):
        return frame
    body = unstuff(frame[PREFIX_SIZE:-CRC_SIZE])
    return with_right_check(with_length(frame[:PREFIX_SIZE], len(body) + CRC_SIZE) + body + b"\0\0")


def with_parameters(frame: bytes, parameters: bytes) -> bytes:
    """Return a packet of protocol 2.0 with other parameters, stuffed and checked."""
    body = stuff(parameters)
    head = with_length(frame[:PREFIX_SIZE], len(body) + 1 + CRC_SIZE)
    return with_right_check(head + frame[PREFIX_SIZE : PREFIX_SIZE + 1] + body + b"\0\0")


def with_error(frame: bytes, bits: int) -> bytes:
    """Return a status packet with more bits set in its error field, checked anew."""
    if is_protocol_2(frame):
        parameters = unstuff(frame[PREFIX_SIZE + 1 : -CRC_SIZE])
        if not parameters:
            return frame
        return with_parameters(frame, bytes((parameters[0] | bits,)) + parameters[1:])
    if len(frame) < 6:
        return frame
    return with_right_check(frame[:4] + bytes((frame[4] | bits,)) + frame[5:])


def build_request(protocol: int, servo_id: int, instruction: int, parameters: bytes) -> bytes:
    """Return an instruction packet of either protocol."""
    if protocol == 1:
        head = HEADER_1 + bytes((servo_id, len(parameters) + 2, instruction))
        return with_right_check(head + parameters + b"\0")
    head = HEADER + bytes((servo_id, 0, 0, instruction))
    return with_parameters(head, parameters)


class RequestCutter:
    """Cuts the client's bytes into packets; bytes that are none pass in between.

    No byte is lost, and none changes place. The start of a packet waits here for its end.
    """

    def __init__(self) -> None:
        self._held = bytearray()

    @property
    def holds(self) -> bool:
        """Whether anything waits."""
        return bool(self._held)

    def feed(self, chunk: bytes) -> list[bytes]:
        """Take bytes; return the packets they complete, and what is none, in order."""
        self._held += chunk
        pieces: list[bytes] = []
        while self._held:
            size = self._front_size()
            if size == 0:
                break
            pieces.append(bytes(self._held[:size]))
            del self._held[:size]
        return pieces

    def flush(self) -> bytes:
        """Return what waits, and keep nothing."""
        held = bytes(self._held)
        self._held.clear()
        return held

    def _front_size(self) -> int:
        """How many bytes belong together at the front; 0 where that is not known yet."""
        start = self._held.find(HEADER_1)
        if start < 0:
            return len(self._held) - self._held.endswith(b"\xff")
        if start > 0:
            return start
        if len(self._held) < 4:
            return 0
        total = self._packet_size()
        if total is None:
            return 1
        restart = self._held.find(HEADER, 1, total - 1)
        if restart > 0:
            return restart
        return total if total <= len(self._held) else 0

    def _packet_size(self) -> int | None:
        """What the head in front says of the packet's size; None if it cannot be."""
        held = self._held
        if is_protocol_2(held):
            if len(held) < PREFIX_SIZE:
                return HELD_CAP
            length = held[5] | held[6] << 8
            return PREFIX_SIZE + length if 3 <= length <= LENGTH_CAP else None
        return 4 + held[3] if held[2] != 0xFF and held[3] >= 2 else None
