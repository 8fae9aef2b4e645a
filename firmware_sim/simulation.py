"""A bus with what goes wrong on it: what servers and stepped ports talk to.

It has no clock and does no input or output: it is told what arrived when, and says which bytes are
to leave when.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from firmware_sim.bus import Bus, Transmission


class Simulation:
    """One bus, as a client meets it.

    Parameters
    ----------
    bus : Bus
        The servos.
    start : float
        The time from which faults count theirs, s.
    """

    def __init__(self, bus: Bus, start: float = 0.0) -> None:
        self.bus = bus
        self.start = start

    @property
    def moving(self) -> bool:
        """Whether time must be told to it even without requests."""
        return self.bus.moving

    @property
    def next_event(self) -> float | None:
        """When time must be told to it next even without requests, s; None for never."""
        return None

    @property
    def wire_free(self) -> float:
        """When the last byte known of has left the wire, s."""
        return self.bus.wire_free

    @property
    def unplugged(self) -> bool:
        """Whether the port is to be gone: closed, and its link with it, until this is False."""
        return False

    @property
    def forbidden(self) -> bool:
        """Whether nobody is to be permitted to open the port (mode 000)."""
        return False

    def advance(self, when: float) -> list[Transmission]:
        """Bring everything to a time, s; return what left without a request of the client."""
        self.bus.advance(when)
        return []

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
        return self.bus.receive(chunk, when, baud_rate)


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
        later = []
        while waiting and waiting[-1].due > transmission.due:
            later.append(waiting.pop())
        waiting.append(transmission)
        waiting.extend(reversed(later))
