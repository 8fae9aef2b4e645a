"""Protocol 1.0 as servos answer it: an instruction comes in, status packets go out.

Source: e-Manual, "DYNAMIXEL Protocol 1.0", Instruction Details and Error; for the ping of all, the
manual of the AX-12 ("Regardless of whether the Broadcasting ID is used ..."). Where they are
silent:

- A damaged frame that names a servo is answered with the checksum bit.
- Of the numbers that servos refuse writes with, the limit of a goal becomes the angle limit bit;
  the range, length and access errors the range bit; the rest, and a frame with too few
  parameters, the instruction bit.
- Whoever follows a silent servo in a bulk read stays silent too, as in protocol 2.0.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from functools import partial

from firmware_sim.codes import StatusError
from firmware_sim.model import ServoModel
from firmware_sim.packet1 import BROADCAST_ID_1, MAX_PARAMS_1, build_packet_1
from firmware_sim.parser import DamagedPacket, Packet
from firmware_sim.replies import Listeners, Reply, Turn
from firmware_sim.servo import Servo

_REBOOTS_FROM = 40
"""Firmware of the MX series that knows reboot, and obeys no reset of all (Factory Reset, Reboot).
MX-12W, which is not simulated, has 41."""


class Instruction1(IntEnum):
    """The instructions that are answered; others end in an instruction error."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    SYNC_WRITE = 0x83
    BULK_READ = 0x92


class ErrorBit(IntEnum):
    """Bits of the error byte that speak of the instruction; `Servo.error_bits` has the others."""

    ANGLE_LIMIT = 0x02
    RANGE = 0x08
    CHECKSUM = 0x10
    INSTRUCTION = 0x40


_BITS = {
    StatusError.NONE: 0,
    StatusError.RESULT_FAIL: ErrorBit.INSTRUCTION,
    StatusError.INSTRUCTION: ErrorBit.INSTRUCTION,
    StatusError.CRC: ErrorBit.CHECKSUM,
    StatusError.DATA_RANGE: ErrorBit.RANGE,
    StatusError.DATA_LENGTH: ErrorBit.RANGE,
    StatusError.DATA_LIMIT: ErrorBit.ANGLE_LIMIT,
    StatusError.ACCESS: ErrorBit.RANGE,
}


def execute(packet: Packet, listeners: Listeners, when: float) -> list[Turn]:
    """Let the servos act on an instruction.

    Parameters
    ----------
    packet : Packet
        What was received.
    listeners : Listeners
        Who receives it, brought to `when`.
    when : float
        The end of its last byte on the wire, s.

    Returns
    -------
    list of Turn
        In the order in which they follow each other on the wire.
    """
    servo_id, instruction, params = packet[:3]
    if servo_id == BROADCAST_ID_1:
        hearing = [servo for servo in listeners.everyone if servo.hears]
        for servo in hearing:
            servo.feed(when)
        return _broadcast(instruction, params, listeners, hearing)
    replies = []
    for servo in listeners.hearing(servo_id):
        servo.feed(when)
        reply = _HANDLERS.get(instruction, _unknown)(servo, params)
        if reply is not None:
            replies.append(reply)
    for servo in listeners.hearing_shadows(servo_id):
        servo.feed(when)
        _obey_as_shadow(servo, instruction, params)
    return [replies] if replies else []


def refuse_damaged(packet: DamagedPacket, listeners: Listeners) -> list[Turn]:
    """Answer a frame with a wrong checksum that names one servo with the checksum bit."""
    answers = [_status(servo, ErrorBit.CHECKSUM) for servo in listeners.hearing(packet.servo_id)]
    replies = [reply for reply in answers if reply is not None]
    return [replies] if replies else []


def _broadcast(
    instruction: int, params: bytes, listeners: Listeners, hearing: list[Servo]
) -> list[Turn]:
    """Only ping, by all at once, and bulk read are answered when all are addressed."""
    if instruction == Instruction1.PING:
        replies = [reply for servo in hearing if (reply := _ping(servo, params)) is not None]
        return [replies] if replies else []
    if instruction == Instruction1.BULK_READ:
        return _bulk_read(params, listeners)
    if instruction == Instruction1.SYNC_WRITE:
        _sync_write(params, listeners)
    elif instruction in _SILENT_BROADCASTS:
        reset = instruction == Instruction1.FACTORY_RESET
        for servo in hearing:
            if not (reset and _reboots(servo.model)):
                _HANDLERS[instruction](servo, params)
    return []


