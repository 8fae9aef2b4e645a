"""The measured values in registers 120 to 146, each made when somebody reads it.

Source: e-Manual, "Realtime Tick(120)" to "Present Temperature(146)", "External Port Data(152)". The
manual does not say how near counts as in position, nor how far as a following error: see the
constants. In position is near Goal Position(116), torque or not. Present Load(126) is the output's
duty: "inferred based on the internal output value; not measured" ("Present Load(126)").
"""

from __future__ import annotations

from collections.abc import Callable

from firmware_sim.firmware.actuator import Actuator
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.rules import PORT_OUTPUT
from firmware_sim.firmware.timeline import Timeline, realtime_tick

IN_POSITION = 10
"""Distance to the goal that counts as in position, ticks."""

FOLLOWING_ERROR = 100
"""Distance to the trajectory that counts as a following error, ticks."""

_ONGOING = 0x02
_REACHED = 0x01
_FOLLOWING = 0x08
_PULLED_UP = 2
_LARGEST_LOAD = 1000


class Present:
    """The measured values of one servo.

    Parameters
    ----------
    model : ServoModel
        Whose they are.
    memory : Memory
        Its settings.
    actuator : Actuator
        What they are read from.
    timeline : Timeline
        The time.
    """

    def __init__(
        self, model: ServoModel, memory: Memory, actuator: Actuator, timeline: Timeline
    ) -> None:
        self._memory = memory
        self._actuator = actuator
        self._axis = actuator.axis
        self._frame = actuator.frame
        self._timeline = timeline
        self._pwm = float(model.units.pwm_full)
        self._per_velocity = 1.0 / model.units.velocity
        self._velocity_unit = model.units.velocity
        self._per_ampere = 1.0 / model.current_unit if model.current_unit else 0.0
        self.booted_at = timeline.now
        """When it began, s."""
        self._measures: dict[str, Callable[[], int]] = {
            "Realtime Tick": self._realtime_tick,
            "Moving": self._moving,
            "Moving Status": self._moving_status,
            "Present PWM": self._present_pwm,
            "Present Current": self._present_current,
            "Present Load": self._present_load,
            "Present Velocity": self._present_velocity,
            "Present Position": self._present_position,
            "Velocity Trajectory": self._velocity_trajectory,
            "Position Trajectory": self._position_trajectory,
            "Present Input Voltage": self._present_input_voltage,
            "Present Temperature": self._present_temperature,
        }
        for number in (1, 2, 3):
            name = f"External Port Data {number}"
            if name in model.table.by_name:
                self._measures[name] = self._port(number)

    def measure(self, name: str) -> Callable[[], int] | None:
        """Return what measures a register, None if it reads what was stored."""
        return self._measures.get(name)

    def _realtime_tick(self) -> int:
        return realtime_tick(self._timeline.now - self.booted_at)

    def _moving(self) -> int:
        threshold = self._memory.value("Moving Threshold") * self._velocity_unit
        return int(abs(self._axis.velocity) > threshold or self._axis.under_way)

    def _moving_status(self) -> int:
        axis = self._axis
        status = int(axis.kind)
        if axis.under_way:
            status |= _ONGOING
        if self._actuator.in_position_mode:
            position = self._present_position()
            away = abs(self._memory.value("Goal Position") - position)
            if not axis.under_way and away <= IN_POSITION:
                status |= _REACHED
            if abs(self._frame.position(axis.reference) - position) > FOLLOWING_ERROR:
                status |= _FOLLOWING
        return status

    def _present_pwm(self) -> int:
        return round(self._frame.direction * self._axis.duty * self._pwm)

    def _present_current(self) -> int:
        return round(self._frame.direction * self._axis.sensed_current * self._per_ampere)

    def _present_load(self) -> int:
        return round(self._frame.direction * self._axis.duty * _LARGEST_LOAD)

    def _present_velocity(self) -> int:
        return round(self._frame.direction * self._axis.velocity * self._per_velocity)

    def _present_position(self) -> int:
        frame = self._frame
        return frame.direction * self._axis.ticks + frame.shift

    def _velocity_trajectory(self) -> int:
        return round(self._frame.direction * self._axis.reference_velocity * self._per_velocity)

    def _position_trajectory(self) -> int:
        if not self._actuator.in_position_mode:
            return self._present_position()
        return self._frame.position(self._axis.reference)

    def _present_input_voltage(self) -> int:
        return round(self._axis.voltage * 10.0)

    def _present_temperature(self) -> int:
        return round(self._axis.temperature)

    def _port(self, number: int) -> Callable[[], int]:
        """Return what reads an external port with nothing attached: pull-ups read 1."""
        mode_name, data_name = f"External Port Mode {number}", f"External Port Data {number}"

        def read() -> int:
            mode = self._memory.value(mode_name)
            if mode == PORT_OUTPUT:
                return self._memory.value(data_name)
            return int(mode == _PULLED_UP)

        return read
