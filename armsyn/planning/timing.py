"""From angles over normalised time to samples that an arm can follow: eased, slowed, resampled.

A captured reach is cut at 5 % of its peak speed, so it starts and ends in motion. An arm rests
before and after: the phase sets off and comes to rest by minimum-jerk ramps, as long as what the
cut takes off a minimum-jerk reach. Then the whole is slowed by kappa until every joint's limits
hold; the angles over phase, and so the path, stay as they are.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import LimitError
from armsyn.kernels.pacing import LEAST_SCALING, LONGEST_S, MOST_SCALINGS
from armsyn.safety.trajectory import JERK_SPAN

FloatArray = NDArray[np.float64]

MARGIN = 1.02
"""The trajectory keeps this factor inside the limits."""

CUT_SPEED = 0.05
"""Share of the peak speed at which captured reaches are cut."""

CUT_TIME = 0.5 * (1.0 / 0.88113 - 1.0)
"""What that cut takes off a minimum-jerk reach on either side, as a share of what it leaves: 5 % of
its peak speed is passed at 5.94 % of its time (Flash and Hogan, 1985, eq. 6)."""

SHORTEST_S = 0.02
"""No reach is taken to be shorter."""


class Timed(NamedTuple):
    """A motion sampled for an arm.

    Attributes
    ----------
    angles : array, shape (frames, n)
        rad or m; the arm rests before the first and after the last.
    time_scale : float
        kappa, at least 1.
    """

    angles: FloatArray
    time_scale: float


class PhasePath:
    """A motion over phase, as a cubic spline through its samples.

    Parameters
    ----------
    angles : array, shape (phases, n)
        rad or m, at equal steps of phase from 0 to 1; at least 4.
    """

    def __init__(self, angles: FloatArray) -> None:
        self._steps = angles.shape[0] - 1
        self._angles = angles
        bend = _second_derivatives(angles.shape[0]) @ angles / 6.0
        self._bend = bend
        step = np.diff(angles, axis=0)
        slope = np.concatenate([step - 2.0 * bend[:-1] - bend[1:], np.zeros_like(bend[:1])])
        slope[-1] = step[-1] + bend[-2] + 2.0 * bend[-1]
        self._slope = slope

    def at(self, phase: FloatArray) -> FloatArray:
        """Return the angles at phases from 0 to 1, shape (m,) to (m, n)."""
        place = phase * self._steps
        row = np.minimum(place.astype(np.int64), self._steps - 1)
        x = (place - row)[:, None]
        bend = self._bend[row]
        grown = self._bend[row + 1] - bend
        angles: FloatArray = self._angles[row] + x * (
            self._slope[row] + x * (3.0 * bend + x * grown)
        )
        angles[phase >= 1.0] = self._angles[-1]
        return angles

    def ramps(self) -> tuple[float, float]:
        """Lengths of the ramps at start and end, as shares of the motion's own time.

        They are those of the cut where the joints move by 5 % of their greatest speed or more,
        and shorter where the motion is nearer to rest.
        """
        speeds = np.linalg.norm(self._slope, axis=1)
        peak = float(speeds.max())
        if peak == 0.0:
            return 0.0, 0.0
        shares = np.minimum(speeds[[0, -1]] / (CUT_SPEED * peak), 1.0)
        start, end = 2.0 * CUT_TIME * shares
        return float(start), float(end)


def in_time(angles: FloatArray, duration: float, arm: ArmDescription, rate_hz: float) -> Timed:
    """Sample a motion at a rate, as slow as the arm needs it.

    Parameters
    ----------
    angles : array, shape (phases, n)
        At equal steps of phase, rad or m.
    duration : float
        s from the first to the last, as a person moves.
    arm : ArmDescription
    rate_hz : float

    Returns
    -------
    Timed

    Raises
    ------
    LimitError
        A joint's speed, acceleration or jerk would not hold however slow, or only over an hour.
    """
    path, scale = PhasePath(angles), 1.0
    start, end = path.ramps()
    duration = max(duration, SHORTEST_S)
    limits, worst = Rates.of(arm), 0
    for _ in range(MOST_SCALINGS):
        time = (1.0 + 0.5 * (start + end)) * duration * scale
        if not time < LONGEST_S:
            raise too_long(arm, worst, time)
        frames = int(np.ceil(time * rate_hz)) + 1
        sampled = path.at(phases(frames, start, end))
        excess = limits.excess(sampled, rate_hz)
        worst = int(excess.argmax())
        if excess[worst] <= 1.0:
            return Timed(sampled, scale)
        scale *= max(float(excess[worst]), LEAST_SCALING)
    raise too_fast(arm, worst, float(excess[worst]), scale)


def phases(frames: int, start: float, end: float) -> FloatArray:
    """Phase at equal steps of time, eased in and out.

    Parameters
    ----------
    frames : int
        At least 2.
    start, end : float
        Ramps as shares of the time that the motion takes without them.

    Returns
    -------
    array, shape (frames,)
        From 0 to 1, never falling.
    """
    whole = 1.0 + 0.5 * (start + end)
    time = np.linspace(0.0, whole, frames)
    phase = time - 0.5 * start
    for ramp, at in ((start, time), (end, whole - time)):
        if ramp > 0.0:
            inside = at < ramp
            x = at[inside] / ramp
            gone = ramp * x**4 * (2.5 + x * (x - 3.0))
            phase[inside] = gone if at is time else 1.0 - gone
    phase[0], phase[-1] = 0.0, 1.0
    return np.clip(phase, 0.0, 1.0)


class Rates(NamedTuple):
    """What an arm's joints may do, each of shape (n,), in rad (or m) and s."""

    velocity: FloatArray
    acceleration: FloatArray
    jerk: FloatArray

    @classmethod
    def of(cls, arm: ArmDescription) -> Rates:
        """Limits of an arm, less `MARGIN`."""
        return cls(
            arm.max_velocity / MARGIN, arm.max_acceleration / MARGIN**2, arm.max_jerk / MARGIN**3
        )

    def excess(self, angles: FloatArray, rate_hz: float) -> FloatArray:
        """By how much each joint would have to be slowed, shape (n,); at most 1 within limits.

        Parameters
        ----------
        angles : array, shape (frames, n)
            rad or m; at rest before and after.
        rate_hz : float
        """
        span = max(1, round(JERK_SPAN * rate_hz))
        resting = np.concatenate([angles[:1]] * (span + 1) + [angles] + [angles[-1:]] * (span + 1))
        velocity = np.diff(resting, axis=0)
        acceleration = np.diff(velocity, axis=0)
        jerk = acceleration[span:] - acceleration[:-span]
        speed, strain, jolt = (
            np.abs(rates).max(axis=0) for rates in (velocity, acceleration, jerk)
        )
        needed = [
            speed * rate_hz / self.velocity,
            np.sqrt(strain * rate_hz**2 / self.acceleration),
            np.cbrt(jolt * rate_hz**3 / span / self.jerk),
        ]
        return np.asarray(np.max(needed, axis=0))


