"""How many lost answers a bus may ask for again before it counts as broken.

A token bucket: every repetition takes one, time gives them back. A bus that loses a packet now and
then never runs dry; one that loses them for good soon does, and then says so instead of repeating
every request for ever.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class ErrorBudget:
    """Repetitions that are left.

    Parameters
    ----------
    capacity : float
        Repetitions in one go.
    rate : float
        Repetitions a second that come back.

    Attributes
    ----------
    spent : int
        Repetitions so far.
    """

    capacity: float = 60.0
    rate: float = 6.0
    spent: int = 0
    _left: float = field(init=False)
    _since: float | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self._left = self.capacity

    def take(self, now: float) -> bool:
        """Take one repetition at a time, s, on any clock that goes forward; False: none is left."""
        if self._since is not None:
            self._left = min(self.capacity, self._left + self.rate * max(0.0, now - self._since))
        self._since = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        self.spent += 1
        return True
