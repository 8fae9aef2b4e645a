"""Protocol 2.0 as servos answer it: an instruction comes in, status packets go out.

Source: e-Manual, "DYNAMIXEL Protocol 2.0", Instruction Details.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

from firmware_sim.codes import StatusError
from firmware_sim.packet import BROADCAST_ID, STATUS_INSTRUCTION, build_status
from firmware_sim.parser import DamagedPacket, Packet
from firmware_sim.servo import Servo

_RESET_ALL = 0xFF
_RESET_ALL_BUT_ID = 0x01
_RESET_ALL_BUT_ID_AND_BAUD_RATE = 0x02
_RESET_OPTIONS = (_RESET_ALL, _RESET_ALL_BUT_ID, _RESET_ALL_BUT_ID_AND_BAUD_RATE)


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
        everyone = [servo for servo_id in sorted(listeners) for servo in listeners[servo_id]]
        for servo in everyone:
            servo.notice_instruction(when)
        return _broadcast(packet, listeners, [servo for servo in everyone if servo.hears])
    replies = []
    for servo in listeners.get(packet.servo_id, ()):
        servo.notice_instruction(when)
        if servo.hears:
            handler = _HANDLERS.get(packet.instruction, _unknown)
            replies += handler(servo, packet.params)
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
        if servo.hears:
            replies += _status(servo, StatusError.CRC)
    return replies


def _status(servo: Servo, error: StatusError, params: bytes = b"", level: int = 2) -> list[Reply]:
    """Return one status packet, or none where the status return level (68) forbids it."""
    if servo.status_return_level < level:
        return []
    return [Reply(build_status(servo.servo_id, error | servo.alert, params), servo.return_delay)]


def _unknown(servo: Servo, _params: bytes) -> list[Reply]:
    return _status(servo, StatusError.INSTRUCTION)


def _ping(servo: Servo, _params: bytes) -> list[Reply]:
    identity = servo.model.number.to_bytes(2, "little") + bytes((servo.model.firmware,))
    return _status(servo, StatusError.NONE, identity, level=0)


def _read(servo: Servo, params: bytes) -> list[Reply]:
    if len(params) != 4:
        return _status(servo, StatusError.DATA_LENGTH, level=1)
    address, size = _address_and_size(params)
    error, data = servo.read(address, size)
    return _status(servo, error, data, level=1)


def _write(servo: Servo, params: bytes) -> list[Reply]:
    return _confirm(servo, lambda: _with_params(servo.write, params))


def _reg_write(servo: Servo, params: bytes) -> list[Reply]:
    return _confirm(servo, lambda: _with_params(servo.register_write, params))


def _action(servo: Servo, _params: bytes) -> list[Reply]:
    return _confirm(servo, servo.act)


def _confirm(servo: Servo, act: Callable[[], StatusError]) -> list[Reply]:
    """Act and say how it went, as the servo was set before: a new ID counts from then on."""
    servo_id, delay = servo.servo_id, servo.return_delay
    silent = servo.status_return_level < 2
    error = act()
    return [] if silent else [Reply(build_status(servo_id, error | servo.alert), delay)]


def _reboot(servo: Servo, _params: bytes) -> list[Reply]:
    replies = _status(servo, StatusError.NONE)
    servo.reboot()
    return replies


def _factory_reset(servo: Servo, params: bytes) -> list[Reply]:
    if len(params) != 1:
        return _status(servo, StatusError.DATA_LENGTH)
    option = params[0]
    if option not in _RESET_OPTIONS:
        return _status(servo, StatusError.DATA_RANGE)
    replies = _status(servo, StatusError.NONE)
    servo.factory_reset(
        keep_id=option != _RESET_ALL, keep_baud_rate=option == _RESET_ALL_BUT_ID_AND_BAUD_RATE
    )
    return replies


_HANDLERS: dict[int, Callable[[Servo, bytes], list[Reply]]] = {
    Instruction.PING: _ping,
    Instruction.READ: _read,
    Instruction.WRITE: _write,
    Instruction.REG_WRITE: _reg_write,
    Instruction.ACTION: _action,
    Instruction.FACTORY_RESET: _factory_reset,
    Instruction.REBOOT: _reboot,
}

_SILENT_BROADCASTS = frozenset(
    (
        Instruction.WRITE,
        Instruction.REG_WRITE,
        Instruction.ACTION,
        Instruction.FACTORY_RESET,
        Instruction.REBOOT,
    )
)


def _broadcast(packet: Packet, listeners: Listeners, hearing: list[Servo]) -> list[Reply]:
    """Only ping and sync read are answered when all are addressed."""
    instruction, params = packet.instruction, packet.params
    if instruction == Instruction.PING:
        return [reply for servo in hearing for reply in _ping(servo, params)]
    if instruction == Instruction.SYNC_READ:
        return _sync_read(params, listeners)
    if instruction == Instruction.SYNC_WRITE:
        _sync_write(params, listeners)
    elif instruction == Instruction.FACTORY_RESET and params[:1] == bytes((_RESET_ALL,)):
        pass  # ignored since firmware 42
    elif instruction in _SILENT_BROADCASTS:
        for servo in hearing:
            _HANDLERS[instruction](servo, params)
    return []


def _sync_read(params: bytes, listeners: Listeners) -> list[Reply]:
    """Return the replies in the requested order.

    Each servo waits for the one before it in the list, so whoever follows a silent one stays silent
    too (ROBOTIS in DynamixelSDK issue 364).
    """
    replies: list[Reply] = []
    for servo_id in params[4:]:
        answers = [
            reply
            for servo in listeners.get(servo_id, ())
            if servo.hears
            for reply in _read(servo, params[:4])
        ]
        if not answers:
            break
        replies += answers
    return replies


def _sync_write(params: bytes, listeners: Listeners) -> None:
    """Write each servo's share; a last share that is too short is left out."""
    address, size = _address_and_size(params)
    for start in range(4, len(params) - size, size + 1):
        for servo in listeners.get(params[start], ()):
            if servo.hears:
                servo.write(address, params[start + 1 : start + 1 + size])


def _with_params(write: Callable[[int, bytes], StatusError], params: bytes) -> StatusError:
    if len(params) < 3:
        return StatusError.DATA_LENGTH
    return write(params[0] | params[1] << 8, params[2:])


def _address_and_size(params: bytes) -> tuple[int, int]:
    """First two little-endian numbers of a read or a sync instruction."""
    return int.from_bytes(params[0:2], "little"), int.from_bytes(params[2:4], "little")
