"""From the shaft's angle to what the position registers show, and back.

Source: e-Manual, "Homing Offset(20)", "Drive Mode(10)" and the note on Present Position in
"Operating Mode(11)": present position = actual position + homing offset; the actual position runs
over many turns, and is folded into one (0 to 4095) at a boot, on a change to position mode, and on
torque-on in position mode; "Goal Position(116)" adds a change to extended position mode. Reverse
mode turns the actual position's sign, not the offset's.
"""

from __future__ import annotations

from firmware_sim.firmware.codes import REVERSE_MODE, OperatingMode
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import Units

HOMING_LIMIT = 1024
"""A larger homing offset is ignored in position mode, ticks."""


class PositionFrame:
    """How one servo counts positions.

    Parameters
    ----------
    memory : Memory
        Its registers.
    units : Units
        Of them.
    """

    def __init__(self, memory: Memory, units: Units) -> None:
        self._memory = memory
        self._tick = units.angle
        self._ticks_per_turn = units.ticks_per_turn
        self._turns = 0
        self.direction = 1
        """-1 in reverse mode; the sign of velocity, current and PWM too."""
        self.shift = 0
        """What is added to the actual position, ticks."""
        self.update()

    def update(self) -> None:
        """Read drive mode, operating mode and homing offset again."""
        value = self._memory.value
        self.direction = -1 if value("Drive Mode") & REVERSE_MODE else 1
        offset = value("Homing Offset")
        if value("Operating Mode") == OperatingMode.POSITION and abs(offset) > HOMING_LIMIT:
            offset = 0
        self.shift = offset - self._turns * self._ticks_per_turn

    def fold(self, ticks: int) -> None:
        """Count from the turn on in which the encoder is, given its count."""
        self._turns = self.direction * ticks // self._ticks_per_turn
        self.update()

    def position(self, angle: float) -> int:
        """Return what a position register shows for a shaft angle in rad."""
        return round(self.direction * angle / self._tick) + self.shift

    def angle(self, position: int) -> float:
        """Return the shaft angle, rad, that a position register's value means."""
        return self.direction * (position - self.shift) * self._tick
