"""Judging one tick of a stream: from state, wanted command and limits to a command or a fault.

Pure functions: what they remember stands in `TickState`, and what follows from a fault is the
stream's matter. Stop the arm by letting its goals stand still, and start from rest afterwards:
`TickState.at_rest`. The same holds after a stall in which the goals stood still.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import (
    ArmFaultError,
    ArmsynError,
    CollisionError,
    CommandFaultError,
)
from armsyn.safety.command import check_command, check_following, check_rates
from armsyn.safety.limits import CommandLimits
from armsyn.safety.load import check_load
from armsyn.safety.state import TickState

FloatArray = NDArray[np.float64]


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
