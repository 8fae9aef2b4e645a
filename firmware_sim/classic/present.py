"""The present values of the older servos, measured when somebody reads them.

Sources: e-Manual, docs/en/dxl/ax/ax-12a, docs/en/dxl/mx/mx-28 and mx-106, docs/en/dxl/x/xl320,
"Present Position" to "Realtime Tick". Load is the output ("inferred from the internal output
value"): clockwise output reads with bit 10, as the maker reports it (dynamixel-workbench issue 27).
Where they are silent or vague: in the wheel mode that controls the output, Present Speed is in
0.1 % of the no-load speed; Moving is 1 for a profile or a speed of a count and more; while the
torque is off, Goal Position reads where the servo is, so that nothing moves at torque-on (the
maker, of RX-28 with firmware 23, www.robotis.com/xe/24472).
"""

from __future__ import annotations

import math
from collections.abc import Callable

from firmware_sim.classic.motion import Motion, with_direction
from firmware_sim.classic.rows import FULL_SCALE
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.timeline import Timeline, realtime_tick

_CURRENT_AT_REST = 2048


class Present:
    """What can be measured of one servo.

    Parameters
    ----------
    model : ServoModel
        What it is.
    memory : Memory
        Its registers.
    motion : Motion
        What moves.
    timeline : Timeline
        The time.
    """

    def __init__(
        self, model: ServoModel, memory: Memory, motion: Motion, timeline: Timeline
    ) -> None:
        self._model = model
        self._memory = memory
        self._motion = motion
        self._axis = motion.axis
        self._timeline = timeline
        self.booted_at = timeline.now
        """When it began to count time, s."""
        self.by_name: dict[str, Callable[[], int]] = {
            "Goal Position": self._goal,
            "Present Position": lambda: self._motion.position,
            "Present Speed": self._speed,
            "Present Load": lambda: with_direction(self._axis.duty * FULL_SCALE),
            "Present Voltage": lambda: min(255, round(self._axis.voltage * 10.0)),
            "Present Temperature": lambda: min(255, round(self._axis.temperature)),
            "Moving": self._moving,
            "Realtime Tick": self._realtime_tick,
            "Current": self._current,
        }
        """What measures a register, by its name."""

    def _goal(self) -> int:
        if not self._memory.value("Torque Enable"):
            return self._motion.position
        return self._memory.value("Goal Position")

    def _speed(self) -> int:
        unit = self._model.units.velocity
        if self._motion.is_output_wheel:
            unit = self._model.motor.no_load_speed * 2.0 * math.pi / 60.0 / FULL_SCALE
        return with_direction(self._axis.velocity / unit)

    def _moving(self) -> int:
        fast = abs(self._axis.velocity) >= self._model.units.velocity
        return int(self._axis.under_way or (self._axis.torque_on and fast))

    def _realtime_tick(self) -> int:
        return realtime_tick(self._timeline.now - self.booted_at)

    def _current(self) -> int:
        unit = self._model.current_unit or 1.0
        count = _CURRENT_AT_REST + round(self._axis.current / unit)
        return max(0, min(2 * _CURRENT_AT_REST - 1, count))
