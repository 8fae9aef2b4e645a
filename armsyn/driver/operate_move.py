"""Small motions that an operator asks for: one joint by a little, and the way to rest.

Both go through `ArmSession.run`, with all its checks, watchdogs and endings.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.driver.operate import torque_is_on
from armsyn.driver.path import check_length, straight_way
from armsyn.driver.recording import Recording
from armsyn.driver.run import PARK_TOLERANCE
from armsyn.driver.servos import ServoGroup
from armsyn.driver.session import ArmSession
from armsyn.driver.stillness import still_posture
from armsyn.driver.stream import OnTick
from armsyn.errors import InputError, LimitError, meant
from armsyn.safety.limits import POSITION_TOLERANCE

FloatArray = NDArray[np.float64]

LARGEST_JOG = math.radians(45.0)
"""What is a little."""


def jog(
    session: ArmSession, joint: str, change: float, speed: float, on_tick: OnTick | None = None
) -> Recording:
    """Move one joint; all others hold, and so does it at the end.

    Parameters
    ----------
    session : ArmSession
    joint : str
    change : float
        rad, in the joint's positive direction; at most `LARGEST_JOG` in size.
    speed : float
        rad/s, that the joint does not exceed; nor does it exceed its own limit.
    on_tick : callable, optional
        As of `ArmSession.run`.

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        No such joint, too large a change, or an impossible speed.
    RefusedMotionError
        The joint would leave its range, the arm would collide, or it would take too long; nothing
        has changed.
    ArmFaultError, StopRequestedError
        As `ArmSession.run`.
    """
    arm = session.arm
    row = joint_row(arm, joint)
    if not 0.0 < abs(change) <= LARGEST_JOG:
        raise InputError(
            f"a jog is by up to {math.degrees(LARGEST_JOG):.0f} degrees, got"
            f" {math.degrees(change):g}: use armsyn reach or stream for more"
        )
    if not (math.isfinite(speed) and speed > 0.0):
        raise InputError(f"a speed is above 0, got {math.degrees(speed):g} degrees/s")
    check_length(abs(change) / speed, session.rate_hz)
    start = still_posture(session, session.clock)
    goal = start.copy()
    goal[row] += change
    _check_room(arm, start, goal)
    slow = arm.slowed(max(1.0, float(arm.max_velocity[row]) / speed))
    return session.run(straight_way(start, goal, slow, session.rate_hz), on_tick=on_tick)


def joint_row(arm: ArmDescription, joint: str) -> int:
    """Return which of an arm's joints one is; InputError where it is none of them."""
    if joint not in arm.joint_names:
        names = ", ".join(arm.joint_names)
        raise InputError(
            f"{arm.name} has no joint {joint!r}; it has {names}{meant(joint, arm.joint_names)}"
        )
    return arm.joint_names.index(joint)


def _check_room(arm: ArmDescription, start: FloatArray, goal: FloatArray) -> None:
    """Say in degrees what keeps a jog from its goal: a range that it leaves, or has left."""
    for row, joint in enumerate(arm.joint_names):
        ends = (float(arm.chain.lower[row]), float(arm.chain.upper[row]))
        here, there = float(start[row]), float(goal[row])
        for value, moves in ((here, False), (there, True)):
            if ends[0] - POSITION_TOLERANCE <= value <= ends[1] + POSITION_TOLERANCE:
                continue
            end = ends[0] if value < ends[0] else ends[1]
            at, limit = math.degrees(here), math.degrees(end)
            text = f"joint {joint} is at {at:.2f} degrees, its limit is {limit:.2f}: "
            if moves:
                text += f"{abs(limit - at):.2f} degrees are left that way"
            else:
                text += f"it is {abs(at - limit):.2f} degrees beyond: move it back by hand, limp"
            raise LimitError(text, joint, value, end)


def is_parked(session: ArmSession) -> bool:
    """Whether the arm is at rest already, within what parking allows, and limp."""
    arm = session.arm
    if np.abs(still_posture(session, session.clock) - arm.rest).max() > PARK_TOLERANCE:
        return False
    return not any(torque_is_on(ServoGroup(session.bus, (*arm.leaders, *arm.shadows))).values())


def park(session: ArmSession, on_tick: OnTick | None = None) -> Recording:
    """Go straight to the rest posture, and switch the torque off there if the arm got there.

    Parameters
    ----------
    session : ArmSession
        Its arm's speed limits bound the way.
    on_tick : callable, optional
        As of `ArmSession.run`.

    Returns
    -------
    Recording
        Its ending says whether the torque went off: `Ending.PARKED`; `Ending.PARK_MISSED` for
        an arm that something keeps from rest: it holds.

    Raises
    ------
    RefusedMotionError
        The straight way leaves a range or collides; nothing has changed.
    ArmFaultError, StopRequestedError
        As `ArmSession.run`.
    """
    arm, rate = session.arm, session.rate_hz
    way = straight_way(still_posture(session, session.clock), arm.rest, arm, rate)
    stay = straight_way(arm.rest, arm.rest, arm, rate)
    return session.run(way, stay, on_tick)
