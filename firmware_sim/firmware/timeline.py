"""The time that all servos of a world share."""

from __future__ import annotations

import math

_TICK_WRAP = 32_768
"""Where Realtime Tick begins anew, ms."""


class Timeline:
    """The present moment, and until when nobody needs to look at a servo.

    Parameters
    ----------
    when : float
        The first moment, s.

    Attributes
    ----------
    now : float
        The present moment, s.
    alarm : float
        No servo does anything of itself before this time, s; it may have nothing to do then.
    identities : int
        How often a servo has taken an ID, a baud rate or a protocol.
    """

    __slots__ = ("alarm", "identities", "now")

    def __init__(self, when: float = 0.0) -> None:
        self.now = when
        self.alarm = math.inf
        self.identities = 0

    def wake_at(self, when: float) -> None:
        """Ask to be looked at, at a time in s."""
        self.alarm = min(self.alarm, when)


def realtime_tick(uptime: float) -> int:
    """Return what Realtime Tick reads so many s after a boot: ms, from 0 again after 32767."""
    return math.floor(uptime * 1e3 + 1e-6) % _TICK_WRAP
