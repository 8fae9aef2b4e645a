"""Protocol 1.0 as servos answer it: an instruction comes in, status packets go out.

Source: e-Manual, "DYNAMIXEL Protocol 1.0", Instruction Details; for the ping of all, the manual of
the AX-12 ("Regardless of whether the Broadcasting ID is used ..."). What one servo does is in
`protocol1_single`, what does not depend on the protocol in `answering`. Where they are silent: a
damaged frame that names a servo is answered with the checksum bit.
"""

from __future__ import annotations

from firmware_sim.firmware.codes import ErrorBit
from firmware_sim.firmware.servo import Servo
from firmware_sim.wire.answering import ask, awake, in_turn, refuse
from firmware_sim.wire.packet1 import BROADCAST_ID_1
from firmware_sim.wire.parser import DamagedPacket, Packet
from firmware_sim.wire.protocol1_shares import bulk_reads_1, sync_writes_1
from firmware_sim.wire.protocol1_single import (
    HANDLERS,
    SHADOW_HANDLERS,
    Instruction1,
    obey,
    read_reply_1,
    reboots,
    status,
)
from firmware_sim.wire.replies import Listeners, Reply, Turn

__all__ = ["Instruction1", "execute", "refuse_damaged"]


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
    if packet.servo_id == BROADCAST_ID_1:
        return _broadcast(packet, listeners, awake(listeners, when))
    return ask(packet, listeners, when, obey, SHADOW_HANDLERS)


def refuse_damaged(packet: DamagedPacket, listeners: Listeners) -> list[Turn]:
    """Answer a frame with a wrong checksum that names one servo with the checksum bit."""
    return refuse(packet.servo_id, listeners, lambda servo: status(servo, ErrorBit.CHECKSUM))


def _broadcast(packet: Packet, listeners: Listeners, hearing: list[Servo]) -> list[Turn]:
    """Only ping, by all at once, and bulk read are answered when all are addressed."""
    _servo_id, instruction, params = packet[:3]
    if instruction == Instruction1.PING:
        replies = [
            reply for servo in hearing if (reply := obey(servo, instruction, params)) is not None
        ]
        return [replies] if replies else []
    if instruction == Instruction1.BULK_READ:
        return in_turn(bulk_reads_1(params), listeners, _read_mx)
    if instruction == Instruction1.SYNC_WRITE:
        for servo_id, address, data in sync_writes_1(params):
            listeners.write(servo_id, address, data)
    elif instruction in _SILENT_BROADCASTS:
        reset = instruction == Instruction1.FACTORY_RESET
        for servo in hearing:
            if not (reset and reboots(servo.model)):
                obey(servo, instruction, params)
    return []


def _read_mx(servo: Servo, address: int, size: int) -> Reply | None:
    """Only the MX series knows bulk read (Bulk Read)."""
    return read_reply_1(servo, address, size) if servo.model.name.startswith("mx-") else None


_SILENT_BROADCASTS = frozenset(HANDLERS) - {Instruction1.PING, Instruction1.READ}
