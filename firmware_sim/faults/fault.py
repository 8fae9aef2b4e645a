"""What all faults have in common: when they may strike, and what they can reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random
from typing import ClassVar, Protocol

from firmware_sim.errors import FaultError
from firmware_sim.faults.spec import FaultSpec
from firmware_sim.firmware.servo import Servo

WIRE, ADAPTER = 0, 1
"""Stages that bytes pass: from the servos over the wire through the adapter to the client."""


@dataclass(frozen=True, slots=True)
class Piece:
    """Bytes on their way, either way.

    Parameters
    ----------
    data : bytes
        Usually one packet.
    when : float
        s: to the servos, when the first of them leaves the client; to the client, when the last of
        them has arrived.
    servo_id : int or None
        Whom a request addresses, or who replies; None where the bytes are no packet.
    deaf : frozenset of int
        IDs of servos that a request does not reach.
    """

    data: bytes
    when: float
    servo_id: int | None = None
    deaf: frozenset[int] = frozenset()


@dataclass(frozen=True, slots=True)
class Line:
    """The exchange that pieces belong to.

    Parameters
    ----------
    baud_rate : float
        The client's, bit/s.
    when : float
        When the client's bytes came, s.
    begin, end : float
        When they begin and end on the wire, s.
    """

    baud_rate: float
    when: float
    begin: float
    end: float


class Talk(Protocol):
    """Puts bytes of nobody's request on the wire; what comes back is on its way to the client."""

    def __call__(
        self, data: bytes, when: float, baud_rate: float, *, to_servos: bool, to_client: bool
    ) -> None:
        """Put them there at a time in s, at a rate in bit/s."""


class Log(Protocol):
    """Keeps record of what faults do."""

    def __call__(
        self, fault: Fault, when: float, servo_id: int | None, detail: str, *, ends: bool = False
    ) -> None:
        """Keep that a fault struck, or ended, at a time in s."""


@dataclass(slots=True)
class Site:
    """What faults can reach.

    Parameters
    ----------
    servos : sequence of Servo
        On the bus.
    start : float
        From when times count, s.
    talk : callable
        Puts bytes on the wire.
    """

    servos: Sequence[Servo]
    start: float
    talk: Talk
    unplugged_by: set[int] = field(default_factory=set)
    """Numbers of the faults that keep the port unplugged."""
    forbidden_by: set[int] = field(default_factory=set)
    """Numbers of the faults that keep the port forbidden."""
    states: list[Fault] = field(default_factory=list)
    """Faults that hold servos in another state, in the order in which they took hold."""

    normal: dict[tuple[str, Servo], float] = field(default_factory=dict)
    """What faults have changed in servos, by effect, as it was before the first did."""

    def chosen(self, servo_id: int | None) -> list[Servo]:
        """Return the servos with an ID; all for None."""
        return [servo for servo in self.servos if servo_id in (None, servo.servo_id)]


class Fault:
    """One fault in force; each kind overrides what it needs.

    Parameters
    ----------
    spec : FaultSpec
        What is asked of it.
    random : Random
        Its own source of chance.
    """

    stage: ClassVar[int] = WIRE
    wants_requests = False
    """Whether it strikes requests, which must be cut into packets for it."""

    site: Site
    log: Log
    number = 0
    """Which of the faults injected so far it is."""
    begin = 0.0
    """When it begins, s."""

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        self.spec = spec
        self.random = random
        # Apart, so that what one strike draws does not shift when the next one comes.
        self._chance = Random(random.getrandbits(64))  # noqa: S311
        self.strikes = 0
        self.wakes: float | None = None
        """When `wake` is to be called next, s."""

    @property
    def end(self) -> float | None:
        """When its window closes, s."""
        duration = self.spec.optional("for")
        return None if duration is None else self.begin + duration

    @property
    def exhausted(self) -> bool:
        """Whether it has struck as often as it may."""
        count = self.spec.optional("count")
        return count is not None and self.strikes >= count

    def spent(self, when: float) -> bool:
        """Return whether nothing can come of it any more."""
        end = self.end
        return self.exhausted or (end is not None and when >= end)

    def check(self) -> None:
        """See whether it can act on this bus at all.

        Raises
        ------
        FaultError
            If it cannot.
        """
        servo_id = self.spec.servo_id
        if servo_id is not None and not self.site.chosen(servo_id):
            present = ", ".join(sorted({str(servo.servo_id) for servo in self.site.servos}))
            raise FaultError(f"{self.spec.kind.name}: no servo {servo_id}; there are: {present}")

    def happens(self) -> bool:
        """Return whether chance lets it strike, where that is left to chance."""
        return self._chance.random() < self.spec.number("probability")

    def wake(self, when: float) -> None:
        """Do what is due at a time in s, and set `wakes` anew."""

    def inward(self, pieces: list[Piece], _line: Line) -> list[Piece]:
        """Return what becomes of bytes to the servos."""
        return pieces

    def outward(self, pieces: list[Piece], _line: Line) -> list[Piece]:
        """Return what becomes of bytes to the client."""
        return pieces

    def stop(self, when: float) -> None:
        """Leave nothing of it in force; the fault is taken away."""

    def struck(self, when: float, servo_id: int | None = None, detail: str = "") -> None:
        """Count a strike, and have it logged."""
        self.strikes += 1
        self.log(self, when, servo_id, detail)
