"""Faults of a servo's mechanics, encoder and supply, each for a time."""

from __future__ import annotations

import math
from random import Random

from firmware_sim.faults.argument import Argument
from firmware_sim.faults.servo_states import ServoState
from firmware_sim.faults.spec import FaultKind, FaultSpec
from firmware_sim.firmware.servo import Servo

_LOOK_TIME = 0.02
"""From one look at a supply that sags to the next, s."""

_LOOKS = 10
"""How many there are: by then every servo has noticed what there is to notice."""


class Jam(ServoState):
    """The horn does not turn."""

    effect = "jam"

    def apply(self, servo: Servo) -> None:
        """Jam it."""
        servo.axis.jam(on=True)

    def undo(self, servo: Servo, _normal: float) -> None:
        """Free it."""
        servo.axis.jam(on=False)


class Push(ServoState):
    """Somebody pushes the horn."""

    effect = "push"

    def apply(self, servo: Servo) -> None:
        """Push."""
        servo.apply_load(self.spec.number("torque"))

    def undo(self, servo: Servo, _normal: float) -> None:
        """Let go."""
        servo.apply_load(0.0)


class Friction(ServoState):
    """The gear turns less easily than it should."""

    effect = "friction"

    def apply(self, servo: Servo) -> None:
        """Multiply the friction."""
        servo.axis.set_friction(self.spec.number("factor"))

    def undo(self, servo: Servo, _normal: float) -> None:
        """Put it back."""
        servo.axis.set_friction(1.0)


class StuckEncoder(ServoState):
    """The encoder shows one angle, wherever the horn is."""

    effect = "encoder"

    def apply(self, servo: Servo) -> None:
        """Stick it."""
        servo.axis.stick_encoder(on=True)

    def undo(self, servo: Servo, _normal: float) -> None:
        """Free it."""
        servo.axis.stick_encoder(on=False)


class SupplySag(ServoState):
    """The supply gives less than it should.

    Servos at rest look at themselves once a second only; of a sag they are told at once.
    """

    effect = "supply"

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self._looks = 0
        self._until: float | None = None

    def wake(self, when: float) -> None:
        """Begin or end, or let the servos look at their supply."""
        if self.on and self._looks and (self._until is None or when < self._until):
            self._looks -= 1
            for servo in self.held:
                servo.inspect()
        else:
            super().wake(when)
            self._until = self.wakes
            self._looks = _LOOKS
        if self.on:
            soon = when + _LOOK_TIME if self._looks else math.inf
            wakes = min(soon, math.inf if self._until is None else self._until)
            self.wakes = None if wakes == math.inf else wakes

    def present(self, servo: Servo) -> float:
        """Return its voltage, V."""
        return servo.supply_voltage

    def apply(self, servo: Servo) -> None:
        """Change it."""
        servo.axis.set_supply(self.spec.number("voltage"))

    def undo(self, servo: Servo, normal: float) -> None:
        """Put it back."""
        servo.axis.set_supply(normal)


KINDS = (
    FaultKind("jam", (18, 35), "the horn does not turn", Jam),
    FaultKind(
        "push",
        (35,),
        "an external torque on the horn",
        Push,
        (Argument("torque", "against the positive direction", 1.0, "N m", -100.0, 100.0),),
    ),
    FaultKind(
        "friction",
        (18, 35),
        "the gear turns less easily",
        Friction,
        (Argument("factor", "of the normal friction", 5.0, "", 0.0, 1000.0),),
    ),
    FaultKind(
        "stuck-encoder",
        (19, 35),
        "the position stays as it is, wherever the horn goes",
        StuckEncoder,
    ),
    FaultKind(
        "supply-sag",
        (19,),
        "the supply gives another voltage",
        SupplySag,
        (Argument("voltage", "that it gives", 9.0, "V", 0.0, 60.0),),
    ),
)
