"""Judging one tick of a stream: from state, wanted command and limits to a command or a fault.

Pure functions: what they remember stands in `TickState`, and what follows from a fault is the
stream's matter. Stop the arm by letting its goals stand still, and start from rest afterwards:
`TickState.at_rest`. The same holds after a stall in which the goals stood still.
"""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import (
    ArmFaultError,
    ArmsynError,
    CollisionError,
    CommandFaultError,
    LimitError,
    ServoLoadError,
)
from armsyn.safety.command import CommandLimits, check_command, check_following

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

CURRENT_MEMORY = 0.5
"""s over which currents are averaged before they are judged: accelerating takes short ones."""

WARM = 5.0
"""Degrees Celsius below its limit at which a servo is warned of."""

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


class Verdict(NamedTuple):
    """What a tick may do: exactly one of the two is not None.

    Attributes
    ----------
    command : array, shape (n,), or None
        To be sent: the wanted one, with rounding past a joint's range taken off, rad.
    fault : ArmFaultError or None
        Why nothing may be sent.
    """

    command: FloatArray | None
    fault: ArmFaultError | None


def judge_tick(state: TickState, wanted: ArrayLike, limits: CommandLimits) -> Verdict:
    """Allow a command, or say why the arm must stop.

    Parameters
    ----------
    state : TickState
        Before the command.
    wanted : array_like, shape (n,)
        rad; may come from anybody's code.
    limits : CommandLimits

    Returns
    -------
    Verdict
        Faults are looked for in this order: FollowingError; ServoLoadError; CommandFaultError,
        with the LimitError or CollisionError that it comes of as its cause.
    """
    fault: ArmFaultError | None = check_following(
        state.commands[-1], state.measured, state.speed, state.fresh, limits
    ) or check_load(state, limits)
    if fault is not None:
        return Verdict(None, fault)
    goals = _as_posture(wanted, len(limits.names))
    if goals is None:
        return Verdict(None, _no_posture(wanted, limits))
    refusal = check_command(goals, state.commands[-1], limits) or check_rates(
        goals, state.commands, limits
    )
    if refusal is not None:
        return Verdict(None, _fault(refusal, refusal.joint, refusal.value, refusal.limit))
    command = np.minimum(np.maximum(goals, limits.lower), limits.upper)
    if limits.clearances is not None:
        collision = limits.clearances.broken_by(command)
        if collision is not None:
            return Verdict(None, _collision_fault(collision, limits.clearances.margin))
    return Verdict(command, None)


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


def check_load(state: TickState, limits: CommandLimits) -> ServoLoadError | None:
    """Whether no servo is too hot, takes too much current or has a wrong voltage.

    Parameters
    ----------
    state : TickState
    limits : CommandLimits

    Returns
    -------
    ServoLoadError or None
    """
    n = (len(limits.names),)
    for value, beyond, limit, text in (
        (
            state.temperature,
            state.temperature > limits.max_temperature,
            limits.max_temperature,
            "is {0:.0f} degrees Celsius hot, {1:.0f} are allowed: let it cool down",
        ),
        (
            state.current,
            np.abs(state.current) > limits.max_current,
            limits.max_current,
            "takes {0:.2f} A, {1:.2f} A are allowed: something holds it, or the load is too much",
        ),
        (
            state.voltage,
            state.voltage < limits.min_voltage,
            limits.min_voltage,
            "is supplied with {0:.1f} V, at least {1:.1f} V are needed: check supply and cables",
        ),
        (
            state.voltage,
            state.voltage > limits.max_voltage,
            limits.max_voltage,
            "is supplied with {0:.1f} V, at most {1:.1f} V are allowed: check the supply",
        ),
    ):
        if beyond.any():
            joint = int(np.argmax(beyond))
            found, most = float(np.broadcast_to(value, n)[joint]), float(limit[joint])
            name = limits.names[joint]
            return ServoLoadError(
                f"joint {name}: its servo {text.format(found, most)}", name, found, most
            )
    return None


def warm_joints(state: TickState, limits: CommandLimits) -> tuple[str, ...]:
    """Names of the joints whose servos are within `WARM` of too hot, or beyond."""
    warm = np.broadcast_to(state.temperature > limits.max_temperature - WARM, (len(limits.names),))
    return tuple(name for name, is_warm in zip(limits.names, warm, strict=True) if is_warm)


def averaged_current(average: FloatArray, current: FloatArray, period: float) -> FloatArray:
    """Let a moving average of currents take in new ones.

    Parameters
    ----------
    average, current : array, shape (n,)
        A; NaN where unknown. An unknown average begins with the current, and an unknown current
        leaves the average as it is.
    period : float
        Since the last one, s.

    Returns
    -------
    array, shape (n,)
        A.
    """
    share = min(period / CURRENT_MEMORY, 1.0)
    moved = np.where(np.isnan(average), current, average + share * (current - average))
    return np.where(np.isnan(current), average, moved)


def _as_posture(wanted: ArrayLike, n: int) -> FloatArray | None:
    try:
        posture = np.asarray(wanted, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return posture if posture.shape == (n,) else None


def _no_posture(wanted: ArrayLike, limits: CommandLimits) -> CommandFaultError:
    return CommandFaultError(
        f"the command is not {len(limits.names)} numbers, one a joint, but"
        f" {str(wanted)[:60]!r}: mend what commands the arm",
        limits.names[0],
        np.nan,
        np.nan,
    )


def _fault(cause: ArmsynError, joint: str, value: float, limit: float) -> CommandFaultError:
    fault = CommandFaultError(
        f"{cause}: the motion went wrong on its way and was stopped; plan it again",
        joint,
        value,
        limit,
    )
    fault.__cause__ = cause
    return fault


def _collision_fault(cause: CollisionError, margin: float) -> CommandFaultError:
    return _fault(cause, cause.first, -cause.depth, margin)