def _bulk_read(params: bytes, listeners: Listeners) -> list[Turn]:
    """Return the answers of MX servos in the order asked for; of an ID, only the first share's."""
    turns: list[Turn] = []
    answered: set[int] = set()
    for start in range(1, len(params) - 2, 3):
        size, servo_id, address = params[start : start + 3]
        servos = [] if servo_id in answered else listeners.hearing(servo_id)
        replies = [
            reply
            for servo in servos
            if servo.model.name.startswith("mx-")
            and (reply := _read(servo, bytes((address, size)))) is not None
        ]
        if not replies:
            break
        answered.add(servo_id)
        turns.append(replies)
    return turns


def _sync_write(params: bytes, listeners: Listeners) -> None:
    """Write each servo's share; a last share that is too short is left out."""
    if len(params) < 2 or not params[1]:
        return
    address, size = params[0], params[1]
    for start in range(2, len(params) - size, size + 1):
        listeners.write(params[start], address, params[start + 1 : start + 1 + size])


def _obey_as_shadow(servo: Servo, instruction: int, params: bytes) -> None:
    """Do what was asked of a secondary ID, without a word."""
    if instruction == Instruction1.ACTION:
        servo.act()
    elif instruction == Instruction1.WRITE:
        _with_params(partial(servo.write, ram_only=True), params)
    elif instruction == Instruction1.REG_WRITE:
        _with_params(partial(servo.register_write, ram_only=True), params)


def _reboots(model: ServoModel) -> bool:
    newer_mx = model.name.startswith("mx-") and model.firmware >= _REBOOTS_FROM
    return model.family == "x" or newer_mx


def _status(servo: Servo, bits: int, params: bytes = b"", level: int = 2) -> Reply | None:
    """Return one status packet, or none where the status return level forbids it."""
    if servo.status_return_level < level:
        return None
    frame = build_packet_1(servo.servo_id, bits | servo.error_bits, params)
    return Reply(frame, servo.return_delay)


def _unknown(servo: Servo, _params: bytes) -> Reply | None:
    return _status(servo, ErrorBit.INSTRUCTION)


def _ping(servo: Servo, _params: bytes) -> Reply | None:
    return _status(servo, 0, level=0)


def _read(servo: Servo, params: bytes) -> Reply | None:
    if len(params) != 2:
        return _status(servo, ErrorBit.INSTRUCTION, level=1)
    address, size = params
    if size > MAX_PARAMS_1:
        return _status(servo, ErrorBit.RANGE, level=1)
    error, data = servo.read(address, size)
    return _status(servo, _BITS[error], data, level=1)


def _write(servo: Servo, params: bytes) -> Reply | None:
    return _confirm(servo, lambda: _with_params(servo.write, params))


def _reg_write(servo: Servo, params: bytes) -> Reply | None:
    return _confirm(servo, lambda: _with_params(servo.register_write, params))


def _action(servo: Servo, _params: bytes) -> Reply | None:
    return _confirm(servo, servo.act)


def _factory_reset(servo: Servo, _params: bytes) -> Reply | None:
    reply = _status(servo, 0)
    servo.factory_reset(keep_id=False, keep_baud_rate=False)
    return reply


def _reboot(servo: Servo, params: bytes) -> Reply | None:
    if not _reboots(servo.model):
        return _unknown(servo, params)
    reply = _status(servo, 0)
    servo.reboot()
    return reply


def _confirm(servo: Servo, act: Callable[[], StatusError]) -> Reply | None:
    """Act and say how it went, as the servo was set before: a new ID counts from then on."""
    servo_id, delay = servo.servo_id, servo.return_delay
    silent = servo.status_return_level < 2
    bits = _BITS[act()] | servo.error_bits
    return None if silent else Reply(build_packet_1(servo_id, bits), delay)


def _with_params(write: Callable[[int, bytes], StatusError], params: bytes) -> StatusError:
    return write(params[0], params[1:]) if len(params) > 1 else StatusError.INSTRUCTION


_HANDLERS: dict[int, Callable[[Servo, bytes], Reply | None]] = {
    Instruction1.PING: _ping,
    Instruction1.READ: _read,
    Instruction1.WRITE: _write,
    Instruction1.REG_WRITE: _reg_write,
    Instruction1.ACTION: _action,
    Instruction1.FACTORY_RESET: _factory_reset,
    Instruction1.REBOOT: _reboot,
}

_SILENT_BROADCASTS = frozenset(_HANDLERS) - {Instruction1.PING, Instruction1.READ}
