"""Faults of a servo's mechanics, encoder and supply, each for a time."""

from __future__ import annotations

from firmware_sim.faults.argument import Argument
from firmware_sim.faults.servo_states import ServoState
from firmware_sim.faults.spec import FaultKind
from firmware_sim.servo import Servo


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
    """The supply gives less than it should."""

    effect = "supply"

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
