"""From the shaft's angle to what the position registers show, and back.

Source: e-Manual, "Homing Offset(20)", "Drive Mode(10)" and the note on Present Position in
"Operating Mode(11)": present position = actual position + homing offset; the actual position runs
over many turns, and is folded into one (0 to 4095) at a boot, on a change to position mode, and on
torque-on in position mode. Reverse mode turns the actual position's sign, not the offset's.
"""

from __future__ import annotations

from firmware_sim.codes import REVERSE_MODE, OperatingMode
from firmware_sim.memory import Memory
from firmware_sim.model import TICKS_PER_TURN

HOMING_LIMIT = 1024
"""A larger homing offset is ignored in position mode, ticks."""


class PositionFrame:
    """How one servo counts positions.

    Parameters
    ----------
    memory : Memory
        Its registers.
    """

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._turns = 0
        self.direction = 1
        """-1 in reverse mode; the sign of velocity, current and PWM too."""
        self._shift = 0
        self.update()

    @property
    def in_position_mode(self) -> bool:
        """Whether positions are within one turn, operating mode 3."""
        return self._memory.value("Operating Mode") == OperatingMode.POSITION

    def update(self) -> None:
        """Read drive mode, operating mode and homing offset again."""
        self.direction = -1 if self._memory.value("Drive Mode") & REVERSE_MODE else 1
        offset = self._memory.value("Homing Offset")
        if self.in_position_mode and abs(offset) > HOMING_LIMIT:
            offset = 0
        self._shift = offset - self._turns * TICKS_PER_TURN

    def fold(self, angle: float) -> None:
        """Count from the turn on in which the shaft is.

        Parameters
        ----------
        angle : float
            Of the shaft, ticks.
        """
        self._turns = round(self.direction * angle) // TICKS_PER_TURN
        self.update()

    def position(self, angle: float) -> int:
        """Return what a position register shows for a shaft angle in ticks."""
        return round(self.direction * angle) + self._shift

    def angle(self, position: int) -> float:
        """Return the shaft angle, ticks, that a position register's value means."""
        return float(self.direction * (position - self._shift))
