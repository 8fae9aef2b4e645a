"""Asking a port whether servos answer on it: pings only, at the rates that servos are used at.

``armsyn scan`` looks at every rate; this looks for the first one at which anything answers.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from armsyn.driver.models import model_name
from armsyn.driver.transactions import Bus
from armsyn.errors import ArmFaultError, PortError, PortLostError

PROBE_BAUDS = (1_000_000, 57_600, 2_000_000, 3_000_000, 4_000_000, 115_200)
"""Rates that are tried, in this order: that of arms that are set up, that of new X-series servos
(of AX: the first), the fast ones, and what older programs like."""

PROBE_MARGIN = 0.02
"""Seconds that a reply may be late: an adapter as shipped keeps it for 16 ms."""

_GARBAGE = 8
"""Bytes that make no packet, from which on somebody seems to answer at another rate."""

OnStep = Callable[[int, int], None]
"""Told the number of steps that are done, and that of all."""


@dataclass(frozen=True)
class FoundServo:
    """A servo that answered.

    Attributes
    ----------
    servo_id : int
    number : int
        Of its model.
    protocol : {1, 2}
    """

    servo_id: int
    number: int
    protocol: int

    @property
    def model(self) -> str:
        """Name of its model."""
        return model_name(self.number)


@dataclass(frozen=True)
class Probe:
    """What a port answered.

    Attributes
    ----------
    baud : int or None
        At which servos answered; None when none did.
    servos : tuple of FoundServo
        By protocol and ID.
    garbled : bool
        Something answered that made no sense: noise, another rate, two servos with one ID.
    problem : str or None
        Why the port could not be probed to the end.
    """

    baud: int | None = None
    servos: tuple[FoundServo, ...] = ()
    garbled: bool = False
    problem: str | None = None


def probe(path: str, bauds: Sequence[int] = PROBE_BAUDS, on_step: OnStep | None = None) -> Probe:
    """Look for servos on a port, in both protocols, until a rate has some.

    Parameters
    ----------
    path : str
    bauds : sequence of int
        Bits a second, in the order to try.
    on_step : callable, optional
        For a progress bar.

    Returns
    -------
    Probe
        Errors of the port stand in it: one port that fails is no reason to leave the others.
    """
    garbled, before = False, 0
    steps = [(baud, protocol) for baud in bauds for protocol in (2, 1)]
    try:
        with contextlib.closing(Bus(path, bauds[0], PROBE_MARGIN)) as bus:
            found: list[FoundServo] = []
            for done, (baud, protocol) in enumerate(steps):
                if on_step is not None:
                    on_step(done, len(steps))
                if found and protocol == 2:
                    break  # of another rate
                if protocol == 2:
                    before = bus.parser_counters.garbage_bytes
                found += _ask(bus, baud, protocol)
                # of servos that answer, what was garbled at a rate that is not theirs says nothing
                here = bus.parser_counters.garbage_bytes - (before if found else 0)
                garbled = here >= _GARBAGE
    except ArmFaultError as error:
        return Probe(garbled=garbled, problem=str(error).removeprefix(f"port {path} "))
    if not found:
        return Probe(garbled=garbled)
    return Probe(bus.baudrate, tuple(found), garbled)


def _ask(bus: Bus, baud: int, protocol: int) -> list[FoundServo]:
    if bus.baudrate != baud:
        try:
            bus.setBaudRate(baud)
        except PortLostError:
            raise
        except PortError:  # this adapter does not have that rate
            return []
    numbers = bus.broadcast_ping(protocol)
    return [FoundServo(i, number, protocol) for i, number in numbers.items()]
