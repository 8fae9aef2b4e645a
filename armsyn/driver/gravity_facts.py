"""What the servos say of how they give way under a load."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.arm.motors import position_stiffness
from armsyn.driver.facts import ServoFacts
from armsyn.driver.gravity import GoalLead, LeadSettings
from armsyn.driver.registers import POSITION_MODE, VOLTAGE_UNIT
from armsyn.driver.servos import ServoGroup

FloatArray = NDArray[np.float64]


def read_lead_settings(
    group: ServoGroup,
    arm: ArmDescription,
    facts: tuple[ServoFacts, ...],
    period: float,
    *,
    gravity: bool = True,
) -> LeadSettings:
    """Read what leads are worked out from.

    Parameters
    ----------
    group : ServoGroup
        Servos of the joints, shadows included.
    arm : ArmDescription
    facts : tuple of ServoFacts, length n
        Of the joints' leading servos.
    period : float
        Of the ticks, s.
    gravity : bool
        False for goals that lead by nothing.

    Returns
    -------
    LeadSettings

    Raises
    ------
    BusError, PortLostError
        As the bus.
    """
    chain, lower, upper = arm.chain, *_own_limits(arm, facts)
    return LeadSettings(
        arm=arm,
        stiffness=read_stiffness(group, arm) if gravity else np.full(len(facts), np.nan),
        lower=np.maximum(chain.lower, lower),
        upper=np.minimum(chain.upper, upper),
        period=period,
        active=gravity,
    )


def make_lead(settings: LeadSettings, facts: tuple[ServoFacts, ...], goals: list[int]) -> GoalLead:
    """Let goals lead from where they stand.

    The wanted posture begins where the arm is (at the goals, if they lead by nothing); a joint
    that is beyond its range, as on its stop, at the end of it.

    Parameters
    ----------
    settings : LeadSettings
    facts : tuple of ServoFacts, length n
        Of the joints' leading servos, as they are right before torque.
    goals : list of int, length n
        Where their goals stand, ticks.
    """
    calibration = settings.arm.calibration
    sent = calibration.to_radians(goals)
    present = calibration.to_radians([servo.present_position for servo in facts])
    wanted = np.clip(present if settings.active else sent, settings.lower, settings.upper)
    holds = np.array([servo.torque_enabled for servo in facts])
    return GoalLead(settings, wanted, sent, holds)


def _own_limits(
    arm: ArmDescription, facts: tuple[ServoFacts, ...]
) -> tuple[FloatArray, FloatArray]:
    """Range that the servos take goals in, rad: beyond it they refuse them, unheard."""
    calibration = arm.calibration
    ends = np.array(
        [
            calibration.to_radians([servo.minimum_position for servo in facts]),
            calibration.to_radians([servo.maximum_position for servo in facts]),
        ]
    )
    # half a tick inside, where rounding brings no goal out
    inside = 0.5 * np.abs(calibration.radians_per_tick)
    bounded = np.array([servo.operating_mode == POSITION_MODE for servo in facts])
    lower = np.where(bounded, ends.min(axis=0) + inside, -np.inf)
    return lower, np.where(bounded, ends.max(axis=0) - inside, np.inf)


def read_stiffness(group: ServoGroup, arm: ArmDescription) -> FloatArray:
    """Read how stiff the servos' position loops make the joints.

    Parameters
    ----------
    group : ServoGroup
        All servos of the arm; shadows add to their joint.
    arm : ArmDescription

    Returns
    -------
    array, shape (n,)
        N m/rad; inf where a servo's own integral gain holds the joint, NaN where it is not known.

    Raises
    ------
    BusError, PortLostError
        As the bus.
    """
    moving = [servo for servo in arm.servo if servo.joint in arm.joint_names]
    spoken = group.having("Goal PWM", [servo.id for servo in moving])
    proportional = group.read("Position P Gain", spoken)
    integral = group.read("Position I Gain", spoken)
    volts = group.read("Present Input Voltage", spoken)
    stiffness = dict.fromkeys(arm.joint_names, 0.0)
    for servo in moving:
        if integral.get(servo.id):
            found = float("inf")
        elif servo.id not in proportional:
            found = float("nan")
        else:
            supply = VOLTAGE_UNIT * volts[servo.id]
            gain = proportional[servo.id]
            found = position_stiffness(servo.model, servo.protocol, supply, gain)
        stiffness[servo.joint] += found
    return np.array([stiffness[name] for name in arm.joint_names])
