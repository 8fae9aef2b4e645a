"""Torque, watchdog and profiles: brought up before a motion, and put back when it fails.

Everything is written by sync write and verified by reading back, which works at Status Return
Level 1 as well as 2.
"""

from __future__ import annotations

import contextlib

from armsyn.driver import registers as reg
from armsyn.driver.facts import ServoFacts
from armsyn.driver.timing import WATCHDOG_UNITS
from armsyn.driver.transactions import Bus
from armsyn.errors import ArmFaultError, HardwareFaultError

RESTORE_ATTEMPTS = 3
"""How often what was found is written back before a servo is given up."""

GOAL_TOLERANCE_TICKS = 64
"""How far a servo under torque may be from its goal (5.6 degrees) for a motion to begin."""


def power_up(bus: Bus, facts: tuple[ServoFacts, ...]) -> None:
    """Give torque without a jerk: goal := present, verified, then torque on, verified.

    A servo that holds already keeps its goal, so that a raised arm does not dip. Profiles are
    set to 0 (no profile, in the velocity-based and the time-based drive mode alike): goals
    are streamed and checked one by one. `restore_profiles` puts them back after a run that ends
    well; after a fault they stay 0. The watchdog is armed before the torque.

    Parameters
    ----------
    bus : Bus
    facts : tuple of ServoFacts
        As read just now.

    Raises
    ------
    HardwareFaultError
        A servo does not take its goal, torque or watchdog, or is away from the goal it holds.
    BusError, PortLostError
        As the bus.
    """
    for servo in facts:
        off = abs(servo.goal_position - servo.present_position)
        if servo.torque_enabled and off > GOAL_TOLERANCE_TICKS:
            raise HardwareFaultError(
                f"{servo.title} is under torque and {off} ticks from its goal: it is moving or"
                " held by something; wait, or free it",
                servo.servo_id,
            )
    limp = [servo for servo in facts if not servo.torque_enabled]
    _set(bus, facts, reg.PROFILE_VELOCITY, 0)
    _set(bus, facts, reg.PROFILE_ACCELERATION, 0)
    _set_each(bus, reg.GOAL_POSITION, {s.servo_id: s.present_position for s in limp}, facts)
    _set(bus, facts, reg.BUS_WATCHDOG, WATCHDOG_UNITS)
    _set_each(bus, reg.TORQUE_ENABLE, dict.fromkeys((s.servo_id for s in limp), 1), facts)
    _verify(bus, reg.BUS_WATCHDOG, {s.servo_id: WATCHDOG_UNITS for s in facts}, facts)
    _check_still(bus, facts)


def _check_still(bus: Bus, facts: tuple[ServoFacts, ...]) -> None:
    """Make sure that torque has moved nothing: position mode folds to one turn as it comes on."""
    present = bus.read_all(reg.PRESENT_POSITION, tuple(s.servo_id for s in facts))
    for servo in facts:
        moved = abs(present[servo.servo_id] - servo.present_position)
        if moved > GOAL_TOLERANCE_TICKS:
            raise HardwareFaultError(
                f"{servo.title} moved by {moved} ticks as its torque came on: check what pulls at"
                " it, and its operating mode and homing offset",
                servo.servo_id,
            )


def restore(bus: Bus, facts: tuple[ServoFacts, ...]) -> dict[int, str]:
    """Put torque, watchdog and profiles back as they were found; nothing has moved yet.

    Raises nothing for a bus or port that fails: it is called for an error that says why.

    Parameters
    ----------
    bus : Bus
    facts : tuple of ServoFacts
        As found.

    Returns
    -------
    dict of int to str
        Servos that do not read what they should, each with the first register that is wrong.
    """
    failed: dict[int, str] = {}
    for register, found in (
        (reg.TORQUE_ENABLE, {s.servo_id: 0 for s in facts if not s.torque_enabled}),
        (reg.BUS_WATCHDOG, {s.servo_id: s.bus_watchdog for s in facts}),
        (reg.PROFILE_VELOCITY, {s.servo_id: s.profile_velocity for s in facts}),
        (reg.PROFILE_ACCELERATION, {s.servo_id: s.profile_acceleration for s in facts}),
    ):
        for identifier, reads in _put_back(bus, register, found).items():
            failed.setdefault(
                identifier, f"{register.name} reads {reads} instead of {found[identifier]}"
            )
    return failed


