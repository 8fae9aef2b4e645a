"""Says on standard error what faults do, without drowning the reader in it."""

from __future__ import annotations

from collections import Counter
from itertools import islice

from firmware_sim.command.words import complain
from firmware_sim.simulation import Simulation

_PERIOD = 0.1  # s
_SHOWN = 5
"""Strikes of each fault that are said as they come; the others are counted at the end."""


class StrikeTeller:
    """Tells the first strikes of each fault: a `server.Chore`.

    Parameters
    ----------
    simulation : Simulation
        Whose faults.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._seen = 0
        self._said: Counter[int] = Counter()
        self.next_due = 0.0

    def work(self, now: float) -> None:
        """Tell what is new."""
        log = self._simulation.log
        new = min(self._simulation.noted - self._seen, len(log))
        self._seen = self._simulation.noted
        for strike in islice(log, len(log) - new, None):
            self._said[strike.number] += 1
            if self._said[strike.number] <= _SHOWN:
                complain(str(strike))
            if self._said[strike.number] == _SHOWN:
                complain(f"fault {strike.number} {strike.name}: what follows is counted, not said")
        self.next_due = now + _PERIOD

    def close(self) -> None:
        """Say how often each fault struck."""
        self.work(0.0)
        for name, count in self._simulation.strikes.items():
            complain(f"{name}: {count} strikes")
