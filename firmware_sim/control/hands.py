"""Scripts of a person's hands: joints turned to ticks, and how long that may take."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from firmware_sim.control.report import describe_servo
from firmware_sim.faults.handling import HAND_SPEED, HAND_TORQUE, hands
from firmware_sim.firmware.servo import Servo

LOOK = 0.02
"""From one look at the horns to the next, s."""

_NEAR = 2
"""Ticks at which a horn has arrived."""

_TICK = math.radians(300.0) / 1023
"""Of the coarsest encoders, rad: an upper bound for all."""

_PATIENCE = 3.0
"""For speeding up, slowing down and late looks, s."""


@dataclass(frozen=True, slots=True)
class Hands:
    """What turns horns in one simulation.

    Parameters
    ----------
    inject : callable
        Begins a fault, and returns its number.
    clear : callable
        Ends the fault of a number.
    positions : callable
        Returns what Present Position reads of each servo, by ID.
    wait : callable
        Lets a time in s pass.
    """

    inject: Callable[[str], int]
    clear: Callable[[str], object]
    positions: Callable[[], Mapping[int, int]]
    wait: Callable[[float], object]

    def turn(
        self,
        ticks: Mapping[int, int],
        speed: float = HAND_SPEED,
        torque: float = HAND_TORQUE,
        keep: bool = False,
    ) -> bool:
        """Turn horns, and wait until all have come to where they are to go.

        Parameters
        ----------
        ticks : mapping of int to int
            By servo ID, where to, as Present Position reads.
        speed, torque : float
            Of each hand at most, rad/s and N m.
        keep : bool
            Whether the hands hold on afterwards, until the faults ``hand`` are cleared; else they
            let go.

        Returns
        -------
        bool
            Whether all came there; False if they were held back for longer than it can take.

        Raises
        ------
        FaultError or ControlError
            If there is no such servo.
        """
        if not ticks:
            return True
        before = self.positions()
        numbers = [self.inject(text) for text in hands(ticks, speed, torque)]
        farthest = max(abs(tick - before[servo_id]) for servo_id, tick in ticks.items())
        arrived = False
        for _ in range(math.ceil((farthest * _TICK / speed + _PATIENCE) / LOOK)):
            self.wait(LOOK)
            found = self.positions()
            arrived = all(abs(tick - found[servo]) <= _NEAR for servo, tick in ticks.items())
            if arrived:
                break
        for number in numbers if not keep else ():
            self.clear(str(number))
        return arrived


def positions_of(servos: Sequence[Servo]) -> dict[int, int]:
    """Return what Present Position reads of each servo, by ID."""
    return positions_in([describe_servo(servo) for servo in servos])


def positions_in(reports: Sequence[Mapping[str, Any]]) -> dict[int, int]:
    """Return what Present Position reads, by ID, out of servos' reports."""
    return {row["id"]: int(row["registers"]["Present Position"]) for row in reports}