def too_fast(arm: ArmDescription, joint: int, excess: float, scale: float) -> LimitError:
    """Return the refusal of a motion that no slowing brings within a joint's limits."""
    name = arm.joint_names[joint]
    return LimitError(
        f"slowed {scale:.0f} times the reach still asks {excess:.2f} times what {name} may do in"
        " speed, acceleration or jerk: choose another target, --ik or --plan",
        name,
        excess,
        1.0,
    )


def too_long(arm: ArmDescription, joint: int, time: float) -> LimitError:
    """Return the refusal of a motion that would take hours for a joint to keep its limits."""
    name = arm.joint_names[joint]
    return LimitError(
        f"the reach would take {time:.0f} s, more than an hour, for {name} to keep its limits of"
        " speed, acceleration and jerk: allow it more (by a smaller --slower), or choose another"
        " target",
        name,
        time,
        LONGEST_S,
    )


@cache
def _second_derivatives(count: int) -> FloatArray:
    """Matrix from samples to second derivatives (steps of 1) of a not-a-knot cubic spline.

    Inner rows: m[k-1] + 4 m[k] + m[k+1] = 6 (y[k-1] - 2 y[k] + y[k+1]); at the ends the third
    derivative does not step (de Boor, *A Practical Guide to Splines*, 1978, chapter IV).
    """
    left, right = np.zeros((count, count)), np.zeros((count, count))
    for k in range(1, count - 1):
        left[k, k - 1 : k + 2] = 1.0, 4.0, 1.0
        right[k, k - 1 : k + 2] = 6.0, -12.0, 6.0
    left[0, :3] = left[-1, -3:] = 1.0, -2.0, 1.0
    return np.asarray(np.linalg.solve(left, right))
