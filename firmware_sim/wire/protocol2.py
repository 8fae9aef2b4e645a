"""Protocol 2.0 as servos answer it: an instruction comes in, status packets go out.

Source: e-Manual, "DYNAMIXEL Protocol 2.0", Instruction Details. What one servo does is in
`protocol2_single`, what several answer together in `protocol2_reads`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.servo import Servo
from firmware_sim.wire.answering import ask, awake, in_turn, refuse
from firmware_sim.wire.packet import BROADCAST_ID, PREFIX_SIZE, STATUS_INSTRUCTION
from firmware_sim.wire.parser import DamagedPacket, Packet
from firmware_sim.wire.protocol2_reads import broadcast_ping, read_reply, read_together, status
from firmware_sim.wire.protocol2_shares import (
    ReadShare,
    WriteShare,
    bulk_reads,
    bulk_writes,
    sync_reads,
    sync_writes,
)
from firmware_sim.wire.protocol2_single import HANDLERS, SHADOW_HANDLERS, Instruction, obey
from firmware_sim.wire.replies import Listeners, Turn

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
    if packet.instruction == STATUS_INSTRUCTION:
        return []
    if packet.servo_id == BROADCAST_ID:
        return _broadcast(packet, listeners, awake(listeners, when))
    return ask(packet, listeners, when, obey, SHADOW_HANDLERS)


def refuse_damaged(packet: DamagedPacket, listeners: Listeners) -> list[Turn]:
    """Answer a frame with a wrong CRC that names one servo with a CRC error.

    A status packet is another servo's, whatever has become of it: it is ignored.
    """
    if packet.frame[PREFIX_SIZE] == STATUS_INSTRUCTION:
        return []
    return refuse(packet.servo_id, listeners, lambda servo: status(servo, StatusError.CRC))


def _broadcast(packet: Packet, listeners: Listeners, hearing: list[Servo]) -> list[Turn]:
    """Only ping and the reads of several are answered when all are addressed."""
    _servo_id, instruction, params = packet[:3]
    if instruction in SHARES_OF_READS:
        shares = SHARES_OF_READS[instruction](params)
        if instruction in FAST_READS:
            return read_together(shares, listeners)
        return in_turn(shares, listeners, read_reply)
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
