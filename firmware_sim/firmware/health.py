"""What a servo notices of its own state, and when it shuts down.

Source: e-Manual, "Shutdown(63)" and "Hardware Error Status(70)"; bits are set when an error is
noticed, and only a reboot clears them. The manual says what is noticed, not how: thresholds and
times below are chosen.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from types import MappingProxyType

from firmware_sim.firmware.codes import HardwareError
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.timeline import Timeline
from firmware_sim.physics.axis import Axis

OVERLOAD_TIME = 2.0
"""How long full effort (`kernel.FULL_EFFORT`) may be put on a standing horn, s."""

VOLTAGE_TIME = 0.1
"""How long the input voltage may be outside its limits, s."""

SHOCK_TIME = 0.02
"""How long the voltage may be too low for the motor's electronics with the torque on, s."""

SHOCK_SHARE = 0.75
"""Of the lowest settable Min Voltage Limit: below that the electronics fail."""

ENCODER_TIME = 0.1
"""How long the encoder may be off, s."""

ENCODER_SLACK = 20
"""How far the encoder may be off, ticks."""

_ROUNDING = 1e-9

PROTOCOL_1_BITS = MappingProxyType(
    {
        HardwareError.INPUT_VOLTAGE: 0x01,
        HardwareError.OVERHEATING: 0x04,
        HardwareError.OVERLOAD: 0x20,
    }
)
"""How errors show in the error byte of protocol 1.0."""


class Health:
    """The errors of one servo of the X series.

    Parameters
    ----------
    model : ServoModel
        What it is.
    memory : Memory
        Its registers.
    axis : Axis
        What it drives.
    timeline : Timeline
        The time.
    drop_torque : callable
        Switches the torque off.
    """

    def __init__(
        self,
        model: ServoModel,
        memory: Memory,
        axis: Axis,
        timeline: Timeline,
        drop_torque: Callable[[], None],
    ) -> None:
        self._timeline = timeline
        self._memory = memory
        self._axis = axis
        self._tick = model.units.angle
        self._slack = ENCODER_SLACK * self._tick
        self._detects = model.detects
        self._drop_torque = drop_torque
        self._shock_voltage = SHOCK_SHARE * 0.1 * model.table["Min Voltage Limit"].minimum
        self.status = 0
        """Hardware Error Status(70)."""
        self.shut_down = False
        """Whether an error has taken the torque away until a reboot."""
        self.next_look = math.inf
        """When what was seen will have lasted long enough to be an error, s."""
        self._since: dict[HardwareError, float] = {}

    @property
    def protocol_1_bits(self) -> int:
        """The error byte of protocol 1.0."""
        return sum(bit for error, bit in PROTOCOL_1_BITS.items() if self.status & error)

    def boot(self) -> None:
        """Forget all errors, and look at once at what is wrong all the time."""
        self.status = 0
        self.shut_down = False
        self._since.clear()
        self.next_look = math.inf
        self.take_settings()
        if not self._low <= self._axis.voltage <= self._high:
            self.raise_error(HardwareError.INPUT_VOLTAGE)

    def take_settings(self) -> None:
        """Read the limits again."""
        value = self._memory.value
        # Half a count: the register shows the voltage rounded, and is what limits are set by.
        self._low = 0.1 * value("Min Voltage Limit") - 0.05
        self._high = 0.1 * value("Max Voltage Limit") + 0.05
        self._hottest = value("Temperature Limit")
        self._axis.watch(self._hottest, self._low, self._high, self._slack)

    def raise_error(self, error: HardwareError) -> None:
        """Set a bit of Hardware Error Status(70); if Shutdown(63) has it too, drop the torque.

        An error that the model does not detect is passed over.
        """
        if not error & self._detects:
            return
        self.status |= error
        self._memory.store("Hardware Error Status", self.status)
        if error & self._memory.value("Shutdown") and not self.shut_down:
            self.shut_down = True
            self._drop_torque()

    def inspect(self) -> None:
        """Look for causes of errors."""
        axis, now = self._axis, self._timeline.now
        self.next_look = math.inf
        if axis.temperature > self._hottest:
            self.raise_error(HardwareError.OVERHEATING)
        if axis.saturated_for >= OVERLOAD_TIME:
            self.raise_error(HardwareError.OVERLOAD)
        voltage = axis.voltage
        low = voltage < self._low
        self._notice(HardwareError.INPUT_VOLTAGE, low or voltage > self._high, now, VOLTAGE_TIME)
        shocked = low and voltage < self._shock_voltage and axis.torque_on
        self._notice(HardwareError.ELECTRICAL_SHOCK, shocked, now, SHOCK_TIME)
        lost = abs(axis.angle - axis.ticks * self._tick) > self._slack
        self._notice(HardwareError.MOTOR_ENCODER, lost, now, ENCODER_TIME)

    def _notice(self, error: HardwareError, there: bool, now: float, patience: float) -> None:
        """Raise an error whose cause has lasted."""
        if not there:
            if self._since:
                self._since.pop(error, None)
        elif now - self._since.setdefault(error, now) >= patience - _ROUNDING:
            self.raise_error(error)
        else:
            self.next_look = min(self.next_look, self._since[error] + patience)
            self._timeline.wake_at(self.next_look)
