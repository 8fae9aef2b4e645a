"""Servos on one half-duplex wire, with the time that bytes take on it.

A bus does no input or output and has no clock: it is told what arrived when, and says which bytes
are to leave when. Bytes take ten bits each at the client's baud rate; a request takes effect at
the end of its last byte; each answer ends no earlier than its servo's return delay plus its own
wire time after whatever was on the wire before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from firmware_sim.line import garble, same_rate, wire_time
from firmware_sim.parser import DamagedPacket, Packet, PacketParser
from firmware_sim.protocol2 import execute, refuse_damaged
from firmware_sim.servo import Servo

GAP_TIME = 1.5e-3
"""Silence within an instruction after which a servo gives it up, s, where `gap_rule` is on."""


@dataclass(frozen=True, slots=True)
class Transmission:
    """Bytes of the servos on their way to the client.

    Parameters
    ----------
    due : float
        When the last of them has left the wire, s.
    data : bytes
        Them.
    """

    due: float
    data: bytes


class Bus:
    """Servos on one wire.

    Parameters
    ----------
    servos : sequence of Servo
        Their IDs need not differ, as on a real bus.
    gap_rule : bool
        Whether a silence of `GAP_TIME` within a frame makes the servos give it up.
    """

    def __init__(self, servos: Sequence[Servo], gap_rule: bool = False) -> None:
        self.servos = tuple(servos)
        self.parser = PacketParser()
        self._gap_rule = gap_rule
        self.wire_free = 0.0
        """When the last byte known of has left the wire, s."""
        self._listeners: dict[int, list[Servo]] = {}
        self._listeners_key: tuple[object, ...] = ()

    @property
    def moving(self) -> bool:
        """Whether time must be told to it even without requests."""
        return any(servo.moving for servo in self.servos)

    def advance(self, when: float) -> None:
        """Bring all servos to a time, s."""
        for servo in self.servos:
            servo.advance(when)

    def receive(self, chunk: bytes, when: float, baud_rate: float) -> list[Transmission]:
        """Take bytes from the client.

        Parameters
        ----------
        chunk : bytes
            What it sent.
        when : float
            When it began to send, s.
        baud_rate : float
            At what rate, bit/s.

        Returns
        -------
        list of Transmission
            The answers, in order of their due times.
        """
        listeners = self._who_hears(baud_rate)
        if self._gap_rule and self.parser.pending and when - self.wire_free > GAP_TIME:
            self.parser.give_up()
        begin = max(when, self.wire_free)
        self.wire_free = begin + wire_time(len(chunk), baud_rate)
        if not listeners:
            return self._answer_noise(chunk, baud_rate)
        before = self.parser.received
        answers: list[Transmission] = []
        wire_free = begin
        for packet in self.parser.feed(chunk):
            heard = max(begin + wire_time(max(0, packet.end - before), baud_rate), wire_free)
            sent = self._answer(packet, self._who_hears(baud_rate), heard, baud_rate)
            wire_free = sent[-1].due if sent else heard
            answers += sent
        self.wire_free = max(self.wire_free, wire_free)
        return answers

    def _answer(
        self,
        packet: Packet | DamagedPacket,
        listeners: dict[int, list[Servo]],
        heard: float,
        baud_rate: float,
    ) -> list[Transmission]:
        if isinstance(packet, DamagedPacket):
            replies = refuse_damaged(packet, listeners, heard)
        else:
            replies = execute(packet, listeners, heard)
        sent = []
        for reply in replies:
            heard += reply.delay + wire_time(len(reply.data), baud_rate)
            sent.append(Transmission(heard, reply.data))
        return sent

    def _answer_noise(self, chunk: bytes, baud_rate: float) -> list[Transmission]:
        """Answer a rate that no servo has with what a servo would hear of the request."""
        if not self.servos:
            return []
        noise = garble(chunk, baud_rate, self.servos[0].baud_rate)
        self.wire_free += wire_time(len(noise), baud_rate)
        return [Transmission(self.wire_free, noise)]

    def _who_hears(self, baud_rate: float) -> dict[int, list[Servo]]:
        key = (baud_rate, *((servo.servo_id, servo.baud_rate) for servo in self.servos))
        if key != self._listeners_key:
            self._listeners_key = key
            self._listeners = {}
            for servo in self.servos:
                if same_rate(baud_rate, servo.baud_rate):
                    self._listeners.setdefault(servo.servo_id, []).append(servo)
        return self._listeners
