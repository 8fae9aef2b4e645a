"""The bus watchdog, which stops a servo whose host has gone silent.

Source: e-Manual, "Bus Watchdog(98)": it measures the time between instructions while the torque
is on; when that exceeds the register's value times 20 ms, the servo stops, the profile registers
become 0, the register reads -1, and goals are refused until 0 is written. The manual does not say
whether instructions to other servos count: here only those to this servo, or to all, do.
"""

from __future__ import annotations

from firmware_sim.memory import Memory
from firmware_sim.rules import WATCHDOG_EXPIRED

UNIT = 0.020
"""Of the register, s."""


class BusWatchdog:
    """The watchdog of one servo.

    Parameters
    ----------
    memory : Memory
        The servo's registers.
    """

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._fed_at = 0.0

    def feed(self, when: float) -> None:
        """Note an instruction, at a time in s."""
        self._fed_at = when

    def deadline(self) -> float | None:
        """Return when it expires, s, or None while it does not watch."""
        value = self._memory.value("Bus Watchdog")
        if not 0 < value < WATCHDOG_EXPIRED or not self._memory.value("Torque Enable"):
            return None
        return self._fed_at + value * UNIT

    def expire(self) -> None:
        """Leave the registers as an expiry does."""
        self._memory.store("Bus Watchdog", WATCHDOG_EXPIRED)
        self._memory.store("Profile Acceleration", 0)
        self._memory.store("Profile Velocity", 0)
