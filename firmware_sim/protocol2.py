"""Protocol 2.0 as servos answer it: an instruction comes in, status packets go out.

Source: e-Manual, "DYNAMIXEL Protocol 2.0", Instruction Details.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

from firmware_sim.codes import StatusError
from firmware_sim.packet import (
    BROADCAST_ID,
    STATUS_INSTRUCTION,
    DamagedPacket,
    Packet,
    build_status,
)
from firmware_sim.servo import Servo

_FACTORY_RESET_ALL = 0xFF
_FACTORY_RESET_OPTIONS = (_FACTORY_RESET_ALL, 0x01, 0x02)


class Instruction(IntEnum):
    """The instructions that are answered; others end in an instruction error."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83


@dataclass(frozen=True, slots=True)
class Reply:
    """One status packet and how long its sender waits before it.

    Parameters
    ----------
    data : bytes
        The frame.
    delay : float
        Return delay, s.
    """

    data: bytes
    delay: float


Listeners = Mapping[int, Sequence[Servo]]
"""Who hears the bus, by ID; a wrongly set up bus has several servos of one ID."""


def execute(packet: Packet, listeners: Listeners, when: float) -> list[Reply]:
    """Let the servos act on an instruction.

    Parameters
    ----------
    packet : Packet
        What was received; status packets of others are ignored.
    listeners : mapping of int to sequence of Servo
        Who receives it.
    when : float
        The end of its last byte on the wire, s.

    Returns
    -------
    list of Reply
        In the order in which they follow each other on the wire.
    """
    if packet.instruction == STATUS_INSTRUCTION:
        return []
    if packet.servo_id == BROADCAST_ID:
        for servos in listeners.values():
            for servo in servos:
                servo.notice_instruction(when)
        return _broadcast(packet, listeners, when)
    replies = []
    for servo in listeners.get(packet.servo_id, ()):
        servo.notice_instruction(when)
        if servo.hears(when):
            replies += _unicast(packet, servo, when)
    return replies


def refuse_damaged(packet: DamagedPacket, listeners: Listeners, when: float) -> list[Reply]:
    """Answer a frame with a wrong CRC that names one servo with a CRC error.

    Parameters
    ----------
    packet : DamagedPacket
        What was received.
    listeners : mapping of int to sequence of Servo
        Who receives it.
    when : float
        The end of its last byte on the wire, s.

    Returns
    -------
    list of Reply
        At most one a servo.
    """
    replies = []
    for servo in listeners.get(packet.servo_id, ()):
        servo.advance(when)
        if servo.hears(when):
            replies += _status(servo, StatusError.CRC)
    return replies


def _status(servo: Servo, error: StatusError, params: bytes = b"", level: int = 2) -> list[Reply]:
    """Return one status packet, or none where the status return level (68) forbids it."""
    if servo.status_return_level < level:
        return []
    return [Reply(build_status(servo.servo_id, error | servo.alert, params), servo.return_delay)]


def _unicast(packet: Packet, servo: Servo, when: float) -> list[Reply]:
    handler = _HANDLERS.get(packet.instruction)
    if handler is None:
        return _status(servo, StatusError.INSTRUCTION)
    return handler(servo, packet.params, when)


def _ping(servo: Servo, _params: bytes, _when: float) -> list[Reply]:
    identity = servo.model.number.to_bytes(2, "little") + bytes((servo.model.firmware,))
    return _status(servo, StatusError.NONE, identity, level=0)


def _read(servo: Servo, params: bytes, when: float) -> list[Reply]:
    if len(params) != 4:
        return _status(servo, StatusError.DATA_LENGTH, level=1)
    address, size = _address_and_size(params)
    error, data = servo.read(address, size, when)
    return _status(servo, error, data, level=1)


def _write(servo: Servo, params: bytes, _when: float) -> list[Reply]:
    sender = servo.servo_id
    delay, level = servo.return_delay, servo.status_return_level
    error = _write_params(servo.write, params)
    if level < 2:
        return []
    # An ID, return delay or status return level just written counts from the next packet on.
    return [Reply(build_status(sender, error | servo.alert), delay)]


