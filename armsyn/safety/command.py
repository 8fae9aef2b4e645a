"""The checks at each tick of a stream: the command before it is sent, the arm after it answered.

Both are pure functions of state and limits. They return the fault instead of raising it: what
a fault does to the arm is the stream's matter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import FollowingError, LimitError

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

STEP_TOLERANCE = 0.05
"""Part of a step at full speed that interpolation and blending may add."""

POSITION_TOLERANCE = 1e-6
"""rad (or m) past a joint's range that are rounding."""

FOLLOWING_AT_REST = 0.15
"""rad that an arm at rest may be off its goal (droop under load, play)."""

FOLLOWING_PER_SPEED = 0.20
"""s: rad more for each rad/s of the goal's speed, for a servo's lag."""


@dataclass(frozen=True)
class CommandLimits:
    """Limits of a stream's commands.

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
    """

    names: tuple[str, ...]
    lower: FloatArray
    upper: FloatArray
    max_step: FloatArray
    following_at_rest: float = FOLLOWING_AT_REST
    following_per_speed: float = FOLLOWING_PER_SPEED

    @classmethod
    def of(cls, arm: ArmDescription, period: float) -> Self:
        """Limits of an arm that is streamed to every `period` seconds."""
        return cls(
            names=arm.joint_names,
            lower=arm.chain.lower,
            upper=arm.chain.upper,
            max_step=arm.max_velocity * period * (1.0 + STEP_TOLERANCE),
        )


def check_command(
    wanted: FloatArray, previous: FloatArray, limits: CommandLimits
) -> LimitError | None:
    """Whether a command may be sent after the one before it.

    Parameters
    ----------
    wanted, previous : array, shape (n,)
        rad.
    limits : CommandLimits

    Returns
    -------
    LimitError or None
        The fault: not finite, outside the joint's range, or too far from the command before.
    """
    # written so that NaN fails every comparison, and so all of them
    inside = (wanted >= limits.lower - POSITION_TOLERANCE) & (
        wanted <= limits.upper + POSITION_TOLERANCE
    )
    near = np.abs(wanted - previous) <= limits.max_step
    allowed = inside & near
    if allowed.all():
        return None
    joint = int(np.argmin(allowed))
    name, value = limits.names[joint], float(wanted[joint])
    if not np.isfinite(value):
        return LimitError(f"joint {name}: the command is {value}", name, value, np.inf)
    if not inside[joint]:
        limit = float((limits.lower if value < limits.lower[joint] else limits.upper)[joint])
        return LimitError(
            f"joint {name}: the command {value:.3f} rad is outside its limit {limit:.3f} rad",
            name,
            value,
            limit,
        )
    step, limit = abs(value - float(previous[joint])), float(limits.max_step[joint])
    return LimitError(
        f"joint {name}: the command jumps by {step:.4f} rad, {limit:.4f} rad are allowed a tick",
        name,
        step,
        limit,
    )


def check_following(
    commanded: FloatArray,
    measured: FloatArray,
    speed: FloatArray,
    fresh: BoolArray,
    limits: CommandLimits,
) -> FollowingError | None:
    """Whether the arm is where its goals say, as far as its speed allows.

    The allowed error grows with speed, as LinuxCNC's ``ferror`` does: a servo lags behind a
    moving goal without anything being wrong.

    Parameters
    ----------
    commanded, measured : array, shape (n,)
        rad.
    speed : array, shape (n,)
        Of the goals, of late, rad/s, not negative.
    fresh : array of bool, shape (n,)
        Which of `measured` are new; the others are not judged.
    limits : CommandLimits

    Returns
    -------
    FollowingError or None
    """
    error = measured - commanded
    allowed = limits.following_at_rest + limits.following_per_speed * speed
    excess = np.where(fresh, np.abs(error) - allowed, -np.inf)
    joint = int(np.argmax(excess))
    if not excess[joint] > 0.0:
        return None
    name = limits.names[joint]
    return FollowingError(
        f"joint {name} is {error[joint]:+.3f} rad off its goal, {allowed[joint]:.3f} rad are"
        " allowed: something holds it, or it is overloaded",
        name,
        float(error[joint]),
    )
