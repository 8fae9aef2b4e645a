"""The arrays a stream records into, allocated before it starts."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.driver.joints import JointState

FloatArray = NDArray[np.float64]


MOST_ROWS = 720_000
"""Rows that are recorded at most: an hour at 200 Hz, 0.26 GB for 7 joints."""

Level = Literal["info", "warning", "fault"]
"""How grave an event is."""


class Event(NamedTuple):
    """What happened.

    Attributes
    ----------
    time : float
        s.
    text : str
        One line, for people.
    level : Level
    """

    time: float
    text: str
    level: Level = "info"


class StreamLog:
    """One row a tick.

    All memory is touched beforehand, so that a stream neither grows nor waits for pages.

    Parameters
    ----------
    capacity : int
        Rows that fit; later ones are dropped and counted, the motion goes on.
    joints : int

    Attributes
    ----------
    rows, dropped : int
        Rows written, and rows that did not fit.
    events : list of Event
    """

    def __init__(self, capacity: int, joints: int) -> None:
        shape = (capacity, joints)
        self.time = np.full(capacity, 0.0)
        self.commanded = np.full(shape, 0.0)
        self.sent = np.full(shape, 0.0)
        self.measured = np.full(shape, 0.0)
        self.velocity = np.full(shape, 0.0)
        self.current = np.full(shape, 0.0)
        self.temperature = np.full(shape, np.nan, dtype=np.float32)
        self.voltage = np.full(shape, np.nan, dtype=np.float32)
        self.stale = np.full(shape, False)
        self.hardware_error = np.full(shape, 0, dtype=np.uint8)
        self.rows = 0
        self.dropped = 0
        self.events: list[Event] = []

    def append(
        self,
        time: float,
        command: FloatArray,
        sent: FloatArray,
        state: JointState,
        hardware_error: NDArray[np.uint8],
    ) -> None:
        """Write a row; nothing is allocated.

        Parameters
        ----------
        time : float
            s.
        command, sent : array, shape (n,)
            The posture wanted, and the goals that were sent for it, rad.
        state : JointState
        hardware_error : array of uint8, shape (n,)
        """
        row = self.rows
        if row == self.time.size:
            self.dropped += 1
            return
        self.time[row] = time
        self.commanded[row] = command
        self.sent[row] = sent
        self.measured[row] = state.position
        self.velocity[row] = state.velocity
        self.current[row] = state.current
        self.temperature[row] = state.temperature
        self.voltage[row] = state.voltage
        np.logical_not(state.fresh, out=self.stale[row])
        self.hardware_error[row] = hardware_error
        self.rows = row + 1

    def note(self, time: float, text: str, level: Level = "info") -> None:
        """Keep an event."""
        self.events.append(Event(time, text, level))
