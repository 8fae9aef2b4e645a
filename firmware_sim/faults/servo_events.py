"""Faults that happen to a servo at a time: restarts and hardware errors."""

from __future__ import annotations

from random import Random
from typing import ClassVar

from firmware_sim.errors import FaultError
from firmware_sim.faults.argument import Argument
from firmware_sim.faults.spec import FaultKind, FaultSpec
from firmware_sim.faults.striking import EventFault
from firmware_sim.firmware.codes import CLEAR_MULTI_TURN, HardwareError, StatusError
from firmware_sim.firmware.servo import Servo

_OLDER = (HardwareError.INPUT_VOLTAGE, HardwareError.OVERHEATING, HardwareError.OVERLOAD)
"""What servos of other families than X can report (e-Manual: AX-12A, MX-28, XL-320, Shutdown)."""

_RETRY = 0.01
"""How often a moving servo is looked at, s."""


class ServoEvent(EventFault):
    """Happens to one servo, or to all."""

    def strike(self, when: float) -> None:
        """Let it happen to each."""
        detail = ""
        for servo in self.site.chosen(self.spec.servo_id):
            detail = self.happen(servo)
        self.struck(when, self.spec.servo_id, detail)

    def happen(self, servo: Servo) -> str:
        """Let it happen to one, and say what there is to say."""
        raise NotImplementedError


class Reboot(ServoEvent):
    """A servo starts anew by itself."""

    def happen(self, servo: Servo) -> str:
        """Reboot it."""
        servo.reboot()
        return ""


class PowerCut(ServoEvent):
    """The supply is gone for a moment."""

    def happen(self, servo: Servo) -> str:
        """Take its power away."""
        off = self.spec.number("off")
        servo.power_cycle(off_for=off)
        return f"off for {off:g} s"


class Fold(EventFault):
    """Servos forget how many turns they have made; one that moves, as soon as it stands."""

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self._moving: list[Servo] = []
        self._following: float | None = None

    def wake(self, when: float) -> None:
        """Go on with those that moved, or strike."""
        if self._moving:
            self._fold(self._moving, when)
        else:
            super().wake(when)
            self._following = self.wakes
        self.wakes = when + _RETRY if self._moving else self._following

    def strike(self, when: float) -> None:
        """Let them forget."""
        self._fold(self.site.chosen(self.spec.servo_id), when)

    def _fold(self, servos: list[Servo], when: float) -> None:
        results = [(servo, servo.clear(CLEAR_MULTI_TURN)) for servo in servos]
        self._moving = [servo for servo, error in results if error is StatusError.RESULT_FAIL]
        for servo, error in results:
            if error is StatusError.NONE:
                self.struck(when, servo.servo_id, "turns forgotten")


class HardwareFailure(ServoEvent):
    """A servo finds something wrong with its hardware."""

    error: ClassVar[HardwareError]

    def check(self) -> None:
        """See that such servos have a name for it."""
        super().check()
        if not any(map(self._knows, self.site.chosen(self.spec.servo_id))):
            name = self.spec.kind.name
            raise FaultError(f"{name}: no such servo can report it, so that nothing would happen")

    def _knows(self, servo: Servo) -> bool:
        return servo.model.family == "x" or self.error in _OLDER

    def happen(self, servo: Servo) -> str:
        """Raise the error; a servo set to shut down for it does."""
        servo.raise_hardware_error(self.error)
        return f"hardware error 0x{self.error:02X}"


class Overload(HardwareFailure):
    """A load over the limit for too long."""

    error = HardwareError.OVERLOAD


class Overheating(HardwareFailure):
    """A temperature over the limit."""

    error = HardwareError.OVERHEATING


class InputVoltage(HardwareFailure):
    """A supply voltage outside the limits."""

    error = HardwareError.INPUT_VOLTAGE


class EncoderError(HardwareFailure):
    """An encoder that does not work."""

    error = HardwareError.MOTOR_ENCODER


class ElectricalShock(HardwareFailure):
    """An electrical shock on the circuit, or too little power for the motor."""

    error = HardwareError.ELECTRICAL_SHOCK


_LATCHED = "latched until a reboot; torque off where its Shutdown register says so"

KINDS = (
    FaultKind("reboot", (10, 24), "a servo restarts by itself: RAM, torque and turns gone", Reboot),
    FaultKind(
        "power-cut",
        (10, 24),
        "the supply of a servo, or of all, is gone for a moment (brown-out)",
        PowerCut,
        (Argument("off", "how long it is gone", 0.2, "s"),),
    ),
    FaultKind(
        "multi-turn-fold", (24,), "the position is folded into one turn: turns are forgotten", Fold
    ),
    FaultKind("overload", (18,), f"hardware error: overload; {_LATCHED}", Overload),
    FaultKind("overheating", (19,), f"hardware error: overheating; {_LATCHED}", Overheating),
    FaultKind("input-voltage", (19,), f"hardware error: input voltage; {_LATCHED}", InputVoltage),
    FaultKind("encoder-error", (19,), f"hardware error: motor encoder; {_LATCHED}", EncoderError),
    FaultKind(
        "electrical-shock", (19,), f"hardware error: electrical shock; {_LATCHED}", ElectricalShock
    ),
)
