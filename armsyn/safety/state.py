"""What one tick of a stream is judged by."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_UNKNOWN = np.array(np.nan)
_NONE_FRESH = np.array(False)


class TickState(NamedTuple):
    """What a tick is judged by.

    Attributes
    ----------
    commands : array, shape (3, n)
        The last three, a period apart, oldest first, rad.
    measured : array, shape (n,)
        Where the joints were last seen, rad.
    speed : array, shape (n,)
        Of the goals, of late, rad/s, not negative.
    fresh : array of bool, shape (n,)
        Which of `measured` are answers to the last command.
    temperature, current, voltage : array, shape (n,)
        Last known, degrees Celsius, A (see `averaged_current`) and V; NaN where unknown.
    """

    commands: FloatArray
    measured: FloatArray
    speed: FloatArray
    fresh: BoolArray
    temperature: FloatArray = _UNKNOWN
    current: FloatArray = _UNKNOWN
    voltage: FloatArray = _UNKNOWN

    @classmethod
    def at_rest(cls, posture: ArrayLike) -> Self:
        """State of an arm whose goals stand still at a posture, shape (n,), rad; nothing fresh."""
        goals = np.array(posture, dtype=np.float64)
        return cls(
            np.tile(goals, (3, 1)), goals, np.zeros(goals.size), np.zeros(goals.size, np.bool_)
        )

    def after(self, command: FloatArray) -> Self:
        """Return the state once a command, shape (n,), rad, has been sent; not yet answered."""
        commands = np.concatenate([self.commands[1:], command[None]])
        return self._replace(commands=commands, fresh=_NONE_FRESH)
