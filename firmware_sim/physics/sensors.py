"""What can be sensed of an axis; SI units at the horn, counter-clockwise positive."""

from __future__ import annotations

from firmware_sim.physics import kernel as k
from firmware_sim.physics.profile import ProfileType

_KINDS = {float(kind): kind for kind in ProfileType}


class Sensors:
    """Reads one axis.

    Parameters
    ----------
    row : memoryview of float
        Its row of the state.
    """

    __slots__ = ("_row",)

    def __init__(self, row: memoryview[float]) -> None:
        self._row = row

    @property
    def angle(self) -> float:
        """Of the horn, rad, over all turns."""
        return self._row[k.ANGLE]

    @property
    def ticks(self) -> int:
        """The angle as the encoder counts it, over all turns."""
        return int(self._row[k.TICKS])

    @property
    def measured_angle(self) -> float:
        """Of the horn, as the encoder counts it, rad."""
        return self._row[k.TICKS] * self._row[k.ENCODER_STEP]

    @property
    def velocity(self) -> float:
        """Of the horn, rad/s."""
        return self._row[k.SPEED]

    @property
    def current(self) -> float:
        """Through the winding, mean of the last step, A."""
        return self._row[k.AMPERES]

    @property
    def duty(self) -> float:
        """Of the PWM, -1 to 1."""
        return self._row[k.EFFORT]

    @property
    def temperature(self) -> float:
        """Of the winding, degrees Celsius."""
        return self._row[k.TEMPERATURE]

    @property
    def voltage(self) -> float:
        """At the terminals, V."""
        return self._row[k.VOLTAGE]

    @property
    def reference(self) -> float:
        """Angle of the trajectory, rad; the horn's own where there is none."""
        return self._row[k.REFERENCE]

    @property
    def reference_velocity(self) -> float:
        """Velocity of the trajectory, rad/s."""
        return self._row[k.REFERENCE_SPEED]

    @property
    def reference_goal(self) -> float:
        """Where the trajectory ends, rad."""
        return self._row[k.GOAL]

    @property
    def under_way(self) -> bool:
        """Whether a profile or a ramp of the velocity is in progress."""
        return self._row[k.UNDER_WAY] != 0.0

    @property
    def kind(self) -> ProfileType:
        """Shape of the last profile."""
        return _KINDS[self._row[k.KIND]]

    @property
    def saturated_for(self) -> float:
        """For how long it has nearly stood, or gone back, with duty or current at their caps, s."""
        return self._row[k.SATURATED_FOR]

    @property
    def settled(self) -> bool:
        """Whether nothing will happen until the next command.

        An axis at full effort against something has not settled: its firmware may yet give up.
        """
        return self._row[k.SETTLED] != 0.0 and self._row[k.SATURATED_FOR] == 0.0

    @property
    def torque_on(self) -> bool:
        """Whether the motor is driven."""
        return self._row[k.MODE] != k.OFF

    @property
    def sensed_current(self) -> float:
        """What its electronics measure, A: the winding's, or that taken from the supply.

        The latter has the sign of the former: the way of the torque.
        """
        amperes = self._row[k.AMPERES]
        return abs(self._row[k.EFFORT]) * amperes if self._row[k.SENSES_INPUT] else amperes
