"""Faults of a servo's set-up: another baud rate, another's ID."""

from __future__ import annotations

from firmware_sim.errors import FaultError
from firmware_sim.faults.argument import Argument
from firmware_sim.faults.servo_states import ServoState
from firmware_sim.faults.spec import FaultKind
from firmware_sim.servo import Servo


class WrongBaud(ServoState):
    """A servo listens and speaks at another baud rate."""

    effect = "baud"

    def check(self) -> None:
        """See that the servos have such a rate."""
        super().check()
        for servo in self.site.chosen(self.spec.servo_id):
            self._code(servo)

    def _code(self, servo: Servo) -> int:
        rate = self.spec.whole("baud")
        for code, known in servo.model.baud_rates.items():
            if known == rate:
                return code
        rates = ", ".join(map(str, servo.model.baud_rates.values()))
        raise FaultError(f"wrong-baud: baud={rate} is none of {servo.model.name}'s {rates}")

    def present(self, servo: Servo) -> float:
        """Return the code of its rate."""
        return servo.memory.value("Baud Rate")

    def apply(self, servo: Servo) -> None:
        """Set the other rate."""
        _set_baud_rate(servo, self._code(servo))

    def undo(self, servo: Servo, normal: float) -> None:
        """Put the rate back that it had."""
        _set_baud_rate(servo, int(normal))


class DuplicateId(ServoState):
    """A servo has the ID of another."""

    effect = "id"

    def check(self) -> None:
        """See that both are there."""
        super().check()
        twin = self.spec.whole("as")
        if twin == self.spec.servo_id or not self.site.chosen(twin):
            raise FaultError(f"duplicate-id: as={twin} is not another servo's ID")

    def present(self, servo: Servo) -> float:
        """Return its ID."""
        return servo.servo_id

    def apply(self, servo: Servo) -> None:
        """Give it the other ID."""
        _set_id(servo, self.spec.whole("as"))

    def undo(self, servo: Servo, normal: float) -> None:
        """Give it back its own."""
        _set_id(servo, int(normal))


def _set_baud_rate(servo: Servo, code: int) -> None:
    """Change a rate behind the firmware's back: in EEPROM, and at once."""
    servo.memory.store("Baud Rate", code)
    servo.take_identity()


def _set_id(servo: Servo, servo_id: int) -> None:
    servo.memory.store("ID", servo_id)
    servo.take_identity()


KINDS = (
    FaultKind(
        "wrong-baud",
        (14,),
        "a servo is at another baud rate",
        WrongBaud,
        (Argument("baud", "its rate", 57_600, "bit/s", 1, 10_000_000, whole=True),),
    ),
    FaultKind(
        "duplicate-id",
        (7,),
        "a servo has the ID of another: both answer at once",
        DuplicateId,
        (Argument("as", "the other's ID", high=252, whole=True, required=True),),
        needs_servo=True,
    ),
)
