"""Where the simulator's time comes from: the machine, or a test's own hand."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Seconds since some start, never going back."""

    def now(self) -> float:
        """Return the present time, s."""


class RealClock:
    """The machine's monotonic clock."""

    def now(self) -> float:
        """Return the present time, s."""
        return time.monotonic()


class SteppedClock:
    """A clock that stands still until it is told to go on.

    Parameters
    ----------
    start : float
        Its first time, s.
    """

    def __init__(self, start: float = 0.0) -> None:
        self._now = start

    def now(self) -> float:
        """Return the present time, s."""
        return self._now

    def advance(self, duration: float) -> None:
        """Let time pass.

        Parameters
        ----------
        duration : float
            s, not negative.

        Raises
        ------
        ValueError
            If it is negative or not a number.
        """
        if not duration >= 0.0:
            raise ValueError(f"a clock cannot advance by {duration} s")
        self._now += duration

    def advance_to(self, when: float) -> None:
        """Let time pass until `when`, s; nothing happens if that is past."""
        self._now = max(self._now, when)
