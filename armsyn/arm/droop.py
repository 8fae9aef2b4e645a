"""How far an arm sags under its own weight where nothing is done about it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm.description import ArmDescription
from armsyn.arm.gravity import gravity_torque
from armsyn.arm.motors import position_stiffness

FloatArray = NDArray[np.float64]

_SWEEPS = 6


class WorstLoad(NamedTuple):
    """The posture in which an arm's weight bears most on one joint.

    Attributes
    ----------
    torque : float
        That the joint's motors must give there, N m (N for a prismatic joint).
    posture : array, shape (n,)
        Within the limits; whether links touch there is not looked at.
    """

    torque: float
    posture: FloatArray


def worst_loads(arm: ArmDescription) -> tuple[WorstLoad, ...]:
    """For each joint the greatest torque that the arm's weight asks of it.

    Turning one joint changes the torque at any joint as a sine, so its greatest value over one
    joint's range is known from three postures; joints are taken in turn until nothing grows, from
    the rest posture, the middle and both ends of the ranges. That is a search: it may miss the
    greatest one of a contorted arm by a little.

    Parameters
    ----------
    arm : ArmDescription
        Every joint with its link.

    Returns
    -------
    tuple of WorstLoad
        One a joint, base to tip.

    Raises
    ------
    InputError
        A joint without mass.
    """
    lower, upper = arm.chain.lower, arm.chain.upper
    starts = (arm.rest, 0.5 * (lower + upper), lower, upper)
    return tuple(
        max((_climb(arm, joint, start) for start in starts), key=lambda load: abs(load.torque))
        for joint in range(arm.chain.dof)
    )


def stiffness(arm: ArmDescription) -> FloatArray:
    """Stiffness of each joint with its servos' initial gains at their declared voltages.

    Servos that share a joint add up.

    Parameters
    ----------
    arm : ArmDescription

    Returns
    -------
    array, shape (n,)
        N m/rad; NaN where a servo's loop is not known, or a joint has no servo.
    """
    found = dict.fromkeys(arm.joint_names, 0.0 if arm.servo else np.nan)
    for servo in arm.servo:
        if servo.joint in found:
            found[servo.joint] += position_stiffness(
                servo.model, servo.protocol, servo.supply_voltage
            )
    return np.array([found[name] for name in arm.joint_names])


def expected_droop(arm: ArmDescription) -> FloatArray:
    """How far each joint sags at its worst load, with its servos' initial gains.

    Parameters
    ----------
    arm : ArmDescription

    Returns
    -------
    array, shape (n,)
        rad, not negative: `worst_loads` over `stiffness`; NaN where the stiffness is not known.

    Raises
    ------
    InputError
        A joint without mass.
    """
    torques = np.array([abs(load.torque) for load in worst_loads(arm)])
    return torques / stiffness(arm)


def hand_droop(arm: ArmDescription, posture: FloatArray) -> float:
    """How far the hand sags in a posture, with the servos' initial gains.

    Parameters
    ----------
    arm : ArmDescription
    posture : array, shape (n,)
        rad.

    Returns
    -------
    float
        m, by the Jacobian; NaN where a joint's stiffness is not known.

    Raises
    ------
    InputError
        A joint without mass.
    """
    sagging = gravity_torque(arm, posture) / stiffness(arm)
    return float(np.linalg.norm(arm.chain.jacobian(posture) @ sagging))


def _climb(arm: ArmDescription, joint: int, start: FloatArray) -> WorstLoad:
    q = start.copy()
    torque = 0.0
    for _ in range(_SWEEPS):
        before = abs(torque)
        for turned in range(arm.chain.dof):
            q[turned], torque = _best(arm, joint, q, turned)
        if abs(torque) <= before * (1.0 + 1e-9):
            break
    return WorstLoad(torque, q)


def _best(arm: ArmDescription, joint: int, q: FloatArray, turned: int) -> tuple[float, float]:
    """Value of one joint within its range at which the torque at `joint` is greatest, and it."""
    low, high = float(arm.chain.lower[turned]), float(arm.chain.upper[turned])

    def torque(value: float) -> float:
        at = q.copy()
        at[turned] = value
        return float(gravity_torque(arm, at)[joint])

    # What is there comes first: the first of the greatest wins, so that what does not matter stays
    values = np.array([q[turned], low, high])
    if arm.joint[turned].kind == "revolute":
        none, quarter, half = torque(0.0), torque(0.5 * np.pi), torque(np.pi)
        mean = 0.5 * (none + half)
        peaks = np.arctan2(quarter - mean, none - mean) + np.pi * np.arange(-4, 5)
        values = np.concatenate([values, peaks[(low < peaks) & (peaks < high)]])
        torques = mean + (none - mean) * np.cos(values) + (quarter - mean) * np.sin(values)
    else:
        torques = np.array([torque(value) for value in values])
    best = int(np.argmax(np.abs(torques) > np.abs(torques).max() - 1e-12))
    return float(values[best]), float(torques[best])
