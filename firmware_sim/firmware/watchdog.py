"""The bus watchdog, which stops a servo whose host has gone silent.

Source: e-Manual, "Bus Watchdog(98)": it measures the time between instructions while the torque
is on; when that exceeds the register's value times 20 ms, the servo stops, the profile registers
become 0, the register reads -1, and goals are refused until 0 is written. What counts is "all the
Instruction Packet in the DYNAMIXEL Protocol": any intact one that the servo hears, whomever it
names. Where the manual is silent: one of the other protocol, or at another baud rate, is not heard;
a servo set to protocol 1.0 does not watch.

So the shadow of a joint of two (a servo whose Secondary ID is the other's ID) is fed by all that is
sent on the bus, as its leader is. What is written to the leader's Bus Watchdog reaches it too: that
is RAM, so one write arms or clears both. Each expires for itself, and only its own ID tells that.
"""

from __future__ import annotations

import math

from firmware_sim.firmware.codes import WATCHDOG_EXPIRED
from firmware_sim.firmware.memory import Memory

UNIT = 0.020
"""Of the register, s."""


class BusWatchdog:
    """The watchdog of one servo; one whose table has none never expires.

    Parameters
    ----------
    memory : Memory
        The servo's registers.
    """

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._exists = "Bus Watchdog" in memory.table.by_name
        self._speaks_protocol_1 = "Protocol Type" in memory.table.by_name
        self.fed_at = 0.0
        """When the last instruction came, s."""

    @property
    def deadline(self) -> float:
        """When it expires unless it is fed, s; infinity while it does not watch."""
        value = self._memory.value
        time = value("Bus Watchdog") if self._exists else 0
        if not 0 < time < WATCHDOG_EXPIRED or not value("Torque Enable"):
            return math.inf
        if self._speaks_protocol_1 and value("Protocol Type") != 2:
            return math.inf
        return self.fed_at + time * UNIT

    def expire(self) -> None:
        """Leave the registers as an expiry does."""
        self._memory.store("Bus Watchdog", WATCHDOG_EXPIRED)
        self._memory.store("Profile Acceleration", 0)
        self._memory.store("Profile Velocity", 0)
