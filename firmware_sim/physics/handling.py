"""What acts on an axis from outside: loads, other shafts, hands, obstacles, supplies, faults."""

from __future__ import annotations

import math

from firmware_sim.physics import kernel as k
from firmware_sim.physics.sensors import Sensors


class Handling(Sensors):
    """Lets things happen to one axis; SI units at the horn, counter-clockwise positive.

    Parameters
    ----------
    row : memoryview of float
        Its row of the state.
    """

    __slots__ = ()

    def apply_load(self, torque: float) -> None:
        """Load the horn with an external torque against the positive direction, N m."""
        self._set(k.LOAD, torque)

    def connect(self, supply: int) -> None:
        """Hang it on one of the plant's supplies."""
        self._set(k.SUPPLY, float(supply))

    def set_supply(self, voltage: float) -> None:
        """Change the voltage of its supply without current, V, for this axis alone."""
        self._set(k.SOURCE, voltage)
        self._row[k.VOLTAGE] = voltage

    def take_hand(self, angle: float, speed: float, torque: float) -> None:
        """Let a person's hand turn the horn, and hold it there.

        Parameters
        ----------
        angle : float
            Where to, rad.
        speed : float
            As fast as that at most, rad/s.
        torque : float
            With so much at most, N m.
        """
        row = self._row
        self._link()
        row[k.HAND_GOAL], row[k.HAND_SPEED], row[k.HAND_TORQUE] = angle, speed, torque
        row[k.HAND_RATE] = row[k.SPEED]
        row[k.SETTLED] = 0.0

    def let_go(self) -> None:
        """Take the hand away."""
        self._set(k.HAND_TORQUE, 0.0)

    def block(self, low: float = -math.inf, high: float = math.inf) -> None:
        """Let something hard stop the horn, beside what stops it already.

        Parameters
        ----------
        low, high : float
            Angles in rad at which it stops as it turns clockwise, and counter-clockwise; infinity
            for nowhere. One that is past such an angle stops where it is.
        """
        row = self._row
        self._link()
        row[k.STOP_LOW] = max(row[k.STOP_LOW], min(low, self.angle))
        self._set(k.STOP_HIGH, min(row[k.STOP_HIGH], max(high, self.angle)))

    def unblock(self) -> None:
        """Let nothing stop the horn."""
        self._row[k.STOP_LOW] = -math.inf
        self._set(k.STOP_HIGH, math.inf)

    def jam(self, on: bool) -> None:
        """Block the horn, or free it."""
        self._set(k.JAMMED, float(on))

    def stick_encoder(self, on: bool) -> None:
        """Let the encoder count no more, or count again."""
        self._set(k.ENCODER_STUCK, float(on))

    def set_friction(self, factor: float) -> None:
        """Multiply the friction of the gears; 1 is as new."""
        self._set(k.FRICTION_FACTOR, factor)

    def _link(self) -> None:
        if self._row[k.LINK] == k.FREE:
            self._row[k.LINK] = k.LEADS

    def _set(self, column: int, value: float) -> None:
        self._row[column] = value
        self._row[k.SETTLED] = 0.0
