"""The limits of a stream: of its commands, and of what the servos may report meanwhile."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.safety.collision import TICK_MARGIN, Clearances

FloatArray = NDArray[np.float64]

STEP_TOLERANCE = 0.05
"""Part of a step at full speed that interpolation and blending may add."""

ACCELERATION_SPARE = 2.0
"""Times its limit that a command's acceleration may be. A plan keeps the limit at its samples; in
between, cubics come to 1.9 times it at 1000 Hz, and decelerating for a stop adds a half."""

JERK_SPARE = 1.5
"""Times its limit that a command's jerk may be; or times the acceleration limit a tick, where that
is more, as the acceleration of a plan's cubics steps at its samples (up to 1.3 times it)."""

BLEND_ACCELERATION, BLEND_JERK = 5.0, 200.0
"""rad/s2 and rad/s3 that blending 0.05 rad into a motion within 0.25 s adds (minimum jerk: Flash
and Hogan, 1985), whatever the limits of the arm."""

POSITION_TOLERANCE = 1e-6
"""rad (or m) past a joint's range that are rounding."""

FOLLOWING_AT_REST = 0.15
"""rad that an arm at rest may be off its goal (droop under load, play)."""

FOLLOWING_PER_SPEED = 0.20
"""s: rad more for each rad/s of the goal's speed, for a servo's lag."""


def _unknown() -> FloatArray:
    return np.array(np.nan)


def _known(limit: FloatArray) -> FloatArray:
    """Put what every finite number keeps in the place of what is unknown, and add rounding."""
    return np.asarray(np.where(np.isnan(limit), np.finfo(np.float64).max, limit + _ROUNDING))


_ROUNDING = 1e-12
"""rad that differences of commands are off by rounding."""

_OPTIONAL = (
    "max_acceleration",
    "max_jerk",
    "max_temperature",
    "max_current",
    "min_voltage",
    "max_voltage",
)


@dataclass(frozen=True)
class CommandLimits:
    """Limits of a stream: of its commands, and of what the servos may report meanwhile.

    Limits that are NaN are unknown: they are not judged. Those of servos are usually their own
    registers'; ``dataclasses.replace(limits, max_temperature=...)`` puts them in.

    Parameters
    ----------
    names : tuple of str, length n
        Joints.
    lower, upper : array, shape (n,)
        Range, rad.
    max_step : array, shape (n,)
        Greatest change from one tick to the next, rad.
    following_at_rest : float
        Greatest following error of a joint whose goal stands still, rad.
    following_per_speed : float
        What each rad/s of the goal's speed adds to it, s.
    period : float
        Of the ticks, s; accelerations and jerks need it.
    max_acceleration, max_jerk : array, shape (n,)
        Of the commands, rad/s2 and rad/s3.
    max_temperature, max_current, min_voltage, max_voltage : array, shape (n,)
        Of the joints' servos, degrees Celsius, A (either sign) and V.
    clearances : Clearances or None
        What commanded postures must keep; None for no look at collisions.

    Attributes
    ----------
    max_bend, max_twist : array, shape (n,)
        The same as `max_acceleration` and `max_jerk`, as second and third differences of
        commands, rad; not NaN.
    """

    names: tuple[str, ...]
    lower: FloatArray
    upper: FloatArray
    max_step: FloatArray
    following_at_rest: float = FOLLOWING_AT_REST
    following_per_speed: float = FOLLOWING_PER_SPEED
    period: float = np.nan
    max_acceleration: FloatArray = field(default_factory=_unknown)
    max_jerk: FloatArray = field(default_factory=_unknown)
    max_temperature: FloatArray = field(default_factory=_unknown)
    max_current: FloatArray = field(default_factory=_unknown)
    min_voltage: FloatArray = field(default_factory=_unknown)
    max_voltage: FloatArray = field(default_factory=_unknown)
    clearances: Clearances | None = None
    max_bend: FloatArray = field(init=False, repr=False)
    max_twist: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for name in _OPTIONAL:
            value = np.asarray(getattr(self, name), dtype=np.float64)
            object.__setattr__(self, name, np.broadcast_to(value, (len(self.names),)))
        object.__setattr__(self, "max_bend", _known(self.max_acceleration * self.period**2))
        object.__setattr__(self, "max_twist", _known(self.max_jerk * self.period**3))

    @classmethod
    def of(cls, arm: ArmDescription, period: float, start: ArrayLike | None = None) -> Self:
        """Limits of an arm that is streamed to.

        Parameters
        ----------
        arm : ArmDescription
        period : float
            Of the ticks, s.
        start : array_like, shape (n,) or (m, n), optional
            Where the goals stand, and where the arm does, rad: a contact there may last, see
            `Clearances`.

        Returns
        -------
        CommandLimits
            Those of the servos are unknown.

        Raises
        ------
        InputError
            Shapes that touch at rest, or a posture of another arm.
        """
        acceleration = arm.max_acceleration
        jerk = np.maximum(arm.max_jerk, acceleration / period)
        return cls(
            names=arm.joint_names,
            lower=arm.chain.lower,
            upper=arm.chain.upper,
            max_step=arm.max_velocity * period * (1.0 + STEP_TOLERANCE),
            period=period,
            max_acceleration=ACCELERATION_SPARE * acceleration + BLEND_ACCELERATION,
            max_jerk=JERK_SPARE * jerk + BLEND_JERK,
            clearances=Clearances.of(arm, TICK_MARGIN, start),
        )
