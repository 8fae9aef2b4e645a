"""What a stream follows, tick by tick: a path or a setpoint function, and how it comes to rest."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from armsyn.driver.joints import JointState
from armsyn.driver.path import PathTime

FloatArray = NDArray[np.float64]

SHORTEST_RAMP = 0.2
"""Seconds of the shortest deceleration."""


class Followable(Protocol):
    """A posture for every path time; `armsyn.driver.path.Path` is one."""

    @property
    def duration(self) -> float:
        """Of the path, s."""

    def at(self, path_time: float) -> FloatArray:
        """Posture at a path time, shape (n,), rad; the ends before and after."""


class Course(Protocol):
    """What a `Streamer` runs along."""

    @property
    def now(self) -> float:
        """Path time, s."""

    @property
    def duration(self) -> float:
        """Of the path, s; the longest it may take where nobody knows."""

    @property
    def finished(self) -> bool:
        """Whether it stands still from now on."""

    @property
    def stopping(self) -> bool:
        """Whether it comes to a stop, or has, because it was asked to."""

    def advance(self, state: JointState | None) -> FloatArray:
        """Posture of the next tick, shape (n,), rad."""

    def stop(self) -> None:
        """Come to rest from here."""

    def resume_from_rest(self) -> None:
        """Go on from a standstill: the arm has come to rest."""

    def halt(self) -> None:
        """Be stopped where it stands: the arm has come to rest and is not to go on."""


class PathCourse:
    """A path, passed at the pace of path time.

    Parameters
    ----------
    path : Followable
    max_acceleration : array, shape (n,)
        rad/s2.
    period : float
        s.
    """

    def __init__(self, path: Followable, max_acceleration: FloatArray, period: float) -> None:
        self.path = path
        self.duration = path.duration
        self._max_acceleration = max_acceleration
        self._period = period
        self._time = PathTime()

    @property
    def now(self) -> float:
        """Path time, s."""
        return self._time.now

    @property
    def finished(self) -> bool:
        """Whether the path's end, or a stop on it, is reached."""
        return self._time.stopped or self._time.now >= self.duration

    @property
    def stopping(self) -> bool:
        """Whether it comes to a stop, or has, because it was asked to."""
        return self._time.stopping

    def advance(self, state: JointState | None) -> FloatArray:
        """Posture of the next tick, shape (n,), rad."""
        del state
        return self.path.at(self._time.advance(self._period))

    def stop(self) -> None:
        """Let path time ramp down."""
        self._time.stop(self._ramp())

    def resume_from_rest(self) -> None:
        """Let path time start anew."""
        self._time.resume_from_rest(self._ramp())

    def halt(self) -> None:
        """Let path time stand still."""
        self._time.halt()

    def _ramp(self) -> float:
        back, here, ahead = (
            self.path.at(self._time.now + d) for d in (-self._period, 0.0, self._period)
        )
        speed = np.maximum(np.abs(here - back), np.abs(ahead - here)) / self._period
        return ramp_time(speed, self._max_acceleration)


class Coast:
    """The way that joints go on while they come to rest, with a smooth ramp of speed.

    Parameters
    ----------
    start, velocity : array, shape (n,)
        rad, rad/s.
    max_acceleration : array, shape (n,)
        rad/s2.
    lower, upper : array, shape (n,)
        Range, rad: a joint that would leave it brakes harder.
    """

    def __init__(
        self,
        start: FloatArray,
        velocity: FloatArray,
        max_acceleration: FloatArray,
        lower: FloatArray,
        upper: FloatArray,
    ) -> None:
        self._start, self._velocity = start, velocity
        self.duration = ramp_time(np.abs(velocity), max_acceleration)
        room = np.where(velocity >= 0.0, upper - start, start - lower).clip(min=0.0)
        # a ramp of length T travels half of what full speed would
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            longest = 2.0 * room / np.abs(velocity)
        self._ramps = np.where(velocity == 0.0, self.duration, np.fmin(longest, self.duration))

    def at(self, elapsed: float) -> FloatArray:
        """Posture `elapsed` seconds after the start, shape (n,), rad."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            u = np.where(self._ramps > 0.0, np.clip(elapsed / self._ramps, 0.0, 1.0), 1.0)
        way = self._velocity * self._ramps * (u - u**3 + 0.5 * u**4)
        return np.asarray(self._start + way)


def ramp_time(speed: FloatArray, max_acceleration: FloatArray) -> float:
    """Seconds of a smooth ramp between rest and joint speeds, shape (n,), rad/s.

    At most half of the acceleration that the joints may have: the motion itself needs some, too.
    A smoothstep's steepest slope is 3/2 of its mean.
    """
    return max(SHORTEST_RAMP, 3.0 * float(np.max(speed / max_acceleration)))
