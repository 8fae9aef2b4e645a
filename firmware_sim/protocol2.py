"""Protocol 2.0 as servos answer it: an instruction comes in, status packets go out.

Source: e-Manual, "DYNAMIXEL Protocol 2.0", Instruction Details. What several answer together is in
`protocol2_reads`. Where the manual is silent: parameters that an instruction does not need are
ignored; options it does not know are a data range error.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from functools import partial

from firmware_sim.codes import StatusError
from firmware_sim.packet import BROADCAST_ID, STATUS_INSTRUCTION, build_status
from firmware_sim.parser import DamagedPacket, Packet
from firmware_sim.protocol2_reads import (
    broadcast_ping,
    identity,
    read_in_turn,
    read_reply,
    read_together,
    status,
)
from firmware_sim.protocol2_shares import (
    WriteShare,
    bulk_reads,
    bulk_writes,
    sync_reads,
    sync_writes,
)
from firmware_sim.replies import Listeners, Reply, Turn
from firmware_sim.servo import Servo

_RESET_ALL = 0xFF
_RESET_ALL_BUT_ID = 0x01
_RESET_ALL_BUT_ID_AND_BAUD_RATE = 0x02
_RESET_OPTIONS = (_RESET_ALL, _RESET_ALL_BUT_ID, _RESET_ALL_BUT_ID_AND_BAUD_RATE)

_GUARDED_RESET_FROM = 42
"""Firmware that ignores the reset of all to all (Factory Reset, warning)."""

_CLEAR_FROM = 42
"""Firmware that knows clear (Clear, applied products)."""

_BACKUP, _RESTORE = 0x01, 0x02
_BACKUP_WORD = b"CTRL"


class Instruction(IntEnum):
    """The instructions that are answered; others end in an instruction error."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    CLEAR = 0x10
    BACKUP = 0x20
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A
    BULK_READ = 0x92
    BULK_WRITE = 0x93
    FAST_BULK_READ = 0x9A


