"""The faults in force, and the record of what struck when."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random

from firmware_sim.errors import FaultError
from firmware_sim.faults.fault import Fault, Site
from firmware_sim.faults.spec import FaultSpec

TICK = 1.0e-3
"""Unit of the ticks that strikes are logged with, s: a step of the physics."""

FAULT_CAP = 1000
"""Most faults in force at a time."""

LOG_CAP = 10_000
"""How many strikes are remembered; older ones are forgotten."""


@dataclass(frozen=True, slots=True)
class Strike:
    """A fault has struck.

    Parameters
    ----------
    tick : int
        Whole steps of `TICK` since the start.
    time : float
        s since the start.
    name : str
        Of the fault.
    number : int
        Which of all faults injected it is, from 1.
    servo_id : int or None
        Whom it struck, where it was one servo.
    detail : str
        What it did, in a few words.
    """

    tick: int
    time: float
    name: str
    number: int
    servo_id: int | None
    detail: str
    ends: bool = False

    def __str__(self) -> str:
        servo = "" if self.servo_id is None else f" servo {self.servo_id}"
        detail = f": {self.detail}" if self.detail else ""
        return (
            f"tick {self.tick} ({self.time:.6f} s) fault {self.number} {self.name}{servo}{detail}"
        )


class Roster:
    """Faults in force.

    Parameters
    ----------
    site : Site
        What they act on.
    seed : int
        Of their chance. Each fault has its own source of it, drawn from the seed, its name and how
        many of that name came before, so that no fault shifts another's.
    report : callable, optional
        Told of each strike.
    """

    def __init__(
        self, site: Site, seed: int = 0, report: Callable[[Strike], None] | None = None
    ) -> None:
        self.faults: list[Fault] = []
        self.log: deque[Strike] = deque(maxlen=LOG_CAP)
        self.struck: Counter[str] = Counter()
        """How often faults of each name struck since the start; their ends are not counted."""
        self.noted = 0
        """How many entries `log` has had since the start."""
        self._site = site
        self._seed = seed
        self._report = report
        self._injected: Counter[str] = Counter()

    def __iter__(self) -> Iterator[Fault]:
        return iter(self.faults)

    @property
    def next_wake(self) -> float | None:
        """When a fault is to be woken next, s."""
        if not self.faults:
            return None
        return min((f.wakes for f in self.faults if f.wakes is not None), default=None)

    def inject(self, spec: FaultSpec, now: float) -> Fault:
        """Put a fault in force.

        Raises
        ------
        FaultError
            If it cannot act on this bus, or there are too many.
        """
        if len(self.faults) >= FAULT_CAP:
            raise FaultError(f"{FAULT_CAP} faults are in force: clear some")
        name = spec.kind.name
        fault = spec.kind.make(spec, Random(f"{self._seed}/{name}/{self._injected[name]}"))  # noqa: S311
        fault.site = self._site
        fault.log = self._note
        fault.number = self._injected.total() + 1
        fault.begin = spec.begin(self._site.start, now)
        try:
            fault.check()
        except FaultError as error:
            if not spec.source:
                raise
            raise FaultError(f"{spec.source}: {error}") from None
        self._injected[name] += 1
        self.faults.append(fault)
        return fault

    def clear(self, name: str, now: float) -> list[Fault]:
        """Take faults away: all of a name, the one with a number, or ``all``.

        Raises
        ------
        FaultError
            If none is in force that is meant.
        """
        found = [f for f in self.faults if name in ("all", f.spec.kind.name, str(f.number))]
        if not found and name != "all":
            raise FaultError(f"no fault {name[:40]!r} is in force")
        for fault in found:
            self.faults.remove(fault)
            fault.stop(now)
        return found

    def drop_spent(self, now: float) -> bool:
        """Forget the faults that are over; return whether there were any."""
        spent = [fault for fault in self.faults if fault.spent(now)]
        for fault in spent:
            self.faults.remove(fault)
            fault.stop(now)
        return bool(spent)

    def _note(
        self, fault: Fault, when: float, servo_id: int | None, detail: str, *, ends: bool = False
    ) -> None:
        time = when - self._site.start
        name = fault.spec.kind.name
        tick = int(time / TICK + 1.0e-6)
        strike = Strike(tick, time, name, fault.number, servo_id, detail, ends)
        self.log.append(strike)
        self.noted += 1
        self.struck[name] += not ends
        if self._report is not None:
            self._report(strike)
