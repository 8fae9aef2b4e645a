"""Protocol 1.0: what one servo does when an instruction is for it, and what it answers.

Source: e-Manual, "DYNAMIXEL Protocol 1.0", Instruction Details and Error. Where it is silent: of
the numbers that servos refuse writes with, the limit of a goal becomes the angle limit bit; the
range, length and access errors the range bit; the rest, and a frame with too few parameters, the
instruction bit.
"""

from __future__ import annotations

from enum import IntEnum

from firmware_sim.firmware.codes import ErrorBit, StatusError
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.servo import Servo
from firmware_sim.wire.answering import Dialect, Handler
from firmware_sim.wire.packet1 import MAX_PARAMS_1, build_packet_1
from firmware_sim.wire.replies import Reply

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


def _confirmation(servo: Servo, servo_id: int, error: StatusError) -> bytes:
    return build_packet_1(servo_id, _BITS[error] | servo.error_bits)


_DIALECT = Dialect(1, StatusError.INSTRUCTION, _confirmation)


def obey(servo: Servo, instruction: int, params: bytes) -> Reply | None:
    """Let a servo do what it was asked by its ID, and return its answer."""
    return HANDLERS.get(instruction, _unknown)(servo, params)


def reboots(model: ServoModel) -> bool:
    """Return whether a model knows reboot, and obeys no factory reset of all."""
    newer_mx = model.name.startswith("mx-") and model.firmware >= _REBOOTS_FROM
    return model.family == "x" or newer_mx


def status(servo: Servo, bits: int, params: bytes = b"", level: int = 2) -> Reply | None:
    """Return one status packet, or none where the status return level forbids it."""
    if servo.status_return_level < level:
        return None
    frame = build_packet_1(servo.servo_id, bits | servo.error_bits, params)
    return Reply(frame, servo.return_delay)


def read_reply_1(servo: Servo, address: int, size: int) -> Reply | None:
    """Return the answer to a read; an error comes without data."""
    if size > MAX_PARAMS_1:
        return status(servo, ErrorBit.RANGE, level=1)
    error, data = servo.read(address, size)
    return status(servo, _BITS[error], data, level=1)


def _unknown(servo: Servo, _params: bytes) -> Reply | None:
    return status(servo, ErrorBit.INSTRUCTION)


def _ping(servo: Servo, _params: bytes) -> Reply | None:
    return status(servo, 0, level=0)


def _read(servo: Servo, params: bytes) -> Reply | None:
    if len(params) != 2:
        return status(servo, ErrorBit.INSTRUCTION, level=1)
    return read_reply_1(servo, *params)


def _factory_reset(servo: Servo, _params: bytes) -> Reply | None:
    reply = status(servo, 0)
    servo.factory_reset(keep_id=False, keep_baud_rate=False)
    return reply


def _reboot(servo: Servo, params: bytes) -> Reply | None:
    if not reboots(servo.model):
        return _unknown(servo, params)
    reply = status(servo, 0)
    servo.reboot()
    return reply


HANDLERS: dict[int, Handler] = {
    Instruction1.PING: _ping,
    Instruction1.READ: _read,
    Instruction1.WRITE: _DIALECT.write,
    Instruction1.REG_WRITE: _DIALECT.reg_write,
    Instruction1.ACTION: _DIALECT.action,
    Instruction1.FACTORY_RESET: _factory_reset,
    Instruction1.REBOOT: _reboot,
}
"""What instructions to one servo do."""

SHADOW_HANDLERS: dict[int, Handler] = {
    Instruction1.WRITE: _DIALECT.write_as_shadow,
    Instruction1.REG_WRITE: _DIALECT.reg_write_as_shadow,
    Instruction1.ACTION: _DIALECT.action,
}
"""What instructions to a secondary ID do; whatever they return is not said."""