def _put_back(bus: Bus, register: reg.Register, values: dict[int, int]) -> dict[int, str]:
    """Write until the values are read back; returns what else is read, where it is."""
    wrong = dict.fromkeys(values, "")
    for _ in range(RESTORE_ATTEMPTS):
        if not wrong:
            break
        with contextlib.suppress(ArmFaultError):  # reading back shows what came of it
            bus.sync_write(register, {i: values[i] for i in wrong})
        reads = {i: _reading(bus, register, i) for i in wrong}
        wrong = {i: read for i, read in reads.items() if read != str(values[i])}
    return wrong


def _reading(bus: Bus, register: reg.Register, servo_id: int) -> str:
    try:
        return str(bus.read_all(register, (servo_id,))[servo_id])
    except ArmFaultError:
        return "nothing"


def restore_profiles(bus: Bus, facts: tuple[ServoFacts, ...]) -> None:
    """Put the profiles back as they were found, velocity first, which bounds acceleration.

    Parameters
    ----------
    bus : Bus
    facts : tuple of ServoFacts
        As found.

    Raises
    ------
    HardwareFaultError
        A servo does not take its profile back.
    BusError, PortLostError
        As the bus.
    """
    velocity = {s.servo_id: s.profile_velocity for s in facts}
    acceleration = {s.servo_id: s.profile_acceleration for s in facts}
    _set_each(bus, reg.PROFILE_VELOCITY, velocity, facts)
    _set_each(bus, reg.PROFILE_ACCELERATION, acceleration, facts)


def disarm_watchdog(bus: Bus, facts: tuple[ServoFacts, ...]) -> None:
    """Switch the bus watchdog off; HardwareFaultError when a servo keeps it, or had expired."""
    ids = tuple(servo.servo_id for servo in facts)
    expired = [i for i, value in bus.read_all(reg.BUS_WATCHDOG, ids).items() if value < 0]
    if expired:
        raise HardwareFaultError(
            f"the bus watchdog of servo {expired[0]} expired during the motion: it did not"
            " follow to the end",
            expired[0],
        )
    _set(bus, facts, reg.BUS_WATCHDOG, 0)


def torque_off(bus: Bus, facts: tuple[ServoFacts, ...]) -> None:
    """Let all servos go; HardwareFaultError when one does not."""
    _set(bus, facts, reg.TORQUE_ENABLE, 0)


def release_watchdogs(bus: Bus, facts: tuple[ServoFacts, ...]) -> tuple[int, ...]:
    """Switch bus watchdogs off; a servo that one has stopped is held where it is.

    Parameters
    ----------
    bus : Bus
    facts : tuple of ServoFacts
        For the servos' names; watchdogs and positions are read anew.

    Returns
    -------
    tuple of int
        Servos whose watchdog was armed or had expired.

    Raises
    ------
    HardwareFaultError
        A watchdog that stays on, or a stopped servo that does not take its position as its goal.
    BusError, PortLostError
        As the bus.
    """
    ids = tuple(servo.servo_id for servo in facts)
    watchdogs = bus.read_all(reg.BUS_WATCHDOG, ids)
    active = tuple(i for i, value in watchdogs.items() if value)
    expired = tuple(i for i in active if watchdogs[i] == reg.WATCHDOG_EXPIRED)
    present = bus.read_all(reg.PRESENT_POSITION, expired) if expired else {}
    if active:
        # back to back: a goal from before must not start a motion in between
        bus.sync_write(reg.BUS_WATCHDOG, dict.fromkeys(active, 0))
    if expired:
        bus.sync_write(reg.GOAL_POSITION, present)
    _verify(bus, reg.BUS_WATCHDOG, dict.fromkeys(active, 0), facts)
    _verify(bus, reg.GOAL_POSITION, present, facts)
    return active


def _set(bus: Bus, facts: tuple[ServoFacts, ...], register: reg.Register, value: int) -> None:
    _set_each(bus, register, {servo.servo_id: value for servo in facts}, facts)


def _set_each(
    bus: Bus, register: reg.Register, values: dict[int, int], facts: tuple[ServoFacts, ...]
) -> None:
    if values:
        bus.sync_write(register, values)
        _verify(bus, register, values, facts)


def _verify(
    bus: Bus, register: reg.Register, values: dict[int, int], facts: tuple[ServoFacts, ...]
) -> None:
    read = bus.read_all(register, tuple(values))
    for servo in facts:
        identifier = servo.servo_id
        if identifier in values and read[identifier] != values[identifier]:
            raise HardwareFaultError(
                f"{servo.title} does not take {values[identifier]} as its {register.name}"
                f" (register {register.address} reads {read[identifier]}): check its limits",
                identifier,
            )
