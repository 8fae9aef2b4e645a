"""What goals and operating modes make a servo's motor do.

Source: the e-Manual's X-series pages, "Operating Mode(11)", "Goal PWM(100)" to "Goal
Position(116)", "Profile Acceleration(108)" and "Profile Velocity(112)". Where the manual is silent:

- A goal written while the torque is off stays, so that a stale Goal Position makes the servo move
  at torque-on (seen by users: pollen-robotics/reachy_mini issue 1136).
- A change of the direction in Drive Mode(10) counts positions within a turn anew, with Goal
  Position where the horn is. After one of Homing Offset(20), Goal Position means the angle that it
  meant before: a write to EEPROM moves nothing at torque-on.
- Where Goal Position lies outside the limits of position mode, since they were set later or the
  horn was there at boot, the nearer limit leads. The register stays as it is.
- Gains after a change of mode are the initial ones of the table: the manual gives no other figures
  for a mode.
- Velocity Limit(44) caps the velocity of a velocity-based profile (one state of the manual names
  Profile Velocity(112) beside Goal Velocity(104), a newer one only the latter); neither a step nor
  a time-based profile is capped, since the manual has them end at once or after a given time.
- A slope of the PWM holds for the output of every loop: "PWM Slope(62)" names no mode.
- Where the current is measured at the input, Goal Current and Current Limit are currents there
  too, since a loop can control only what it measures: a stalled horn at a tenth of the stall
  current pushes with the root of a tenth of the stall torque.
- After a boot and a change of mode, Goal Position is where the horn is, and the goal that leads in
  current, velocity and PWM mode is 0, so that nothing turns until one is written. The manual lets
  Goal PWM and Goal Current be their limits after a change of mode; here they are, where they limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from firmware_sim.firmware.codes import (
    CURRENT_MODES,
    POSITION_MODES,
    TIME_BASED_PROFILE,
    TORQUE_ON_BY_GOAL,
    OperatingMode,
)
from firmware_sim.firmware.frame import PositionFrame
from firmware_sim.firmware.gains import GAIN_NAMES, set_gains
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.rules import ACCELERATION_LIMIT, LIMITED_BY
from firmware_sim.physics.axis import Axis
from firmware_sim.physics.profile import Profile, time_profile, velocity_profile

_MILLISECOND = 1.0e-3

_LEADING_GOAL: dict[int, str] = {
    OperatingMode.CURRENT: "Goal Current",
    OperatingMode.VELOCITY: "Goal Velocity",
    OperatingMode.PWM: "Goal PWM",
}
"""The goal that leads in a mode without position control."""


class Actuator:
    """Registers on one side, a driven axis on the other.

    Parameters
    ----------
    model : ServoModel
        What it is.
    memory : Memory
        Its registers, with their EEPROM values in place.
    axis : Axis
        What it drives.
    """

    def __init__(self, model: ServoModel, memory: Memory, axis: Axis) -> None:
        self._memory = memory
        self._slope_unit = model.pwm_slope_unit
        self._units = model.units
        self._current_unit = model.current_unit or 0.0
        self.axis = axis
        self.frame = PositionFrame(memory, model.units)
        self._lead_by_mode: dict[int, Callable[[], None]] = {
            OperatingMode.CURRENT: self._lead_current,
            OperatingMode.VELOCITY: self._lead_velocity,
            OperatingMode.PWM: self._lead_pwm,
        }
        self._counted = self.frame.direction, self.frame.shift
        """How positions counted when Goal Position was last brought in line with it."""
        self._read_mode()

    def boot(self) -> None:
        """Begin with the registers as a boot leaves them: torque off, nothing to be done."""
        self.axis.release()
        self.frame.update()
        self.frame.fold(self.axis.ticks)
        self.reset_goals()
        self.take_settings()

    def take_settings(self) -> None:
        """Read mode, gains, limits and counting again."""
        self._read_mode()
        self.frame.update()
        set_gains(self.axis, self._memory, self._units)
        if self._slope_unit is not None:
            self.axis.set_slope(self._memory.value("PWM Slope") * self._slope_unit)
        self.take_caps()

    def count_anew(self) -> None:
        """Let Goal Position follow where the direction or the offset of positions has changed."""
        direction, shift = self._counted
        if self.frame.direction != direction:
            self.frame.fold(self.axis.ticks)
            self._store_position(self.axis.angle)
        elif self.frame.shift != shift:
            goal = self._memory.value("Goal Position")
            self._memory.store("Goal Position", goal + self.frame.shift - shift)
            self._counted = direction, self.frame.shift

    def take_caps(self) -> None:
        """Read again what caps duty and current."""
        value = self._memory.value
        pwm = value("PWM Limit" if self._mode == OperatingMode.PWM else "Goal PWM")
        current = math.inf
        if self._mode in CURRENT_MODES:
            leads = self._mode == OperatingMode.CURRENT
            current = abs(value("Current Limit" if leads else "Goal Current")) * self._current_unit
        self.axis.set_caps(abs(pwm) / self._units.pwm_full, current)

    def set_torque(self, on: bool) -> None:
        """Switch the torque, and start for the goal when it goes on."""
        self._memory.store("Torque Enable", int(on))
        if not on:
            self.axis.release()
        elif not self.axis.torque_on:
            if self._mode == OperatingMode.POSITION:
                self.frame.fold(self.axis.ticks)
                self._counted = self.frame.direction, self.frame.shift
            self.axis.hold()
            self.lead()

    def lead(self) -> None:
        """Go for the goal of the mode, if the torque is on."""
        if self.axis.torque_on:
            self._lead()

    def switch_mode(self) -> None:
        """Do what a new Operating Mode(11) does: gains, profile and goals start anew."""
        table = self._memory.table
        for name in GAIN_NAMES:
            self._memory.store(name, table[name].default)
        for name in ("Profile Velocity", "Profile Acceleration"):
            self._memory.store(name, 0)
        self.take_settings()
        if self._mode in (OperatingMode.POSITION, OperatingMode.EXTENDED_POSITION):
            self.frame.fold(self.axis.ticks)
        self.reset_goals()
        self.take_settings()

    def reset_goals(self) -> None:
        """Put goals that limit to their limits, and goals that lead to rest."""
        for goal, limit in LIMITED_BY.items():
            if goal in self._memory.table.by_name:
                self._memory.store(goal, self._memory.value(limit))
        leading = _LEADING_GOAL.get(self._memory.value("Operating Mode"))
        if leading is not None:
            self._memory.store(leading, 0)
        self._store_position(self.axis.angle)

    def keep_goals_within_limits(self) -> None:
        """Bring goals within limits that were lowered."""
        for goal, limit in LIMITED_BY.items():
            if goal in self._memory.table.by_name:
                most = self._memory.value(limit)
                kept = max(-most, min(most, self._memory.value(goal)))
                self._memory.store(goal, kept)
        if ACCELERATION_LIMIT in self._memory.table.by_name:
            value, most = map(self._memory.value, ("Profile Acceleration", ACCELERATION_LIMIT))
            self._memory.store("Profile Acceleration", min(value, most))

    def stop(self) -> None:
        """Stop, and hold if there is position control."""
        leading = _LEADING_GOAL.get(self._mode)
        if leading is None:
            self.axis.hold()
            self._store_position(self.axis.reference_goal)
        else:
            self._memory.store(leading, 0)
            self.lead()

    def clear_turns(self) -> None:
        """Count positions from the present turn on; goals keep meaning the same angle."""
        goal = self.frame.angle(self._memory.value("Goal Position"))
        self.frame.fold(self.axis.ticks)
        self._store_position(goal)

    def _read_mode(self) -> None:
        self._mode = self._memory.value("Operating Mode")
        self.in_position_mode = self._mode in POSITION_MODES
        self.leading_goal = _LEADING_GOAL.get(self._mode, "Goal Position")
        """The goal of which a new value is something to go for."""
        self._lead = self._lead_by_mode.get(self._mode, self._lead_position)
        drive_mode = self._memory.value("Drive Mode")
        self._time_based = bool(drive_mode & TIME_BASED_PROFILE)
        self.torque_on_by_goal = bool(drive_mode & TORQUE_ON_BY_GOAL)

    def _store_position(self, angle: float) -> None:
        self._memory.store("Goal Position", self.frame.position(angle))
        self._counted = self.frame.direction, self.frame.shift

    def _lead_position(self) -> None:
        value = self._memory.value
        goal = value("Goal Position")
        if self._mode == OperatingMode.POSITION:
            low, high = value("Min Position Limit"), value("Max Position Limit")
            goal = max(low, min(high, goal))
        angle = self.frame.angle(goal)
        velocity = value("Profile Velocity")
        if velocity:
            self.axis.follow(self._profile(angle, velocity, value("Profile Acceleration")))
        else:
            self.axis.step_to(angle)

    def _profile(self, angle: float, velocity: int, acceleration: int) -> Profile:
        start, speed = self.axis.reference, self.axis.reference_velocity
        if self._time_based:
            return time_profile(
                start, speed, angle, velocity * _MILLISECOND, acceleration * _MILLISECOND
            )
        units = self._units
        most = min(velocity, self._memory.value("Velocity Limit") or velocity)  # 0 would be a step
        return velocity_profile(
            start, speed, angle, most * units.velocity, acceleration * units.acceleration
        )

    def _lead_velocity(self) -> None:
        value = self._memory.value
        speed = self.frame.direction * value("Goal Velocity") * self._units.velocity
        ramp = value("Profile Acceleration")
        acceleration = ramp * self._units.acceleration
        if self._time_based and ramp:
            acceleration = abs(speed - self.axis.reference_velocity) / (ramp * _MILLISECOND)
        self.axis.drive_velocity(speed, acceleration)

    def _lead_current(self) -> None:
        goal = self._memory.value("Goal Current")
        self.axis.drive_current(self.frame.direction * goal * self._current_unit)

    def _lead_pwm(self) -> None:
        goal = self._memory.value("Goal PWM")
        self.axis.drive_duty(self.frame.direction * goal / self._units.pwm_full)
