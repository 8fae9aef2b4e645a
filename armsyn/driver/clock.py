"""The clock a stream runs on; tests give it one of their own."""

from __future__ import annotations

import time
from typing import Protocol

SPIN = 200e-6
"""Seconds before a deadline from which on waiting is done by looking at the clock."""


class Clock(Protocol):
    """Time that only goes forward."""

    def now(self) -> float:
        """Seconds since some fixed moment."""
        ...

    def sleep_until(self, moment: float) -> None:
        """Return once `now` has reached `moment`; at once when it has."""
        ...


class MonotonicClock:
    """The system's monotonic clock. Sleeps, then spins the last 200 us to be on time."""

    def now(self) -> float:
        """Seconds since some fixed moment."""
        return time.monotonic()

    def sleep_until(self, moment: float) -> None:
        """Return once `now` has reached `moment`; at once when it has."""
        left = moment - time.monotonic()
        if left > SPIN:
            time.sleep(left - SPIN)
        while time.monotonic() < moment:
            pass
