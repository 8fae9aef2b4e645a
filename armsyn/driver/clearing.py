"""Clearing what a fault left on an arm's servos."""

from __future__ import annotations

import contextlib

from armsyn.arm import ArmDescription
from armsyn.driver.facts import check_models
from armsyn.driver.models import check_known
from armsyn.driver.operate import clear
from armsyn.driver.servos import ServoGroup
from armsyn.driver.transactions import Bus


def clear_watchdogs(port: str, arm: ArmDescription) -> tuple[int, ...]:
    """Switch off the bus watchdogs that a fault left, and make sure of it.

    Servos that their watchdog has stopped hold where they are, at torque or without as before;
    the others keep their goals.

    Look at the arm first: this is the operator's word that it may move again.

    Parameters
    ----------
    port : str
    arm : ArmDescription

    Returns
    -------
    tuple of int
        IDs of the servos whose watchdog was armed or had expired.

    Raises
    ------
    DescriptionError, PortError, ServoMissingError, ServoMismatchError, BusError
        As `ArmSession.open`.
    HardwareFaultError
        A watchdog that stays on, or a stopped servo that does not take its goal.
    """
    check_known(arm)
    with contextlib.closing(Bus(port, arm.servo[0].baud)) as bus:
        group = ServoGroup(bus, arm.servo)
        check_models(group, arm.name)
        return clear(group)
