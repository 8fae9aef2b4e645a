"""PWM Slope(62) of the 330 series: how fast the PWM may change.

Source: e-Manual, XL330 pages, "PWM Slope(62)": 1.977 mV/ms a count; at 140 and 5 V, full PWM is
reached from nothing in 18 ms. Modelled in PWM mode; in the other modes the controllers change the
PWM at once.
"""

from __future__ import annotations

import math

from firmware_sim.memory import Memory
from firmware_sim.model import ServoModel
from firmware_sim.physics.axis import Axis
from firmware_sim.physics.kernel import STEP
from firmware_sim.timeline import Timeline

UNIT = 1.977e-3
"""Of the register, V per step of 1 ms."""


class PwmSlope:
    """Leads the duty of an axis to a goal, at once on models without the register.

    Parameters
    ----------
    model : ServoModel
        What it is.
    memory : Memory
        Its registers.
    axis : Axis
        What is driven.
    timeline : Timeline
        The time.
    """

    def __init__(self, model: ServoModel, memory: Memory, axis: Axis, timeline: Timeline) -> None:
        self._memory = memory
        self._axis = axis
        self._timeline = timeline
        self._exists = "PWM Slope" in model.table.by_name
        self._nominal_voltage = model.motor.nominal_voltage
        self._duty = 0.0
        self._goal = 0.0
        self.next_event = math.inf
        """When the duty changes next, s."""

    def drive_to(self, duty: float) -> None:
        """Lead the duty to a new goal, -1 to 1."""
        self._goal = duty
        self._duty = self._axis.duty if self._exists else duty
        self.wake()

    def end(self) -> None:
        """Leave the duty to others."""
        self.next_event = math.inf

    def wake(self) -> None:
        """Change the duty by as much as one step allows."""
        step = math.inf
        if self._exists:
            step = self._memory.value("PWM Slope") * UNIT / self._nominal_voltage
        way = self._goal - self._duty
        self._duty = self._goal if abs(way) <= step else self._duty + math.copysign(step, way)
        self._axis.drive_duty(self._duty)
        self.next_event = math.inf
        if self._duty != self._goal:
            self.next_event = self._timeline.now + STEP
            self._timeline.wake_at(self.next_event)
