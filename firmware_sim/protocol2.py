"""Protocol 2.0 as servos answer it: an instruction comes in, status packets go out.

Source: e-Manual, "DYNAMIXEL Protocol 2.0", Instruction Details. What one servo does is in
`protocol2_single`, what several answer together in `protocol2_reads`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from firmware_sim.codes import StatusError
from firmware_sim.packet import BROADCAST_ID, PREFIX_SIZE, STATUS_INSTRUCTION
from firmware_sim.parser import DamagedPacket, Packet
from firmware_sim.protocol2_reads import broadcast_ping, read_in_turn, read_together, status
from firmware_sim.protocol2_shares import (
    ReadShare,
    WriteShare,
    bulk_reads,
    bulk_writes,
    sync_reads,
    sync_writes,
)
from firmware_sim.protocol2_single import HANDLERS, Instruction, obey, obey_as_shadow
from firmware_sim.replies import Listeners, Turn
from firmware_sim.servo import Servo

__all__ = ["Instruction", "execute", "refuse_damaged"]

_GUARDED_RESET_FROM = 42
"""Firmware that ignores the reset of all to all (Factory Reset, warning)."""


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
        reply = obey(servo, instruction, params)
        if reply is not None:
            replies.append(reply)
    for servo in listeners.hearing_shadows(servo_id):
        servo.feed(when)
        obey_as_shadow(servo, instruction, params)
    return [replies] if replies else []


def refuse_damaged(packet: DamagedPacket, listeners: Listeners) -> list[Turn]:
    """Answer a frame with a wrong CRC that names one servo with a CRC error.

    A status packet is another servo's, whatever has become of it: it is ignored.
    """
    if packet.frame[PREFIX_SIZE] == STATUS_INSTRUCTION:
        return []
    answers = [status(servo, StatusError.CRC) for servo in listeners.hearing(packet.servo_id)]
    replies = [reply for reply in answers if reply is not None]
    return [replies] if replies else []


def _broadcast(
    instruction: int, params: bytes, listeners: Listeners, hearing: list[Servo]
) -> list[Turn]:
    """Only ping and the reads of several are answered when all are addressed."""
    if instruction in SHARES_OF_READS:
        read = read_together if instruction in FAST_READS else read_in_turn
        return read(SHARES_OF_READS[instruction](params), listeners)
    if instruction == Instruction.PING:
        return broadcast_ping(listeners)
    if instruction in SHARES_OF_WRITES:
        for servo_id, address, data in SHARES_OF_WRITES[instruction](params):
            listeners.write(servo_id, address, data)
    elif instruction in _SILENT_BROADCASTS:
        reset_all = instruction == Instruction.FACTORY_RESET and params[:1] == b"\xff"
        for servo in hearing:
            if not (reset_all and servo.model.firmware >= _GUARDED_RESET_FROM):
                obey(servo, instruction, params)
    return []


_SILENT_BROADCASTS = frozenset(HANDLERS) - {Instruction.PING, Instruction.READ}

SHARES_OF_READS: dict[int, Callable[[bytes], Sequence[ReadShare]]] = {
    Instruction.SYNC_READ: sync_reads,
    Instruction.FAST_SYNC_READ: sync_reads,
    Instruction.BULK_READ: bulk_reads,
    Instruction.FAST_BULK_READ: bulk_reads,
}
"""What reads of several ask of each."""

SHARES_OF_WRITES: dict[int, Callable[[bytes], list[WriteShare]]] = {
    Instruction.SYNC_WRITE: sync_writes,
    Instruction.BULK_WRITE: bulk_writes,
}
"""What writes to several tell each."""

FAST_READS = frozenset((Instruction.FAST_SYNC_READ, Instruction.FAST_BULK_READ))
"""Reads that are answered with one packet."""
