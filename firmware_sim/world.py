"""Servos and their physics in one time.

A world knows nothing of buses: it is told the time, and everything in it has gone on to that time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from firmware_sim.model import ServoModel
from firmware_sim.servo import Servo


class Settings(Protocol):
    """What must be known of a servo before it is powered up; `rig.ServoSettings` is one."""

    @property
    def model(self) -> ServoModel:
        """What it is."""

    @property
    def servo_id(self) -> int:
        """0 to 252."""

    @property
    def start_tick(self) -> int:
        """Where it lies, as Present Position reads at the start."""

    @property
    def supply_voltage(self) -> float | None:
        """V; None for the motor's nominal voltage."""

    @property
    def registers(self) -> Mapping[str, int]:
        """EEPROM registers by name that differ from the factory's."""


class World:
    """All servos and what moves them.

    Parameters
    ----------
    servos : sequence of Servo
        Their IDs need not differ, as on a real bus.
    """

    def __init__(self, servos: Sequence[Servo]) -> None:
        self.servos = tuple(servos)

    @property
    def moving(self) -> bool:
        """Whether time must be told to it even without requests."""
        return any(servo.moving for servo in self.servos)

    @property
    def next_event(self) -> float | None:
        """When a bus watchdog expires unless it is fed, s; None if none watches."""
        deadlines = (servo.watchdog_deadline for servo in self.servos)
        return min((deadline for deadline in deadlines if deadline is not None), default=None)

    def advance(self, when: float) -> None:
        """Bring everything to a time, s; a past one changes nothing."""
        for servo in self.servos:
            servo.advance(when)


def build_world(settings: Sequence[Settings], when: float = 0.0) -> World:
    """Return servos powered up at a time.

    Parameters
    ----------
    settings : sequence of Settings
        One a servo.
    when : float
        s.
    """
    return World(
        [
            Servo(
                servo.model,
                servo.servo_id,
                servo.start_tick,
                servo.supply_voltage,
                settings=dict(servo.registers),
                when=when,
            )
            for servo in settings
        ]
    )
