"""Protocol 1.0 as servos answer it: an instruction comes in, status packets go out.

Source: e-Manual, "DYNAMIXEL Protocol 1.0", Instruction Details; for the ping of all, the manual of
the AX-12 ("Regardless of whether the Broadcasting ID is used ..."). What one servo does is in
`protocol1_single`. Where they are silent: a damaged frame that names a servo is answered with the
checksum bit; whoever follows a silent servo in a bulk read stays silent too, as in protocol 2.0.
"""

from __future__ import annotations

from firmware_sim.codes import ErrorBit
from firmware_sim.packet1 import BROADCAST_ID_1
from firmware_sim.parser import DamagedPacket, Packet
from firmware_sim.protocol1_shares import bulk_reads_1, sync_writes_1
from firmware_sim.protocol1_single import (
    HANDLERS,
    Instruction1,
    obey,
    obey_as_shadow,
    reboots,
    status,
)
from firmware_sim.replies import Listeners, Turn
from firmware_sim.servo import Servo

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
    servo_id, instruction, params = packet[:3]
    if servo_id == BROADCAST_ID_1:
        hearing = [servo for servo in listeners.everyone if servo.hears]
        for servo in hearing:
            servo.feed(when)
        return _broadcast(instruction, params, listeners, hearing)
    replies = []
    for servo in listeners.hearing(servo_id):
        servo.feed(when)
        reply = obey(servo, instruction, params)
        if reply is not None:
            replies.append(reply)
    for servo in listeners.hearing_shadows(servo_id):
        servo.feed(when)
        obey_as_shadow(servo, instruction, params)
    return [replies] if replies else []


def refuse_damaged(packet: DamagedPacket, listeners: Listeners) -> list[Turn]:
    """Answer a frame with a wrong checksum that names one servo with the checksum bit."""
    answers = [status(servo, ErrorBit.CHECKSUM) for servo in listeners.hearing(packet.servo_id)]
    replies = [reply for reply in answers if reply is not None]
    return [replies] if replies else []


def _broadcast(
    instruction: int, params: bytes, listeners: Listeners, hearing: list[Servo]
) -> list[Turn]:
    """Only ping, by all at once, and bulk read are answered when all are addressed."""
    if instruction == Instruction1.PING:
        replies = [
            reply for servo in hearing if (reply := obey(servo, instruction, params)) is not None
        ]
        return [replies] if replies else []
    if instruction == Instruction1.BULK_READ:
        return _bulk_read(params, listeners)
    if instruction == Instruction1.SYNC_WRITE:
        for servo_id, address, data in sync_writes_1(params):
            listeners.write(servo_id, address, data)
    elif instruction in _SILENT_BROADCASTS:
        reset = instruction == Instruction1.FACTORY_RESET
        for servo in hearing:
            if not (reset and reboots(servo.model)):
                obey(servo, instruction, params)
    return []


def _bulk_read(params: bytes, listeners: Listeners) -> list[Turn]:
    """Return the answers of MX servos in the order asked for; of an ID, only the first share's."""
    turns: list[Turn] = []
    answered: set[int] = set()
    for servo_id, address, size in bulk_reads_1(params):
        servos = [] if servo_id in answered else listeners.hearing(servo_id)
        replies = [
            reply
            for servo in servos
            if servo.model.name.startswith("mx-")
            and (reply := obey(servo, Instruction1.READ, bytes((address, size)))) is not None
        ]
        if not replies:
            break
        answered.add(servo_id)
        turns.append(replies)
    return turns


_SILENT_BROADCASTS = frozenset(HANDLERS) - {Instruction1.PING, Instruction1.READ}
