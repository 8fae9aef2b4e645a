"""Servos on one half-duplex wire, with the time that bytes take on it.

A bus does no input or output and has no clock: it is told what arrived when, and says which bytes
are to leave when. Bytes take ten bits each at the client's baud rate; a request takes effect at
the end of its last byte; each answer ends no earlier than its servo's return delay plus its own
wire time after whatever was on the wire before it. Not modelled: the time that a servo takes to
work an instruction out, of which the manual says nothing (an AX-12 was measured at 18 us for a
ping, 22 us for a read, 24 us and 6 us a byte for a write).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from firmware_sim.firmware.servo import Servo
from firmware_sim.firmware.world import World
from firmware_sim.wire import protocol1, protocol2
from firmware_sim.wire.ears import Arrival, Ears
from firmware_sim.wire.line import collide, garble, same_rate, wire_time
from firmware_sim.wire.observed import Heard, Said
from firmware_sim.wire.parser import DamagedPacket
from firmware_sim.wire.replies import Listeners, Turn, gather

GAP_TIME = 1.5e-3
"""Silence within an instruction of protocol 2.0 after which a servo gives it up, s (e-Manual,
"DYNAMIXEL Protocol 2.0", Byte to Byte Time)."""

GAP_TIME_1 = 0.1
"""The same of protocol 1.0, s (e-Manual, "DYNAMIXEL Protocol 1.0", Byte to Byte Time)."""


class Transmission(NamedTuple):
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
    world : World
        The servos. Their IDs need not differ, as on a real bus: those of one ID talk at once.
    gap_rule : bool
        Whether a silence within a frame makes the servos give it up. Without it a header within a
        frame of protocol 2.0 begins a new one: there is no other way out of a LEN that lies.
    """

    def __init__(self, world: World, gap_rule: bool = True) -> None:
        self.world = world
        self.ears = Ears(restart=not gap_rule)
        self.observers: list[Callable[[Heard | Said], None]] = []
        """Called with each frame heard and said."""
        self.wire_free = 0.0
        """When the last byte known of has left the wire, s."""
        self._gap_rule = gap_rule
        self._baud_rate = 0.0
        self._listeners = {1: gather(()), 2: gather(())}
        self._listeners_key = (0.0, -1)

    @property
    def servos(self) -> tuple[Servo, ...]:
        """All of them."""
        return self.world.servos

    @property
    def moving(self) -> bool:
        """Whether time must be told to it even without requests."""
        return self.world.moving

    @property
    def next_event(self) -> float | None:
        """When time must be told to it next even without requests, s; None for never."""
        return self.world.next_event

    def advance(self, when: float) -> None:
        """Bring all servos to a time, s."""
        self.world.advance(when)

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
        self._forget(when - self.wire_free, baud_rate)
        begin = max(when, self.wire_free)
        self.wire_free = begin + wire_time(len(chunk), baud_rate)
        listeners = self._who_hears(baud_rate)
        if not (listeners[1].everyone or listeners[2].everyone):
            return self._answer_noise(chunk, baud_rate)
        sent: list[Transmission] = []
        wire_free = begin
        arrivals = self.ears.feed(chunk, both=bool(listeners[1].everyone))
        for number, arrival in enumerate(arrivals):
            if number:  # the one before may have changed an ID, a rate or a protocol
                listeners = self._who_hears(baud_rate)
            end = max(begin + wire_time(max(0, arrival.end), baud_rate), wire_free)
            answers = self._answer(arrival, listeners[arrival.protocol], end, baud_rate)
            wire_free = answers[-1].due if answers else end
            sent += answers
        self.wire_free = max(self.wire_free, wire_free)
        return sent

    def _forget(self, silence: float, baud_rate: float) -> None:
        """Let the servos give up unfinished frames after a silence, s, or at another rate."""
        other_rate = baud_rate != self._baud_rate
        self._baud_rate = baud_rate
        if other_rate or (self._gap_rule and silence > GAP_TIME):
            self.ears.give_up(2)
        if other_rate or (self._gap_rule and silence > GAP_TIME_1):
            self.ears.give_up(1)

    def _answer(
        self, arrival: Arrival, listeners: Listeners, end: float, baud_rate: float
    ) -> list[Transmission]:
        """Let the servos act on a frame that ended at a time, s."""
        protocol, packet, _end = arrival
        for observer in self.observers:
            observer(Heard(end, protocol, packet))
        self.world.advance(end)
        speak = protocol2 if protocol == 2 else protocol1
        if isinstance(packet, DamagedPacket):
            turns = speak.refuse_damaged(packet, listeners)
        else:
            turns = speak.execute(packet, listeners, end)
        sent = _schedule(turns, end, baud_rate)
        for observer in self.observers:
            for transmission in sent:
                observer(Said(transmission.due, protocol, transmission.data))
        return sent

    def _answer_noise(self, chunk: bytes, baud_rate: float) -> list[Transmission]:
        """Answer a rate that no servo has with what a servo would hear of the request."""
        if not self.servos:
            return []
        noise = garble(chunk, baud_rate, self.servos[0].baud_rate)
        self.wire_free += wire_time(len(noise), baud_rate)
        return [Transmission(self.wire_free, noise)] if noise else []

    def _who_hears(self, baud_rate: float) -> dict[int, Listeners]:
        """Return who hears each protocol at a baud rate."""
        key = (baud_rate, self.world.identities)
        if key != self._listeners_key:
            self._listeners_key = key
            hear = [servo for servo in self.servos if same_rate(baud_rate, servo.baud_rate)]
            self._listeners = {
                protocol: gather(servo for servo in hear if servo.protocol == protocol)
                for protocol in (1, 2)
            }
        return self._listeners


def _schedule(turns: Sequence[Turn], request_end: float, baud_rate: float) -> list[Transmission]:
    """Return answers with their times on the wire, one turn after the other."""
    sent = []
    free = request_end
    for turn in turns:
        if len(turn) == 1:
            ((data, delay, wait),) = turn
            free = max(free, request_end + wait) + delay + wire_time(len(data), baud_rate)
        else:
            starts = [max(free, request_end + reply.turn) + reply.delay for reply in turn]
            frames = [(start, reply.data) for start, reply in zip(starts, turn, strict=True)]
            free, data = collide(frames, baud_rate)
        sent.append(Transmission(free, data))
    return sent
