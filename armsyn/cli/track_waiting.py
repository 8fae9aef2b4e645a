"""Targets that wait for the arm to turn to them, and which of them is next."""

from __future__ import annotations

import bisect
from typing import NamedTuple

from armsyn.cli.track_lines import NumberedTarget
from armsyn.planning.tracking import LEAD_S

AHEAD_S = 2.0 * LEAD_S
"""Seconds before its time at which a target is planned to."""

MOST_WAITING = 10_000
"""Targets that wait; with so many no line is read, and whoever sends them has to wait, too."""

MOST_DUE = 1_000
"""Targets that are due and wait for a newer one to be accepted."""


class _Waiting(NamedTuple):
    """A target in its place: those that come first, first."""

    rank: float
    number: int
    moment: float
    target: NumberedTarget


class WaitingTargets:
    """Targets in the order in which they are due.

    One without a time is due when it comes, one with a time then. Of several that are due by now
    the newest is next; only once it is accepted are those before it passed over, so that what is
    refused takes nobody's place. One whose time is still to come never does.

    Parameters
    ----------
    each : bool
        Whether each is next once, in the order of their lines.
    """

    def __init__(self, *, each: bool = False) -> None:
        self._each = each
        self._waiting: list[_Waiting] = []

    def __len__(self) -> int:
        return len(self._waiting)

    @property
    def full(self) -> bool:
        """Whether no more should be added."""
        return len(self._waiting) >= MOST_WAITING

    def add(self, target: NumberedTarget, now: float) -> list[NumberedTarget]:
        """Let a target wait.

        Parameters
        ----------
        target : NumberedTarget
        now : float
            s of the stream.

        Returns
        -------
        list of NumberedTarget
            Those that are given up for it, for too many are due.
        """
        moment = now if target.line.t is None else max(now, target.line.t)
        rank = 0.0 if self._each else moment
        bisect.insort(self._waiting, _Waiting(rank, target.number, moment, target))
        return self._taken(0 if self._each else self._due(now) - MOST_DUE)

    def next(self, now: float) -> NumberedTarget | None:
        """The target to turn to now; it waits on until it is `accepted` or `refused`."""
        due = 0 if self._each else self._due(now)
        if due:
            return self._waiting[due - 1].target
        if self._waiting and self._waiting[0].moment <= now + AHEAD_S:
            return self._waiting[0].target
        return None

    def accepted(self, target: NumberedTarget) -> list[NumberedTarget]:
        """Take out a target that the arm turns to, and return those that it passes over."""
        return self._taken(self._place(target) + 1)[:-1]

    def refused(self, target: NumberedTarget) -> None:
        """Take out a target that the arm cannot turn to."""
        del self._waiting[self._place(target)]

    def give_up(self) -> list[NumberedTarget]:
        """Take out all that are left."""
        return self._taken(len(self._waiting))

    def _due(self, now: float) -> int:
        """How many are due."""
        return bisect.bisect_right(self._waiting, now, key=lambda waiting: waiting.moment)

    def _place(self, target: NumberedTarget) -> int:
        return next(k for k, other in enumerate(self._waiting) if other.number == target.number)

    def _taken(self, count: int) -> list[NumberedTarget]:
        """Take out the first `count`."""
        count = max(count, 0)
        taken = [waiting.target for waiting in self._waiting[:count]]
        del self._waiting[:count]
        return taken
