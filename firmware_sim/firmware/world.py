"""Servos and their physics in one time.

A world knows nothing of buses: it is told the time, and everything in it has gone on to that time.
It stops on the way wherever a servo does something of itself, and for inspections, so that what
happens does not depend on how often it is told.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.servo import Servo
from firmware_sim.firmware.timeline import Timeline
from firmware_sim.physics.axis import Axes
from firmware_sim.physics.kernel import STEP
from firmware_sim.physics.plant import JointsPlant, Plant

INSPECTION_STEPS = 10
"""Steps of physics between two inspections of every servo, while something moves."""

RESTING_STEPS = 1000
"""Steps of physics between two inspections while nothing moves: only temperatures change then."""

_ROUNDING = 1e-6
"""Steps by which a time may lie under a whole number of them."""


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
        Each drives one of the plant's axes; their IDs need not differ, as on a real bus.
    plant : Plant
        What moves the axes.
    timeline : Timeline
        The time that all of them share.
    """

    def __init__(self, servos: Sequence[Servo], plant: Plant, timeline: Timeline) -> None:
        self.servos = tuple(servos)
        self.plant = plant
        self._timeline = timeline
        self._epoch = timeline.now
        self._steps = 0
        self._inspection = INSPECTION_STEPS
        self._was_sound = False

    @property
    def now(self) -> float:
        """The present moment, s."""
        return self._timeline.now

    @property
    def identities(self) -> int:
        """Another number whenever a servo has taken an ID, a baud rate or a protocol."""
        return self._timeline.identities

    @property
    def moving(self) -> bool:
        """Whether time must be told to it even without requests."""
        return not self.plant.axes.settled

    @property
    def next_event(self) -> float | None:
        """When a servo does something of itself, s; None for never."""
        moment = min((servo.next_event for servo in self.servos), default=math.inf)
        return None if moment == math.inf else moment

    def advance(self, when: float) -> None:
        """Bring everything to a time, s; a past one changes nothing."""
        timeline = self._timeline
        while True:
            alarm = timeline.alarm
            self._run_to(min(alarm, when))
            if timeline.alarm < alarm:
                continue  # an inspection found something to look at again soon
            timeline.now = max(timeline.now, min(alarm, when))
            if alarm > when:
                return
            self._wake()

    def _wake(self) -> None:
        """Let the servos do what is due, and ask them when to do that next."""
        for servo in self.servos:
            if servo.next_event <= self._timeline.now:
                servo.wake()
        self._timeline.alarm = min((servo.next_event for servo in self.servos), default=math.inf)

    def _run_to(self, when: float) -> None:
        """Move the axes, with an inspection whenever one is due, as far as the next alarm."""
        target = self._steps_at(when)
        while self._steps < target:
            if self._inspection - self._steps > INSPECTION_STEPS and self.moving:
                self._inspection = _next_multiple(self._steps, INSPECTION_STEPS)
            stop = min(target, self._inspection)
            self.plant.advance(stop - self._steps)
            self._steps = stop
            if stop == self._inspection:
                self._inspect()
                if self._timeline.alarm < when:
                    target = min(target, self._steps_at(self._timeline.alarm))

    def _steps_at(self, when: float) -> int:
        """Return how many whole steps fit between the beginning and a time."""
        return int((when - self._epoch) / STEP + _ROUNDING)

    def _inspect(self) -> None:
        """Let the servos look for causes of errors, and say when they look next.

        Where all is sound, and was so before, there is nothing that they could see or forget.
        """
        self._timeline.now = max(self._timeline.now, self._epoch + self._steps * STEP)
        sound = self.plant.axes.sound
        if not (sound and self._was_sound):
            for servo in self.servos:
                servo.inspect()
        self._was_sound = sound
        interval = INSPECTION_STEPS if self.moving else RESTING_STEPS
        self._inspection = _next_multiple(self._steps, interval)


def _next_multiple(steps: int, interval: int) -> int:
    return (steps // interval + 1) * interval


def build_world(
    settings: Sequence[Settings],
    when: float = 0.0,
    plant: Callable[[Axes], Plant] | None = None,
) -> World:
    """Return servos powered up at a time.

    Parameters
    ----------
    settings : sequence of Settings
        One a servo, and an axis.
    when : float
        s.
    plant : callable, optional
        Makes what moves the axes, once they are configured; independent joints by default.
    """
    axes, timeline = Axes(len(settings)), Timeline(when)
    servos = [
        Servo(
            servo.model,
            servo.servo_id,
            axis,
            timeline,
            start_tick=servo.start_tick,
            supply_voltage=servo.supply_voltage,
            registers=servo.registers,
        )
        for servo, axis in zip(settings, axes, strict=True)
    ]
    return World(servos, JointsPlant(axes) if plant is None else plant(axes), timeline)
