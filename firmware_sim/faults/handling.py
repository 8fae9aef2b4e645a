"""What people and things do to a horn: a hand that turns it, an obstacle that stops it."""

from __future__ import annotations

from collections.abc import Mapping

from firmware_sim.faults.argument import Argument
from firmware_sim.faults.servo_states import ServoState
from firmware_sim.faults.spec import FaultKind
from firmware_sim.firmware.servo import Servo

HAND_SPEED, HAND_TORQUE = 1.0, 3.0
"""Of a hand at most, where nothing else is asked for: rad/s, N m."""

_FARTHEST = 1_048_575
"""What position registers go to, ticks, either way."""


class Hand(ServoState):
    """A person turns the horn, slowly and strongly, and holds it there.

    A limp joint follows; one with torque resists with what its control loop makes of the error, and
    stays where it is if that is more than the hand's torque.
    """

    effect = "hand"

    def apply(self, servo: Servo) -> None:
        """Take hold of it; where Present Position reads the tick is found out now."""
        angle = servo.firmware.angle(self.spec.whole("to"))
        servo.axis.take_hand(angle, self.spec.number("speed"), self.spec.number("torque"))

    def undo(self, servo: Servo, _normal: float) -> None:
        """Let go."""
        servo.axis.let_go()


class Obstacle(ServoState):
    """Something hard stops the horn at a tick, such as an object between fingers."""

    effect = "obstacle"

    def apply(self, servo: Servo) -> None:
        """Put it there; a horn that is past it already goes no further."""
        tick = self.spec.whole("tick")
        angle = servo.firmware.angle(tick)
        counts_up = servo.firmware.angle(tick + 1) > angle
        if (self.spec.choice("side") == "above") == counts_up:
            servo.axis.block(high=angle)
        else:
            servo.axis.block(low=angle)

    def undo(self, servo: Servo, _normal: float) -> None:
        """Take all obstacles away; those that are left are put back."""
        servo.axis.unblock()


def hands(
    ticks: Mapping[int, int], speed: float = HAND_SPEED, torque: float = HAND_TORQUE
) -> list[str]:
    """Return the faults that turn several horns by hand.

    Parameters
    ----------
    ticks : mapping of int to int
        By servo ID, where to, as Present Position reads.
    speed, torque : float
        At most, rad/s and N m.
    """
    return [
        f"hand:id={servo_id},to={tick},speed={speed:g},torque={torque:g}"
        for servo_id, tick in ticks.items()
    ]


KINDS = (
    FaultKind(
        "hand",
        (35,),
        "a person's hand turns the horn and holds it there, limp or not; it lets go in the end",
        Hand,
        (
            Argument(
                "to",
                "where to, as Present Position reads; ticks",
                low=-_FARTHEST,
                high=_FARTHEST,
                whole=True,
                required=True,
            ),
            Argument("speed", "at most", HAND_SPEED, "rad/s", 0.01, 20.0),
            Argument("torque", "at most", HAND_TORQUE, "N m", 0.01, 100.0),
        ),
        needs_servo=True,
    ),
    FaultKind(
        "obstacle",
        (18, 35),
        "something hard stops the horn at a tick, as an object between fingers does",
        Obstacle,
        (
            Argument(
                "tick",
                "where, as Present Position reads; a horn that is past it goes no further",
                low=-_FARTHEST,
                high=_FARTHEST,
                whole=True,
                required=True,
            ),
            Argument(
                "side",
                "of the tick that cannot be reached",
                "above",
                choices=("above", "below"),
            ),
        ),
        needs_servo=True,
    ),
)
