"""Who listens on a bus, and what they have to say: shared by both protocols."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from firmware_sim.firmware.servo import Servo


class Reply(NamedTuple):
    """One status packet and when its sender may begin.

    Parameters
    ----------
    data : bytes
        The frame.
    delay : float
        Return delay, s.
    turn : float
        How long after the request its turn comes at the earliest, s; it also waits for what is
        said before it.
    """

    data: bytes
    delay: float
    turn: float = 0.0


Turn = Sequence[Reply]
"""Replies of all who believe that it is their turn: one, unless servos share an ID."""


@dataclass(frozen=True, slots=True)
class Listeners:
    """The servos that speak one protocol at one baud rate.

    Parameters
    ----------
    everyone : sequence of Servo
        In the order of their IDs.
    by_id : mapping of int to sequence of Servo
        A wrongly set up bus has several of one ID.
    shadows : mapping of int to sequence of Servo
        By secondary ID, where it differs from the ID.
    """

    everyone: Sequence[Servo]
    by_id: Mapping[int, Sequence[Servo]]
    shadows: Mapping[int, Sequence[Servo]]

    def hearing(self, servo_id: int) -> list[Servo]:
        """Return the servos with an ID that hear at present."""
        return [servo for servo in self.by_id.get(servo_id, ()) if servo.hears]

    def hearing_shadows(self, servo_id: int) -> list[Servo]:
        """Return the servos with a secondary ID that hear at present."""
        return [servo for servo in self.shadows.get(servo_id, ()) if servo.hears]

    def write(self, servo_id: int, address: int, data: bytes) -> None:
        """Write a servo's share of a write to several, and its shadows'; nobody answers.

        Through a secondary ID the EEPROM is out of reach (e-Manual, X-series pages,
        "Secondary(Shadow) ID(12)").
        """
        for servo in self.by_id.get(servo_id, ()):
            if servo.hears:
                servo.write(address, data)
        if self.shadows:
            for servo in self.hearing_shadows(servo_id):
                servo.write(address, data, ram_only=True)


def gather(servos: Iterable[Servo]) -> Listeners:
    """Return servos as listeners."""
    everyone = sorted(servos, key=lambda servo: servo.servo_id)
    by_id: dict[int, list[Servo]] = {}
    shadows: dict[int, list[Servo]] = {}
    for servo in everyone:
        by_id.setdefault(servo.servo_id, []).append(servo)
        if servo.secondary_id is not None and servo.secondary_id != servo.servo_id:
            shadows.setdefault(servo.secondary_id, []).append(servo)
    return Listeners(everyone, by_id, shadows)
