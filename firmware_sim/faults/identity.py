"""Faults of a servo's set-up: another baud rate, another's ID."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from firmware_sim.errors import FaultError
from firmware_sim.faults.argument import Argument
from firmware_sim.faults.fault import Fault, Site
from firmware_sim.faults.servo_states import ServoState
from firmware_sim.faults.spec import FaultKind
from firmware_sim.firmware.servo import Servo
from firmware_sim.rig.settings import rates_in_words
from firmware_sim.wire.line import same_rate


class SetUpState(ServoState):
    """A servo's register of its set-up holds something else, behind the firmware's back.

    What a client writes there meanwhile stays.
    """

    register: ClassVar[str]

    def value(self, servo: Servo) -> int:
        """Return what the register holds while the fault lasts."""
        raise NotImplementedError

    def present(self, servo: Servo) -> float:
        """Return what it holds now."""
        return servo.memory.value(self.register)

    def apply(self, servo: Servo) -> None:
        """Set it."""
        self._store(servo, self.value(servo))

    def undo(self, servo: Servo, normal: float) -> None:
        """Put back what it held, or what somebody else has set meanwhile."""
        present = self.present(servo)
        holders = [self, *_held_states(self.site.states, servo, self.effect)]
        if present in [holder.value(servo) for holder in holders]:
            self._store(servo, int(normal))
        else:
            self.site.normal[self.effect, servo] = present

    def _store(self, servo: Servo, value: int) -> None:
        servo.memory.store(self.register, value)
        servo.take_identity()


class WrongBaud(SetUpState):
    """A servo listens and speaks at another baud rate."""

    effect = "baud"
    register = "Baud Rate"

    def check(self) -> None:
        """See that the servos have such a rate."""
        super().check()
        for servo in self.site.chosen(self.spec.servo_id):
            self.value(servo)

    def value(self, servo: Servo) -> int:
        """Return the code of its rate."""
        rate = self.spec.whole("baud")
        rates = servo.model.baud_rates
        nearest = min(rates, key=lambda code: abs(rates[code] - rate))
        if not same_rate(rates[nearest], rate):
            known = rates_in_words(rates.values())
            raise FaultError(f"wrong-baud: baud={rate} is none of {servo.model.name}'s {known}")
        return nearest


class DuplicateId(SetUpState):
    """A servo has the ID of another."""

    effect = "id"
    register = "ID"

    def check(self) -> None:
        """See that both are there."""
        super().check()
        twin = self.spec.whole("as")
        if twin == self.spec.servo_id or not self.site.chosen(twin):
            raise FaultError(f"duplicate-id: as={twin} is not another servo's ID")

    def value(self, _servo: Servo) -> int:
        """Return the other ID."""
        return self.spec.whole("as")


def own_settings(site: Site, servo: Servo) -> dict[str, int]:
    """Return the registers that only a fault has changed, by name, as they are without it."""
    own = {}
    for state in _held_states(site.states, servo):
        if state.present(servo) == state.value(servo):
            own[state.register] = int(site.normal[state.effect, servo])
    return own


def _held_states(states: Sequence[Fault], servo: Servo, effect: str = "") -> list[SetUpState]:
    """Return those of some faults that hold a servo's set-up, of one effect or of any."""
    return [
        state
        for state in states
        if isinstance(state, SetUpState) and servo in state.held and effect in ("", state.effect)
    ]


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
