"""The checks of a command before it is sent, and of the arm after it answered.

Pure functions of state and limits. They return the fault instead of raising it: what a fault does
to the arm is the stream's matter.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import FollowingError, LimitError
from armsyn.safety.limits import POSITION_TOLERANCE, CommandLimits

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


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


def check_rates(
    wanted: FloatArray, commands: FloatArray, limits: CommandLimits
) -> LimitError | None:
    """Whether acceleration and jerk of a command are within limits, after three others.

    Parameters
    ----------
    wanted : array, shape (n,)
        rad.
    commands : array, shape (3, n)
        Those before it, a period apart, oldest first, rad.
    limits : CommandLimits

    Returns
    -------
    LimitError or None
        Of the first joint beyond a limit: by second and third differences of the commands over
        the period's square and cube. Values that are not finite are beyond.
    """
    oldest, older, last = commands
    step = last - older
    bend = wanted - last - step
    twist = bend - step + (older - oldest)
    # NaN is not within anything
    gentle, smooth = np.abs(bend) <= limits.max_bend, np.abs(twist) <= limits.max_twist
    if gentle.all() and smooth.all():
        return None
    if not gentle.all():
        joint, change, power = int(np.argmin(gentle)), bend, 2
        limit, what = limits.max_acceleration, "an acceleration of {:.1f} rad/s2"
    else:
        joint, change, power = int(np.argmin(smooth)), twist, 3
        limit, what = limits.max_jerk, "a jerk of {:.0f} rad/s3"
    value = abs(float(change[joint])) / limits.period**power
    return LimitError(
        f"joint {limits.names[joint]}: the command asks for {what.format(value)},"
        f" {limit[joint]:.0f} are allowed",
        limits.names[joint],
        value,
        float(limit[joint]),
    )


def check_commands(
    commands: FloatArray,
    limits: CommandLimits,
    *,
    before: FloatArray | None = None,
    rests: bool = True,
) -> tuple[int, LimitError] | None:
    """Whether a stream of commands will pass `check_command` and `check_rates`.

    Parameters
    ----------
    commands : array, shape (m, n), m > 0
        A period apart, rad.
    limits : CommandLimits
    before : array, shape (3, n), optional
        Those before them; without them, the first is where the goals have stood.
    rests : bool
        Whether the goals stand where the last is afterwards.

    Returns
    -------
    tuple of int and LimitError, or None
        The first row that will not, and why; rows from m on are of the rest afterwards.
    """
    before = np.repeat(commands[:1], 3, axis=0) if before is None else before
    rows = np.concatenate([before, commands, np.repeat(commands[-1:], 3 * rests, axis=0)])
    step, bend, twist = (np.diff(rows, order, axis=0)[3 - order :] for order in (1, 2, 3))
    allowed = (
        (rows[3:] >= limits.lower - POSITION_TOLERANCE)
        & (rows[3:] <= limits.upper + POSITION_TOLERANCE)
        & (np.abs(step) <= limits.max_step)
        & (np.abs(bend) <= limits.max_bend)
        & (np.abs(twist) <= limits.max_twist)
    ).all(axis=1)
    for row in np.flatnonzero(~allowed).tolist():
        wanted, before = rows[row + 3], rows[row : row + 3]
        refusal = check_command(wanted, before[-1], limits) or check_rates(wanted, before, limits)
        if refusal is not None:
            return row, refusal
    return None


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
    near = (np.abs(error) <= allowed) | ~fresh  # NaN is not near
    if near.all():
        return None
    joint = int(np.argmax(np.where(near, -np.inf, np.abs(error) - allowed)))
    name = limits.names[joint]
    return FollowingError(
        f"joint {name} is {error[joint]:+.3f} rad off its goal, {allowed[joint]:.3f} rad are"
        " allowed: something holds it, or it is overloaded",
        name,
        float(error[joint]),
    )
