"""Protocol 2.0: what servos answer to reads, alone and together in one packet, and to a ping.

Source: e-Manual, "DYNAMIXEL Protocol 2.0", Ping, Read, Sync Read, Bulk Read, Fast Sync Read, Fast
Bulk Read. Where the manual is silent:

- A servo that cannot read what a fast read asks of it says so in its error field and sends zeros,
  for the packet's LEN has been told already. A fast answer that no LEN can hold is not begun.
- At a broadcast ping each servo waits `PING_SLOT` for each lower ID: the waiting time that the
  vendor's SDK allows for.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import and_

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.servo import Servo
from firmware_sim.wire.packet import FAST_OVERHEAD, MAX_LENGTH, build_fast_status, build_status
from firmware_sim.wire.protocol2_shares import ReadShare
from firmware_sim.wire.replies import Listeners, Reply, Turn

PING_SLOT = 3.0e-3
"""How long a servo waits at a broadcast ping for each ID below its own, s."""

_READ_LEVEL = 1
"""Status return level from which reads are answered."""


def status(
    servo: Servo, error: StatusError, params: bytes = b"", level: int = 2, turn: float = 0.0
) -> Reply | None:
    """Return one status packet, or none where the status return level (68) forbids it."""
    if servo.status_return_level < level:
        return None
    frame = build_status(servo.servo_id, error | servo.alert, params)
    return Reply(frame, servo.return_delay, turn)


def read_reply(servo: Servo, address: int, size: int) -> Reply | None:
    """Return the answer to a read; an error comes without data."""
    if servo.status_return_level < _READ_LEVEL:
        return None
    error, data = servo.read(address, size)
    return Reply(build_status(servo.servo_id, error | servo.alert, data), servo.return_delay)


def identity(servo: Servo) -> bytes:
    """Return what a ping asks for: model number and firmware version."""
    return servo.model.number.to_bytes(2, "little") + bytes((servo.model.firmware,))


def broadcast_ping(listeners: Listeners) -> list[Turn]:
    """Return the answers to a ping of all, in the order of the IDs."""
    turns: list[Turn] = []
    for servo_id in listeners.by_id:
        replies = []
        for servo in listeners.hearing(servo_id):
            turn = servo_id * PING_SLOT
            reply = status(servo, StatusError.NONE, identity(servo), level=0, turn=turn)
            if reply is not None:
                replies.append(reply)
        if replies:
            turns.append(replies)
    return turns


def read_together(shares: Sequence[ReadShare], listeners: Listeners) -> list[Turn]:
    """Return the one packet that servos build for a fast read.

    It ends before the first servo that is silent: missing, of an older firmware, listed before, or
    with a status return level of 0. Only the first servo waits its return delay.
    """
    length = 1 + sum(share.size + FAST_OVERHEAD for share in shares)
    if length > MAX_LENGTH:
        return []
    parts: dict[int, tuple[int, int, bytes]] = {}
    delay = 0.0
    for share in shares:
        servos = [
            servo
            for servo in listeners.by_id.get(share.servo_id, ())
            if servo.hears and _reads_fast(servo)
        ]
        if not servos or share.servo_id in parts:
            break
        if not parts:
            delay = servos[0].return_delay
        parts[share.servo_id] = _part(servos, share)
    return [[Reply(build_fast_status(length, parts.values()), delay)]] if parts else []


def _reads_fast(servo: Servo) -> bool:
    return servo.model.understands_fast_reads and servo.status_return_level >= _READ_LEVEL


def _part(servos: Sequence[Servo], share: ReadShare) -> tuple[int, int, bytes]:
    """Return error field, ID and data of one place; servos of one ID pull the line down together.

    A line is low where anybody pulls it: 1 only where all send 1.
    """
    servo_id, address, size = share
    if len(servos) == 1:
        (servo,) = servos
        error, data = servo.read(address, size)
        return error | servo.alert, servo_id, data or bytes(size)
    errors, everything = 0xFF, b""
    for servo in servos:
        error, data = servo.read(address, size)
        if len(data) != size:
            data = bytes(size)
        errors &= error | servo.alert
        everything = bytes(map(and_, everything, data)) if everything else data
    return errors, servo_id, everything
