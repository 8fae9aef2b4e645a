"""What a servo's registers make its motor do.

Source: the e-Manual's X-series pages, "Control Table Description". Where the manual is silent: a
goal written while the torque is off stays in Goal Position, so that a stale one makes the servo
move at torque-on (seen by users: pollen-robotics/reachy_mini issue 1136).
"""

from __future__ import annotations

from firmware_sim.codes import TIME_BASED_PROFILE, HardwareError
from firmware_sim.drive import PositionDrive
from firmware_sim.frame import PositionFrame
from firmware_sim.memory import Memory
from firmware_sim.model import ACCELERATION_UNIT, VELOCITY_UNIT, ServoModel
from firmware_sim.motor import Motor
from firmware_sim.profile import Profile, time_profile, velocity_profile

_POSITION_GAINS = ("Position P Gain", "Position I Gain", "Position D Gain")
_MILLISECOND = 1.0e-3


class Actuator:
    """Registers on one side, a driven motor on the other.

    Parameters
    ----------
    model : ServoModel
        What it is.
    memory : Memory
        Its registers, with their EEPROM values in place.
    start_tick : int
        Where its horn lies, as Present Position reads with those values.
    supply_voltage : float
        V.
    """

    def __init__(
        self, model: ServoModel, memory: Memory, start_tick: int, supply_voltage: float
    ) -> None:
        self._memory = memory
        self.supply_voltage = supply_voltage
        self.frame = PositionFrame(memory)
        self.drive = PositionDrive(Motor(model.motor, self.frame.angle(start_tick), supply_voltage))
        self.shut_down = False
        """Whether a hardware error has taken the torque away until a reboot."""

    def boot(self) -> None:
        """Begin with the registers as a boot leaves them: torque off, goal where the horn is."""
        self.shut_down = False
        self.drive.release()
        self.reset_goals()
        self.frame.fold(self.drive.motor.angle)
        self.take_settings()
        self._memory.store("Goal Position", self.frame.position(self.drive.motor.angle))
        tenths = round(self.supply_voltage * 10.0)
        value = self._memory.value
        if not value("Min Voltage Limit") <= tenths <= value("Max Voltage Limit"):
            self.raise_hardware_error(HardwareError.INPUT_VOLTAGE)

    def take_settings(self) -> None:
        """Read gains, limits and counting again."""
        value = self._memory.value
        self.frame.update()
        self.drive.pwm_cap = float(abs(value("Goal PWM")))
        proportional, integral, derivative = (value(name) for name in _POSITION_GAINS)
        self.drive.set_gains(proportional, integral, derivative)

    def set_torque(self, on: bool) -> None:
        """Switch the torque, and start for the goal when it goes on."""
        self._memory.store("Torque Enable", int(on))
        if not on:
            self.drive.release()
        elif not self.drive.torque_on:
            if self.frame.in_position_mode:
                self.frame.fold(self.drive.motor.angle)
            self.drive.engage()
            self.start_for_goal()

    def start_for_goal(self) -> None:
        """Make a profile to Goal Position, if the torque is on."""
        if self.drive.torque_on:
            self.drive.follow(self._profile_to(self._memory.value("Goal Position")))

    def _profile_to(self, goal: int) -> Profile:
        angle = self.frame.angle(goal)
        velocity = self._memory.value("Profile Velocity")
        acceleration = self._memory.value("Profile Acceleration")
        start, speed = self.drive.trajectory, self.drive.trajectory_velocity
        if self._memory.value("Drive Mode") & TIME_BASED_PROFILE:
            return time_profile(
                start, speed, angle, velocity * _MILLISECOND, acceleration * _MILLISECOND
            )
        return velocity_profile(
            start, speed, angle, velocity * VELOCITY_UNIT, acceleration * ACCELERATION_UNIT
        )

    def switch_mode(self) -> None:
        """Do what a new Operating Mode(11) does: gains, profile and goals start anew."""
        by_name = self._memory.table.by_name
        for name in _POSITION_GAINS:
            self._memory.store(name, by_name[name].default)
        for name in ("Profile Velocity", "Profile Acceleration"):
            self._memory.store(name, 0)
        self.reset_goals()
        if self.frame.in_position_mode:
            self.frame.fold(self.drive.motor.angle)
        self.take_settings()

    def reset_goals(self) -> None:
        """Put Goal PWM, Goal Current and Goal Velocity to their limits."""
        value = self._memory.value
        self._memory.store("Goal PWM", value("PWM Limit"))
        if "Goal Current" in self._memory.table.by_name:
            self._memory.store("Goal Current", value("Current Limit"))
        self._memory.store("Goal Velocity", value("Velocity Limit"))

    def stop(self) -> None:
        """Stop where the horn is, and hold there."""
        self.drive.stop()
        self._memory.store("Goal Position", self.frame.position(self.drive.goal))

    def advance(self, steps: int) -> None:
        """Go on by a number of steps of physics."""
        self.drive.advance(steps)
        if self.drive.motor.temperature > self._memory.value("Temperature Limit"):
            self.raise_hardware_error(HardwareError.OVERHEATING)

    def raise_hardware_error(self, error: HardwareError) -> None:
        """Set a bit of Hardware Error Status(70); if Shutdown(63) has it too, drop the torque."""
        status = self._memory.value("Hardware Error Status")
        self._memory.store("Hardware Error Status", status | error)
        if error & self._memory.value("Shutdown") and not self.shut_down:
            self.shut_down = True
            self.set_torque(on=False)
