"""The arrays a stream records into, allocated before it starts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.driver.joints import JointState

FloatArray = NDArray[np.float64]


class StreamLog:
    """One row a tick.

    Parameters
    ----------
    capacity : int
        Rows that fit; later ones are dropped and counted, the motion goes on.
    joints : int

    Attributes
    ----------
    rows, dropped : int
        Rows written, and rows that did not fit.
    events : list of (float, str)
        What happened, with its time, s.
    """

    def __init__(self, capacity: int, joints: int) -> None:
        shape = (capacity, joints)
        self.time = np.zeros(capacity)
        self.commanded = np.zeros(shape)
        self.measured = np.zeros(shape)
        self.velocity = np.zeros(shape)
        self.current = np.zeros(shape)
        self.stale = np.zeros(shape, dtype=np.bool_)
        self.hardware_error = np.zeros(shape, dtype=np.uint8)
        self.rows = 0
        self.dropped = 0
        self.events: list[tuple[float, str]] = []

    def append(
        self,
        time: float,
        command: FloatArray,
        state: JointState,
        hardware_error: NDArray[np.uint8],
    ) -> None:
        """Write a row; nothing is allocated."""
        row = self.rows
        if row == self.time.size:
            self.dropped += 1
            return
        self.time[row] = time
        self.commanded[row] = command
        self.measured[row] = state.position
        self.velocity[row] = state.velocity
        self.current[row] = state.current
        np.logical_not(state.fresh, out=self.stale[row])
        self.hardware_error[row] = hardware_error
        self.rows = row + 1

    def note(self, time: float, text: str) -> None:
        """Keep an event."""
        self.events.append((time, text))
