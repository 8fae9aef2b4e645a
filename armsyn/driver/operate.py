"""Letting an arm go, and clearing what a fault left: for people who stand beside it.

Both work with some servos missing or faulty: that is when they are needed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armsyn.arm import ArmDescription
from armsyn.arm.gravity import gravity_torque
from armsyn.driver import power
from armsyn.driver import registers as reg
from armsyn.driver.presence import hardware_error
from armsyn.driver.servos import ServoGroup
from armsyn.errors import BusTimeoutError, HardwareFaultError, InputError

FALLING_TORQUE = 0.05
"""N m of weight from which on a joint is said to fall: about what gears hold by friction."""

RELEASE_ATTEMPTS = 3


@dataclass(frozen=True)
class Load:
    """What a joint carries.

    Attributes
    ----------
    joint : str
    torque : float
        Size of what its motor holds against the arm's weight, N m.
    """

    joint: str
    torque: float


@dataclass(frozen=True)
class Released:
    """What was let go.

    Attributes
    ----------
    let_go, limp : tuple of int
        IDs of the servos whose torque went off, and of those where it was off already.
    """

    let_go: tuple[int, ...]
    limp: tuple[int, ...]


@dataclass(frozen=True)
class Latched:
    """What a fault left behind.

    Attributes
    ----------
    armed, expired : tuple of int
        IDs of the servos whose bus watchdog is armed, and whom it has stopped.
    errors : dict of int to int
        ID to hardware error (X series' bits): no clearing ends them, only a reboot does.
    """

    armed: tuple[int, ...]
    expired: tuple[int, ...]
    errors: dict[int, int]

    @property
    def watchdogs(self) -> bool:
        """Whether there is anything to clear."""
        return bool(self.armed or self.expired)


def what_falls(
    arm: ArmDescription, angles: ArrayLike, joints: Collection[str] | None = None
) -> tuple[Load, ...] | None:
    """Joints that the arm's weight turns when they are let go.

    Parameters
    ----------
    arm : ArmDescription
    angles : array_like, shape (n,)
        Where the arm is, rad; NaN where that is not known.
    joints : collection of str, optional
        That are to be let go; all by default.

    Returns
    -------
    tuple of Load or None
        The heaviest first; None where nobody can say: no masses, or an unknown angle.
    """
    try:
        torques = gravity_torque(arm, angles)
    except InputError:
        return None
    carried = [
        Load(name, float(abs(torque)))
        for name, torque in zip(arm.joint_names, torques, strict=True)
        if abs(torque) > FALLING_TORQUE and (joints is None or name in joints)
    ]
    return tuple(sorted(carried, key=lambda load: -load.torque))


def torque_is_on(group: ServoGroup) -> dict[int, bool]:
    """Whether each servo's torque is on; a servo that does not say counts as on."""
    on = dict.fromkeys(group.ids, True)
    for servo_id in group.ids:
        try:
            on |= {i: bool(value) for i, value in group.read("Torque Enable", (servo_id,)).items()}
        except BusTimeoutError:
            continue
    return on


def release(group: ServoGroup, joints: Iterable[str] | None = None) -> Released:
    """Switch torque off. What is raised falls: ask the people beside it first (`what_falls`).

    Parameters
    ----------
    group : ServoGroup
        Of the servos that are there.
    joints : iterable of str, optional
        Only those of these joints, or of the gripper; both servos of a dual joint.

    Returns
    -------
    Released

    Raises
    ------
    HardwareFaultError
        A servo that does not let go; all others have.
    PortLostError
        The port went away.
    """
    names = None if joints is None else set(joints)
    chosen = group.only(s for s in group.servos if names is None or s.joint in names)
    before = torque_is_on(chosen)
    left = [servo_id for servo_id, on in before.items() if on]
    for _ in range(RELEASE_ATTEMPTS):
        if not left:
            break
        chosen.write("Torque Enable", dict.fromkeys(left, 0))
        after = torque_is_on(chosen)
        left = [servo_id for servo_id in left if after[servo_id]]
    if left:
        named = ", ".join(chosen.title(servo_id) for servo_id in left)
        raise HardwareFaultError(
            f"{named} did not let go, all others have: support the arm and switch its supply off",
            left[0],
        )
    return Released(
        tuple(i for i, on in before.items() if on), tuple(i for i, on in before.items() if not on)
    )


def read_latched(group: ServoGroup) -> Latched:
    """Read what a fault left behind; errors as `ServoGroup.read`."""
    watchdogs = group.read("Bus Watchdog")
    errors = {
        servo_id: error for servo_id in group.ids if (error := hardware_error(group, servo_id))
    }
    return Latched(
        armed=tuple(i for i, value in watchdogs.items() if value > 0),
        expired=tuple(i for i, value in watchdogs.items() if value == reg.WATCHDOG_EXPIRED),
        errors=errors,
    )


def clear(group: ServoGroup) -> tuple[int, ...]:
    """Switch off bus watchdogs that a fault left; servos they have stopped hold where they are.

    This is the operator's word that the arm may move again. Nothing moves by it: the goal of a
    servo under torque becomes what it is held at, not where its load lets it be.

    Returns
    -------
    tuple of int
        IDs of the servos whose watchdog was armed or had expired.

    Raises
    ------
    HardwareFaultError
        A watchdog that stays on, or a stopped servo that does not take its goal.
    BusError, PortLostError
        As the bus.
    """
    return power.release_watchdogs(group)


def posture_of(arm: ArmDescription, group: ServoGroup) -> np.ndarray:
    """Angles of the joints, shape (n,), rad; NaN of those whose servo does not answer."""
    ticks: dict[int, int] = {}
    for servo in arm.leaders:
        if servo.id in group.ids:
            try:
                ticks |= group.read("Present Position", (servo.id,))
            except BusTimeoutError:
                continue
    known = np.array([servo.id in ticks for servo in arm.leaders])
    angles = arm.calibration.to_radians([ticks.get(servo.id, 0) for servo in arm.leaders])
    return np.where(known, angles, np.nan)