def execute(packet: Packet, listeners: Listeners, when: float) -> list[Turn]:
    """Let the servos act on an instruction.

    Parameters
    ----------
    packet : Packet
        What was received; status packets of others are ignored.
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
    if instruction == STATUS_INSTRUCTION:
        return []
    if servo_id == BROADCAST_ID:
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
    """Answer a frame with a wrong CRC that names one servo with a CRC error."""
    answers = [status(servo, StatusError.CRC) for servo in listeners.hearing(packet.servo_id)]
    replies = [reply for reply in answers if reply is not None]
    return [replies] if replies else []


def _broadcast(
    instruction: int, params: bytes, listeners: Listeners, hearing: list[Servo]
) -> list[Turn]:
    """Only ping and the reads of several are answered when all are addressed."""
    if instruction in _READS_OF_SEVERAL:
        return _READS_OF_SEVERAL[instruction](params, listeners)
    if instruction == Instruction.PING:
        return broadcast_ping(listeners)
    if instruction in _WRITES_TO_SEVERAL:
        for servo_id, address, data in _WRITES_TO_SEVERAL[instruction](params):
            listeners.write(servo_id, address, data)
    elif instruction in _SILENT_BROADCASTS:
        reset_all = instruction == Instruction.FACTORY_RESET and params[:1] == b"\xff"
        for servo in hearing:
            if not (reset_all and servo.model.firmware >= _GUARDED_RESET_FROM):
                _HANDLERS[instruction](servo, params)
    return []


def _obey_as_shadow(servo: Servo, instruction: int, params: bytes) -> None:
    """Do what was asked of a secondary ID, without a word."""
    if instruction == Instruction.ACTION:
        servo.act()
    elif instruction == Instruction.WRITE:
        _with_params(partial(servo.write, ram_only=True), params)
    elif instruction == Instruction.REG_WRITE:
        _with_params(partial(servo.register_write, ram_only=True), params)


def _unknown(servo: Servo, _params: bytes) -> Reply | None:
    return status(servo, StatusError.INSTRUCTION)


def _ping(servo: Servo, _params: bytes) -> Reply | None:
    return status(servo, StatusError.NONE, identity(servo), level=0)


def _read(servo: Servo, params: bytes) -> Reply | None:
    if len(params) != 4:
        return status(servo, StatusError.DATA_LENGTH, level=1)
    return read_reply(servo, params[0] | params[1] << 8, params[2] | params[3] << 8)


def _write(servo: Servo, params: bytes) -> Reply | None:
    return _confirm(servo, lambda: _with_params(servo.write, params))


def _reg_write(servo: Servo, params: bytes) -> Reply | None:
    return _confirm(servo, lambda: _with_params(servo.register_write, params))


def _action(servo: Servo, _params: bytes) -> Reply | None:
    return _confirm(servo, servo.act)


def _reboot(servo: Servo, _params: bytes) -> Reply | None:
    reply = status(servo, StatusError.NONE)
    servo.reboot()
    return reply


def _factory_reset(servo: Servo, params: bytes) -> Reply | None:
    if len(params) != 1:
        return status(servo, StatusError.DATA_LENGTH)
    option = params[0]
    if option not in _RESET_OPTIONS:
        return status(servo, StatusError.DATA_RANGE)
    reply = status(servo, StatusError.NONE)
    servo.factory_reset(
        keep_id=option != _RESET_ALL, keep_baud_rate=option == _RESET_ALL_BUT_ID_AND_BAUD_RATE
    )
    return reply


def _clear(servo: Servo, params: bytes) -> Reply | None:
    if servo.model.family != "x" or servo.model.firmware < _CLEAR_FROM:
        return _unknown(servo, params)
    if len(params) != 5:
        return status(servo, StatusError.DATA_LENGTH)
    return _confirm(servo, lambda: servo.clear(params))


def _back_up(servo: Servo, params: bytes) -> Reply | None:
    if not servo.model.understands_backup:
        return _unknown(servo, params)
    if len(params) != 5:
        return status(servo, StatusError.DATA_LENGTH)
    if params[0] not in (_BACKUP, _RESTORE) or params[1:] != _BACKUP_WORD:
        return status(servo, StatusError.DATA_RANGE)
    return _confirm(servo, servo.backup if params[0] == _BACKUP else servo.restore)


def _confirm(servo: Servo, act: Callable[[], StatusError]) -> Reply | None:
    """Act and say how it went, as the servo was set before: a new ID counts from then on."""
    servo_id, delay = servo.servo_id, servo.return_delay
    silent = servo.status_return_level < 2
    error = act()
    return None if silent else Reply(build_status(servo_id, error | servo.alert), delay)


def _with_params(write: Callable[[int, bytes], StatusError], params: bytes) -> StatusError:
    if len(params) < 3:
        return StatusError.DATA_LENGTH
    return write(params[0] | params[1] << 8, params[2:])


_HANDLERS: dict[int, Callable[[Servo, bytes], Reply | None]] = {
    Instruction.PING: _ping,
    Instruction.READ: _read,
    Instruction.WRITE: _write,
    Instruction.REG_WRITE: _reg_write,
    Instruction.ACTION: _action,
    Instruction.FACTORY_RESET: _factory_reset,
    Instruction.REBOOT: _reboot,
    Instruction.CLEAR: _clear,
    Instruction.BACKUP: _back_up,
}

_SILENT_BROADCASTS = frozenset(_HANDLERS) - {Instruction.PING, Instruction.READ}

_READS_OF_SEVERAL: dict[int, Callable[[bytes, Listeners], list[Turn]]] = {
    Instruction.SYNC_READ: lambda params, heard: read_in_turn(sync_reads(params), heard),
    Instruction.BULK_READ: lambda params, heard: read_in_turn(bulk_reads(params), heard),
    Instruction.FAST_SYNC_READ: lambda params, heard: read_together(sync_reads(params), heard),
    Instruction.FAST_BULK_READ: lambda params, heard: read_together(bulk_reads(params), heard),
}

_WRITES_TO_SEVERAL: dict[int, Callable[[bytes], list[WriteShare]]] = {
    Instruction.SYNC_WRITE: sync_writes,
    Instruction.BULK_WRITE: bulk_writes,
}