def _reg_write(servo: Servo, params: bytes, _when: float) -> list[Reply]:
    return _status(servo, _write_params(servo.register_write, params))


def _action(servo: Servo, _params: bytes, _when: float) -> list[Reply]:
    sender = servo.servo_id
    delay, level = servo.return_delay, servo.status_return_level
    error = servo.act()
    return [Reply(build_status(sender, error | servo.alert), delay)] if level >= 2 else []


def _reboot(servo: Servo, _params: bytes, when: float) -> list[Reply]:
    replies = _status(servo, StatusError.NONE)
    servo.reboot(when)
    return replies


def _factory_reset(servo: Servo, params: bytes, when: float) -> list[Reply]:
    if len(params) != 1:
        return _status(servo, StatusError.DATA_LENGTH)
    if params[0] not in _FACTORY_RESET_OPTIONS:
        return _status(servo, StatusError.DATA_RANGE)
    replies = _status(servo, StatusError.NONE)
    servo.factory_reset(when, keep_id=params[0] != 0xFF, keep_baud_rate=params[0] == 0x02)
    return replies


_HANDLERS: dict[int, Callable[[Servo, bytes, float], list[Reply]]] = {
    Instruction.PING: _ping,
    Instruction.READ: _read,
    Instruction.WRITE: _write,
    Instruction.REG_WRITE: _reg_write,
    Instruction.ACTION: _action,
    Instruction.FACTORY_RESET: _factory_reset,
    Instruction.REBOOT: _reboot,
}


def _broadcast(packet: Packet, listeners: Listeners, when: float) -> list[Reply]:
    """Only ping and sync read are answered when all are addressed."""
    params = packet.params
    if packet.instruction == Instruction.SYNC_READ:
        return _sync_read(params, listeners, when)
    if packet.instruction == Instruction.SYNC_WRITE:
        _sync_write(params, listeners, when)
        return []
    handler = _HANDLERS.get(packet.instruction)
    everyone = [servo for servo_id in sorted(listeners) for servo in listeners[servo_id]]
    hearing = [servo for servo in everyone if servo.hears(when)]
    if handler is _ping:
        return [reply for servo in hearing for reply in _ping(servo, params, when)]
    if handler is _factory_reset and params[:1] == bytes((_FACTORY_RESET_ALL,)):
        return []  # ignored since firmware 42
    if handler is not None and handler is not _read:
        for servo in hearing:
            handler(servo, params, when)
    return []


def _sync_read(params: bytes, listeners: Listeners, when: float) -> list[Reply]:
    """Return the replies in the requested order.

    Each servo waits for the one before it in the list, so whoever follows a silent one stays silent
    too (ROBOTIS in DynamixelSDK issue 364).
    """
    replies: list[Reply] = []
    for servo_id in params[4:]:
        answers = [
            reply
            for servo in listeners.get(servo_id, ())
            if servo.hears(when)
            for reply in _read(servo, params[:4], when)
        ]
        if not answers:
            break
        replies += answers
    return replies


def _sync_write(params: bytes, listeners: Listeners, when: float) -> None:
    """Write each servo's share; a last share that is too short is left out."""
    address, size = _address_and_size(params)
    for start in range(4, len(params) - size, size + 1):
        for servo in listeners.get(params[start], ()):
            if servo.hears(when):
                servo.write(address, params[start + 1 : start + 1 + size])


def _write_params(write: Callable[[int, bytes], StatusError], params: bytes) -> StatusError:
    if len(params) < 3:
        return StatusError.DATA_LENGTH
    return write(params[0] | params[1] << 8, params[2:])


def _address_and_size(params: bytes) -> tuple[int, int]:
    """First two little-endian numbers of a read or a sync instruction."""
    return int.from_bytes(params[0:2], "little"), int.from_bytes(params[2:4], "little")
