"""Faults that keep a servo in another state for a time."""

from __future__ import annotations

from random import Random
from typing import ClassVar, TypeGuard

from firmware_sim.errors import FaultError
from firmware_sim.faults.fault import Fault
from firmware_sim.faults.spec import FaultKind, FaultSpec
from firmware_sim.faults.striking import StateFault
from firmware_sim.firmware.servo import Servo

_FOR_EVER = 1.0e9

_EXPIRY = 0.025
"""The shortest time of the watchdog is 20 ms; servos count milliseconds."""


class ServoState(StateFault):
    """Keeps one servo, or all, in another state.

    Where several faults of one effect hold a servo, the end of one leaves the others in force.
    """

    effect: ClassVar[str]

    def __init__(self, spec: FaultSpec, random: Random) -> None:
        super().__init__(spec, random)
        self.held: list[Servo] = []

    def enter(self, _when: float) -> None:
        """Put the servos into the state."""
        self.held = self.site.chosen(self.spec.servo_id)
        self.site.states.append(self)
        for servo in self.held:
            self.site.normal.setdefault((self.effect, servo), self.present(servo))
            self.apply(servo)

    def leave(self, _when: float) -> None:
        """Put them back, unless others hold them."""
        released, self.held = self.held, []
        self.site.states.remove(self)
        for servo in released:
            self._release(servo)

    def _release(self, servo: Servo) -> None:
        key = (self.effect, servo)
        self.undo(servo, self.site.normal[key])
        others = [other for other in self.site.states if _holds(other, self.effect, servo)]
        for other in others:
            other.apply(servo)
        if not others:
            del self.site.normal[key]

    def present(self, _servo: Servo) -> float:
        """Return what the state changes, as it is; 0 for what is on or off."""
        return 0.0

    def apply(self, servo: Servo) -> None:
        """Put one servo into the state."""
        raise NotImplementedError

    def undo(self, servo: Servo, normal: float) -> None:
        """Put one back to what was there before."""
        raise NotImplementedError


def _holds(fault: Fault, effect: str, servo: Servo) -> TypeGuard[ServoState]:
    return isinstance(fault, ServoState) and fault.effect == effect and servo in fault.held


class SilentServo(ServoState):
    """A servo hears nothing and says nothing; its motor goes on."""

    effect = "silenced"

    def apply(self, servo: Servo) -> None:
        """Silence it."""
        servo.silenced = True

    def undo(self, servo: Servo, _normal: float) -> None:
        """Let it speak."""
        servo.silenced = False


class MissingServo(SilentServo):
    """A servo that is not connected: no power, no word."""

    def apply(self, servo: Servo) -> None:
        """Take it off."""
        super().apply(servo)
        servo.power_cycle(off_for=_FOR_EVER)

    def undo(self, servo: Servo, _normal: float) -> None:
        """Connect it; it boots."""
        super().undo(servo, _normal)
        servo.power_cycle()


class WatchdogExpired(SilentServo):
    """The bus watchdog of a servo expires: it is armed, and then nothing reaches the servo."""

    @property
    def duration(self) -> float:
        """How long nothing reaches it, s."""
        return max(_EXPIRY, self.spec.optional("for") or 0.0)

    def check(self) -> None:
        """See that such servos have a watchdog."""
        super().check()
        if not any(map(_has_watchdog, self.site.chosen(self.spec.servo_id))):
            raise FaultError("watchdog-expired: no such servo has a bus watchdog")

    def enter(self, when: float) -> None:
        """Arm it, and cut the servo off."""
        for servo in filter(_has_watchdog, self.site.chosen(self.spec.servo_id)):
            servo.write(_watchdog_address(servo), b"\x01")
            servo.feed(when)
        super().enter(when)

    def leave(self, when: float) -> None:
        """Let the servo hear again; a watchdog that did not watch is disarmed."""
        released = self.held
        super().leave(when)
        for servo in filter(_has_watchdog, released):
            if servo.memory.value("Bus Watchdog") == 1:
                servo.write(_watchdog_address(servo), b"\x00")


def _has_watchdog(servo: Servo) -> bool:
    return "Bus Watchdog" in servo.model.table.by_name


def _watchdog_address(servo: Servo) -> int:
    return servo.model.table.by_name["Bus Watchdog"].address


KINDS = (
    FaultKind("silent-servo", (9,), "a servo hears nothing and says nothing", SilentServo),
    FaultKind(
        "missing-servo",
        (8, 9),
        "a servo is not there: no power, no word",
        MissingServo,
        needs_servo=True,
    ),
    FaultKind(
        "watchdog-expired",
        (25,),
        "the bus watchdog expires, if the torque is on: nothing reaches the servo for 25 ms",
        WatchdogExpired,
    ),
)
