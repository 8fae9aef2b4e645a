"""Protocol 2.0: what one servo does when an instruction is for it, and what it answers.

Source: e-Manual, "DYNAMIXEL Protocol 2.0", Instruction Details. Where the manual is silent:
parameters that an instruction does not need are ignored; options it does not know are a data range
error.
"""

from __future__ import annotations

from enum import IntEnum

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.servo import Servo
from firmware_sim.wire.answering import Dialect, Handler
from firmware_sim.wire.packet import build_status
from firmware_sim.wire.protocol2_reads import identity, read_reply, status
from firmware_sim.wire.replies import Reply

_RESET_ALL = 0xFF
_RESET_ALL_BUT_ID = 0x01
_RESET_ALL_BUT_ID_AND_BAUD_RATE = 0x02
_RESET_OPTIONS = (_RESET_ALL, _RESET_ALL_BUT_ID, _RESET_ALL_BUT_ID_AND_BAUD_RATE)

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


def _confirmation(servo: Servo, servo_id: int, error: StatusError) -> bytes:
    return build_status(servo_id, error | servo.alert)


_DIALECT = Dialect(2, StatusError.DATA_LENGTH, _confirmation)


def obey(servo: Servo, instruction: int, params: bytes) -> Reply | None:
    """Let a servo do what it was asked by its ID, and return its answer."""
    return HANDLERS.get(instruction, _unknown)(servo, params)


def _unknown(servo: Servo, _params: bytes) -> Reply | None:
    return status(servo, StatusError.INSTRUCTION)


def _ping(servo: Servo, _params: bytes) -> Reply | None:
    return status(servo, StatusError.NONE, identity(servo), level=0)


def _read(servo: Servo, params: bytes) -> Reply | None:
    if len(params) != 4:
        return status(servo, StatusError.DATA_LENGTH, level=1)
    return read_reply(servo, params[0] | params[1] << 8, params[2] | params[3] << 8)


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
    return _DIALECT.confirm(servo, lambda: servo.clear(params))


def _back_up(servo: Servo, params: bytes) -> Reply | None:
    if not servo.model.understands_backup:
        return _unknown(servo, params)
    if len(params) != 5:
        return status(servo, StatusError.DATA_LENGTH)
    if params[0] not in (_BACKUP, _RESTORE) or params[1:] != _BACKUP_WORD:
        return status(servo, StatusError.DATA_RANGE)
    return _DIALECT.confirm(servo, servo.backup if params[0] == _BACKUP else servo.restore)


HANDLERS: dict[int, Handler] = {
    Instruction.PING: _ping,
    Instruction.READ: _read,
    Instruction.WRITE: _DIALECT.write,
    Instruction.REG_WRITE: _DIALECT.reg_write,
    Instruction.ACTION: _DIALECT.action,
    Instruction.FACTORY_RESET: _factory_reset,
    Instruction.REBOOT: _reboot,
    Instruction.CLEAR: _clear,
    Instruction.BACKUP: _back_up,
}
"""What instructions to one servo do."""

SHADOW_HANDLERS: dict[int, Handler] = {
    Instruction.WRITE: _DIALECT.write_as_shadow,
    Instruction.REG_WRITE: _DIALECT.reg_write_as_shadow,
    Instruction.ACTION: _DIALECT.action,
}
"""What instructions to a secondary ID do; whatever they return is not said."""
