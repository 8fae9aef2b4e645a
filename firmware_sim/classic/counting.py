"""From the shaft's angle to what the position registers of the older servos show, and back.

AX and XL-320 measure 300 of 360 degrees with a potentiometer. MX count 4096 ticks a turn; in
multi-turn mode they go on counting over several turns, coarser by the resolution divider and
shifted by the multi-turn offset, which both count in that mode only. The turns are counted in RAM:
a boot begins with the turn that the shaft is in.

Sources: e-Manual, docs/en/dxl/ax/ax-12a, "Goal Position (30)" (its picture has the dead zone);
docs/en/dxl/mx/mx-28, "CW/CCW Angle Limit(6, 8)", "Multi Turn Offset (20)", "Resolution Divider
(22)"; docs/en/dxl/mx/mx-106, "Drive Mode (10)". Where they are silent: in the dead zone the nearer
end is read; on entering multi-turn mode counting begins with the turn that the shaft is in; reverse
mode, outside wheel mode, mirrors a turn onto itself (4095 minus the position).
"""

from __future__ import annotations

import math
from enum import Enum

from firmware_sim.classic.rows import POTENTIOMETER_STEPS, STEP_UNITS
from firmware_sim.firmware.codes import REVERSE_MODE
from firmware_sim.firmware.memory import Memory

_TICKS = 4096
_LAST_STEP = POTENTIOMETER_STEPS - 1
_STEPS_PER_TURN = 2.0 * math.pi / STEP_UNITS.angle
_MULTI_TURN_RANGE = 28_672


class Mode(Enum):
    """What the angle limits (XL-320: Control Mode) choose."""

    JOINT = "joint"
    WHEEL = "wheel"
    MULTI_TURN = "multi-turn"


def mode_of(memory: Memory) -> Mode:
    """Return the mode that the registers choose."""
    if "Control Mode" in memory.table.by_name:
        return Mode.WHEEL if memory.value("Control Mode") == 1 else Mode.JOINT
    limits = memory.value("CW Angle Limit"), memory.value("CCW Angle Limit")
    if limits == (0, 0):
        return Mode.WHEEL
    if limits == (_TICKS - 1, _TICKS - 1):
        return Mode.MULTI_TURN
    return Mode.JOINT


class StepCount:
    """How AX and XL-320 count, in steps of the potentiometer."""

    def update(self) -> None:
        """Nothing to read again: no register changes the count."""

    def fold(self, steps: float) -> None:
        """Nothing to fold: a potentiometer counts no turns."""

    def position(self, steps: float) -> int:
        """Return what Present Position shows for a shaft angle.

        Parameters
        ----------
        steps : float
            From the clockwise end of the range, over all turns.
        """
        over = steps % _STEPS_PER_TURN
        if over > 0.5 * (_STEPS_PER_TURN + _LAST_STEP):
            return 0
        return min(_LAST_STEP, round(over))

    def steps(self, position: int, near: float) -> float:
        """Return the shaft angle in steps that a goal means, in the turn of `near` (steps)."""
        return position + _STEPS_PER_TURN * math.floor(near / _STEPS_PER_TURN)


class TickCount:
    """How MX with protocol 1.0 count, in ticks of the encoder.

    Parameters
    ----------
    memory : Memory
        Its registers.
    """

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._turns = 0
        self._mode = mode_of(memory)
        self._mirrored = False
        self.update()

    def update(self) -> None:
        """Read mode and drive mode again."""
        self._mode = mode_of(self._memory)
        reverse = "Drive Mode" in self._memory.table.by_name and bool(
            self._memory.value("Drive Mode") & REVERSE_MODE
        )
        self._mirrored = reverse and self._mode is not Mode.WHEEL

    def fold(self, steps: float) -> None:
        """Count from the turn on in which the shaft is, at `steps` ticks over all turns."""
        self._turns = math.floor(round(steps) / _TICKS)

    def position(self, steps: float) -> int:
        """Return what Present Position shows for a shaft angle of `steps` ticks over all turns."""
        ticks = self._mirror(round(steps) - self._turns * _TICKS)
        if self._mode is not Mode.MULTI_TURN:
            return int(ticks) % _TICKS
        value = self._memory.value
        count = math.floor(ticks / value("Resolution Divider")) + value("Multi Turn Offset")
        return max(-_MULTI_TURN_RANGE, min(_MULTI_TURN_RANGE, count))

    def steps(self, position: int, near: float) -> float:
        """Return the shaft angle in ticks that a goal means, with the shaft at `near` (ticks)."""
        if self._mode is Mode.MULTI_TURN:
            value = self._memory.value
            ticks = (position - value("Multi Turn Offset")) * value("Resolution Divider")
            return float(self._mirror(ticks) + self._turns * _TICKS)
        turn = math.floor(round(near) / _TICKS)
        return float(self._mirror(position) + turn * _TICKS)

    def _mirror(self, ticks: int) -> int:
        return _TICKS - 1 - ticks if self._mirrored else ticks
