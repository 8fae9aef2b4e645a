"""A bus with what goes wrong on it: what servers and stepped ports talk to.

It has no clock and does no input or output: it is told what arrived when, and says which bytes are
to leave when. The same requests at the same times, with the same faults and seed, give the same
bytes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from firmware_sim.faults.fault import Fault, Line, Piece, Site
from firmware_sim.faults.identity import own_settings
from firmware_sim.faults.parsing import parse_fault
from firmware_sim.faults.roster import Roster, Strike
from firmware_sim.faults.seam import Seam
from firmware_sim.faults.spec import FaultSpec
from firmware_sim.firmware.servo import Servo
from firmware_sim.wire.bus import Bus, Transmission
from firmware_sim.wire.line import wire_time


class Simulation:
    """One bus, as a client meets it.

    Parameters
    ----------
    bus : Bus
        The servos.
    start : float
        The time from which faults count theirs, s.
    faults : sequence of FaultSpec
        In force from the start, each in its own time.
    seed : int
        Of the faults' chance.
    report : callable, optional
        Told of each strike of a fault.

    Raises
    ------
    FaultError
        If a fault cannot act on this bus.
    """

    def __init__(
        self,
        bus: Bus,
        start: float = 0.0,
        *,
        faults: Sequence[FaultSpec] = (),
        seed: int = 0,
        report: Callable[[Strike], None] | None = None,
    ) -> None:
        self.bus = bus
        self.start = start
        self.now = start
        """The time it was brought to, s."""
        self._site = Site(bus.servos, start, self._talk)
        self._seam = Seam()
        self._roster = Roster(self._site, seed, report)
        self._spoken: list[Transmission] = []
        for spec in faults:
            self._roster.inject(spec, start)
        self._seam.take(self._roster.faults)
        self._wake_up_to(start)

    @property
    def faults(self) -> Sequence[Fault]:
        """The faults in force."""
        return tuple(self._roster)

    @property
    def log(self) -> Sequence[Strike]:
        """What struck, at most the last `roster.LOG_CAP` times."""
        return self._roster.log

    @property
    def noted(self) -> int:
        """How many entries `log` has had since the start."""
        return self._roster.noted

    @property
    def strikes(self) -> Mapping[str, int]:
        """How often faults of each name struck since the start."""
        return self._roster.struck

    @property
    def moving(self) -> bool:
        """Whether time must be told to it even without requests."""
        return self.bus.moving

    @property
    def next_event(self) -> float | None:
        """When time must be told to it next even without requests, s; None for never."""
        return self.now if self._spoken else self._roster.next_wake

    @property
    def wire_free(self) -> float:
        """When the last byte known of has left the wire, s."""
        return self.bus.wire_free

    @property
    def unplugged(self) -> bool:
        """Whether the port is to be gone: closed, and its link with it, until this is False."""
        return bool(self._site.unplugged_by)

    @property
    def forbidden(self) -> bool:
        """Whether nobody is to be permitted to open the port (mode 000)."""
        return bool(self._site.forbidden_by)

    def inject(self, fault: str | FaultSpec) -> Fault:
        """Put a fault in force now.

        Parameters
        ----------
        fault : str or FaultSpec
            Such as ``crc-error:id=3,probability=0.01``.

        Raises
        ------
        FaultError
            If the text makes no sense, or the fault cannot act on this bus.
        """
        spec = parse_fault(fault) if isinstance(fault, str) else fault
        injected = self._roster.inject(spec, self.now)
        self._seam.take(self._roster.faults)
        self._wake_up_to(self.now)
        return injected

    def clear(self, name: str = "all") -> list[Fault]:
        """Take faults away: those of a name, the one with a number, or all; return them.

        Raises
        ------
        FaultError
            If none is in force that is meant.
        """
        cleared = self._roster.clear(name, self.now)
        self._seam.take(self._roster.faults)
        return cleared

    def advance(self, when: float) -> list[Transmission]:
        """Bring everything to a time, s; return what left without a request of the client."""
        self._wake_up_to(when)
        self.bus.advance(when)
        return self._taken()

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
            What comes back, in order of the due times. One may be due before some returned
            earlier: `queue` keeps all in order.
        """
        if not self._roster.faults and not self._seam.holds:
            self.now = max(self.now, when)
            return self._taken() + self.bus.receive(chunk, when, baud_rate)
        self._wake_up_to(when)
        if self.unplugged:
            self._seam.reset()
            self._spoken.clear()
            return []
        line = self._line(len(chunk), when, baud_rate)
        answers: list[Transmission] = []
        for piece in self._seam.inward(chunk, line):
            with self._deafened(piece):
                answers += self.bus.receive(piece.data, piece.when, baud_rate)
        return self._taken() + self._seam.outward(answers, line)

    def catch_up(self, when: float) -> None:
        """Bring everything to a time, s; what leaves by itself waits for `advance` or `receive`."""
        self._wake_up_to(when)
        self.bus.advance(when)

    def snapshot(self, servo: Servo) -> dict[str, Any]:
        """Return what survives of a servo without power, and without the faults in force.

        As `Servo.snapshot`; a fault's baud rate or ID is none that the servo would keep.
        """
        snapshot = servo.snapshot()
        snapshot["eeprom"].update(own_settings(self._site, servo))
        return snapshot

    def free_wire(self, when: float) -> None:
        """Let nothing be on the wire any more after a time, s: the client has changed its rate."""
        self.bus.wire_free = min(self.bus.wire_free, when)

    def hang_up(self, when: float) -> None:
        """Forget, at a time in s, what is on its way between the servos and a client that is gone.

        What servos and faults do goes on.
        """
        self.free_wire(when)
        self._seam.reset()
        self._spoken.clear()

    def _line(self, size: int, when: float, baud_rate: float) -> Line:
        begin = max(when, self.bus.wire_free)
        return Line(baud_rate, when, begin, begin + wire_time(size, baud_rate))

    def _taken(self) -> list[Transmission]:
        taken, self._spoken = self._spoken, []
        return taken

    def _wake_up_to(self, when: float) -> None:
        """Let the faults do what is due up to a time, each at its own."""
        roster = self._roster
        while (wake := roster.next_wake) is not None and wake <= when:
            self.bus.advance(wake)
            self.now = max(self.now, wake)
            for fault in tuple(roster):
                if fault.wakes is not None and fault.wakes <= wake:
                    fault.wake(wake)
            self._forget_spent()
        self.now = max(self.now, when)
        self._forget_spent()

    def _forget_spent(self) -> None:
        if self._roster.drop_spent(self.now):
            self._seam.take(self._roster.faults)

    @contextmanager
    def _deafened(self, piece: Piece) -> Iterator[None]:
        """Let servos not hear a piece that does not reach them."""
        deaf = [
            servo
            for servo in self.bus.servos
            if servo.servo_id in piece.deaf and not servo.silenced
        ]
        for servo in deaf:
            servo.silenced = True
        try:
            yield
        finally:
            for servo in deaf:
                servo.silenced = False

    def _talk(
        self, data: bytes, when: float, baud_rate: float, *, to_servos: bool, to_client: bool
    ) -> None:
        """Put bytes on the wire that are not the client's."""
        line = self._line(len(data), when, baud_rate)
        heard = [Transmission(line.end, data)] if to_client else []
        if to_servos:
            answers = self.bus.receive(data, when, baud_rate)
            heard += answers if to_client else []
        if not self.unplugged:
            self._spoken += self._seam.outward(heard, line)


def queue(waiting: deque[Transmission], sent: Iterable[Transmission]) -> None:
    """Put transmissions among those that wait, in order of their due times.

    Parameters
    ----------
    waiting : deque of Transmission
        In order of due times; changed.
    sent : iterable of Transmission
        More of them. Of two with one due time, the one put in later stands behind.
    """
    for transmission in sent:
        if not waiting or waiting[-1].due <= transmission.due:
            waiting.append(transmission)
            continue
        later = []
        while waiting and waiting[-1].due > transmission.due:
            later.append(waiting.pop())
        waiting.append(transmission)
        waiting.extend(reversed(later))
