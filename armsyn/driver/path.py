"""The path a stream follows: a motion as a function of path time, and how path time passes.

Interpolation is monotone piecewise cubic (Fritsch and Carlson, SIAM J. Numer. Anal. 17, 1980,
with the harmonic mean of Fritsch and Butland, 1984): it has no velocity steps, and between two
samples it never leaves their range, so a motion within its limits stays there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import RefusedMotionError
from armsyn.motion import Motion

FloatArray = NDArray[np.float64]

BLEND = 0.25
"""Seconds over which the stream moves from where the goals stand to the path."""

_MARGIN = 1.05
"""Straight ways are this much slower than the limits allow."""

_SHORTEST_WAY = 0.3
"""Seconds of the shortest straight way."""

MOST_FRAMES = 120_000
"""Samples of the longest straight way: ten minutes at 200 Hz."""

_ALMOST = 1.0 - 1e-9
"""Part of a ramp from which on it is over, but for rounding."""


def minimum_jerk(x: ArrayLike) -> FloatArray:
    """From 0 at `x` <= 0 to 1 at `x` >= 1 (Flash and Hogan, J. Neurosci. 5, 1985, eq. 6)."""
    u = np.clip(np.asarray(x, dtype=np.float64), 0.0, 1.0)
    return np.asarray(u**3 * (10.0 - 15.0 * u + 6.0 * u**2))


class Path:
    """A motion as a function of path time, which starts at 0.

    Parameters
    ----------
    motion : Motion
        With angles, rad.
    start : array, shape (n,), optional
        Where the goals stand, rad. The difference to the motion's start fades away over the
        first 0.25 s instead of being a jump; a shorter motion is waited for at its end.

    Attributes
    ----------
    duration : float
        s.
    """

    def __init__(self, motion: Motion, start: FloatArray | None = None) -> None:
        if motion.angles is None:
            raise ValueError("a path needs joint angles")
        self._time = motion.time - motion.time[0]
        self._angles = motion.angles
        self._slopes = _monotone_slopes(self._time, motion.angles)
        self.duration = float(self._time[-1])
        self._offset = None if start is None else start - motion.angles[0]
        if self._offset is not None and self._offset.any():
            self.duration = max(self.duration, BLEND)

    def at(self, path_time: float) -> FloatArray:
        """Posture at a path time, shape (n,), rad; before and after, the ends."""
        t = min(max(path_time, 0.0), float(self._time[-1]))
        k = min(int(np.searchsorted(self._time, t, side="right")), self._time.size - 1)
        h = self._time[k] - self._time[k - 1]
        posture = self._cubic(k, h, (t - self._time[k - 1]) / h)
        if self._offset is not None and path_time < BLEND:
            posture += self._offset * (1.0 - minimum_jerk(path_time / BLEND))
        return posture

    def at_times(self, path_times: FloatArray) -> FloatArray:
        """Postures at many path times, shape (m,), s: rows of shape (m, n) as `at`, rad."""
        t = np.minimum(np.maximum(path_times, 0.0), self._time[-1])
        k = np.minimum(np.searchsorted(self._time, t, side="right"), self._time.size - 1)
        h = self._time[k] - self._time[k - 1]
        u = (t - self._time[k - 1]) / h
        postures = self._cubic(k, h[:, None], u[:, None])
        if self._offset is not None:
            postures += self._offset * (1.0 - minimum_jerk(path_times / BLEND))[:, None]
        return postures

    def _cubic(
        self, k: int | NDArray[np.int64], h: float | FloatArray, u: float | FloatArray
    ) -> FloatArray:
        """Part `u` of the way from sample `k` - 1 to `k`, which are `h` s apart."""
        posture = (1.0 + 2.0 * u) * (1.0 - u) ** 2 * self._angles[k - 1]
        posture += u**2 * (3.0 - 2.0 * u) * self._angles[k]
        posture += h * u * (1.0 - u) ** 2 * self._slopes[k - 1]
        posture -= h * u**2 * (1.0 - u) * self._slopes[k]
        return np.asarray(posture)


def _monotone_slopes(time: FloatArray, values: FloatArray) -> FloatArray:
    secants = np.diff(values, axis=0) / np.diff(time)[:, None]
    slopes = np.zeros_like(values)
    before, after = secants[:-1], secants[1:]
    same = before * after > 0.0
    total = np.where(same, before + after, 1.0)
    slopes[1:-1] = np.where(same, 2.0 * before * after / total, 0.0)
    return slopes  # 0 at both ends: an arm is at rest before and after


class PathTime:
    """How fast path time passes: 1 while streaming, ramping to 0 for a stop on the path.

    Ramps begin and end smoothly (smoothstep), so that they ask for no leap of acceleration.
    """

    def __init__(self) -> None:
        self.now = 0.0
        self._scale = self._from = 1.0
        self._to = 1.0
        self._elapsed = self._ramp = 0.0

    @property
    def stopping(self) -> bool:
        """Whether it ramps down, or has."""
        return self._to == 0.0

    @property
    def stopped(self) -> bool:
        """Whether path time stands still for good."""
        return self.stopping and self._scale == 0.0

    def stop(self, duration: float) -> None:
        """Ramp down to a standstill in `duration` seconds."""
        self._begin(self._scale, 0.0, duration)

    def resume_from_rest(self, duration: float) -> None:
        """Start again from a standstill, at full pace after `duration` seconds."""
        self._begin(0.0, 1.0, duration)

    def halt(self) -> None:
        """Stand still for good: what moved has come to rest."""
        self._begin(0.0, 0.0, 0.0)

    def _begin(self, start: float, end: float, duration: float) -> None:
        self._scale = self._from = start
        self._to = end
        self._elapsed, self._ramp = 0.0, duration

    def advance(self, period: float) -> float:
        """Let `period` seconds pass; returns the new path time, s."""
        before = self._scale
        self._elapsed += period
        if self._elapsed >= self._ramp * _ALMOST:
            self._scale = self._to
        else:
            u = self._elapsed / self._ramp
            self._scale = self._from + (self._to - self._from) * u * u * (3.0 - 2.0 * u)
        self.now += 0.5 * (before + self._scale) * period
        return self.now


def straight_way(start: FloatArray, goal: FloatArray, arm: ArmDescription, rate: float) -> Motion:
    """Minimum-jerk motion of all joints together, as fast as the arm's limits allow.

    Parameters
    ----------
    start, goal : array, shape (n,)
        rad.
    arm : ArmDescription
    rate : float
        Samples a second.

    Returns
    -------
    Motion
        From rest to rest. It is not yet checked.

    Raises
    ------
    RefusedMotionError
        It would have more than `MOST_FRAMES` samples: the arm is too slow for it.
    """
    way = np.abs(goal - start)
    # peak speed 15/8 and peak acceleration 10/sqrt(3) of a minimum-jerk motion of unit size
    by_speed = np.max(15.0 / 8.0 * way / arm.max_velocity)
    by_acceleration = np.sqrt(np.max(10.0 / np.sqrt(3.0) * way / arm.max_acceleration))
    duration = max(_SHORTEST_WAY, _MARGIN * float(max(by_speed, by_acceleration)))
    check_length(duration, rate)
    frames = int(np.ceil(duration * rate)) + 1
    time = np.arange(frames) / rate
    angles = start + minimum_jerk(time / time[-1])[:, None] * (goal - start)
    return Motion(time=time, joint_names=arm.joint_names, angles=angles, source="straight way")


def check_length(duration: float, rate: float) -> None:
    """Refuse a way of too many samples before there is one; RefusedMotionError.

    Parameters
    ----------
    duration : float
        s.
    rate : float
        Samples a second.
    """
    if duration * rate >= MOST_FRAMES:
        raise RefusedMotionError(
            f"the way would take {duration:.3g} s, and at {rate:g} Hz {MOST_FRAMES / rate:.0f} s"
            " is the longest that is planned: move faster"
        )
