"""One servo: its registers, its torque, its watchdog, its errors.

Source: the e-Manual's X-series pages, section "Control Table Description". Where the manual is
silent: Goal Position keeps what was written while the torque was off, so that a stale goal makes
the servo move at torque-on (seen by users: pollen-robotics/reachy_mini issue 1136); after a boot
it holds the present position. Torque Enable is refused with a result fail after a shutdown. Only
instructions addressed to the servo, or to all, feed its bus watchdog.
"""

from __future__ import annotations

import math
import struct

from firmware_sim.codes import (
    ALERT,
    REVERSE_MODE,
    TIME_BASED_PROFILE,
    TORQUE_ON_BY_GOAL,
    HardwareError,
    OperatingMode,
    StatusError,
)
from firmware_sim.control_table import Area
from firmware_sim.drive import PositionDrive
from firmware_sim.memory import Memory
from firmware_sim.model import ACCELERATION_UNIT, TICKS_PER_TURN, VELOCITY_UNIT, ServoModel
from firmware_sim.motor import STEP, Motor
from firmware_sim.profile import Profile, time_profile, velocity_profile
from firmware_sim.rules import GOAL_NAMES, WATCHDOG_EXPIRED, refusal, split

BOOT_TIME = 0.1
"""How long a servo is deaf after a reboot, s. Not published; drivers in use wait 0.1 to 0.5 s."""

HOMING_LIMIT = 1024
"""A larger Homing Offset(20) is ignored in position mode, ticks (e-Manual, "Homing Offset(20)")."""

_WATCHDOG_UNIT = 0.020
_RETURN_DELAY_UNIT = 2.0e-6
_IN_POSITION = 10.0  # ticks; not published
_FOLLOWING_ERROR = 100.0  # ticks; not published
_PRESENT = struct.Struct("<HBBhhiiiiHB")  # Realtime Tick(120) to Present Temperature(146)
_PRESENT_AT = 120


class Servo:
    """One simulated servo; time is told to it, so it needs no clock.

    Parameters
    ----------
    model : ServoModel
        What it is.
    servo_id : int
        0 to 252.
    start_tick : int
        Where its horn lies at the start, as Present Position reads with the settings given.
    supply_voltage : float, optional
        V; the motor's nominal voltage by default.
    settings : dict of str to int, optional
        EEPROM registers by name that differ from the factory's.
    when : float
        Time of power-up, s.
    """

    def __init__(
        self,
        model: ServoModel,
        servo_id: int,
        start_tick: int = 2048,
        supply_voltage: float | None = None,
        *,
        settings: dict[str, int] | None = None,
        when: float = 0.0,
    ) -> None:
        self.model = model
        self.memory = Memory(model.table)
        self.supply_voltage = supply_voltage or model.motor.nominal_voltage
        for name, value in {**(settings or {}), "ID": servo_id}.items():
            self.memory.store(name, value)
        self._store_identity()
        self._read_settings()
        angle = self._direction * (start_tick - self._offset())
        self.drive = PositionDrive(Motor(model.motor, float(angle), self.supply_voltage))
        self._registered: tuple[int, bytes] | None = None
        self._epoch = when
        self._steps = 0
        self._boot(when, deaf_for=0.0)

    # -- what the protocol asks ---------------------------------------------------------------

    @property
    def alert(self) -> int:
        """The alert bit for a status packet's error field."""
        return ALERT if self.memory.data[70] else 0

    @property
    def moving(self) -> bool:
        """Whether anything about it will change without an instruction, but for its temperature."""
        return not self.drive.settled or self._watchdog_deadline() is not None

    def hears(self, when: float) -> bool:
        """Whether it has booted."""
        return when >= self._deaf_until

    def notice_instruction(self, when: float) -> None:
        """Bring it to `when` (s) and feed its bus watchdog."""
        self.advance(when)
        self._fed_at = when

    def read(self, address: int, size: int, when: float) -> tuple[StatusError, bytes]:
        """Return registers' bytes.

        Parameters
        ----------
        address, size : int
            The range, bytes; holes between registers read 0.
        when : float
            Time, s.

        Returns
        -------
        error : StatusError
            An access error when the range begins in a hole or ends behind the table.
        data : bytes
            Empty with an error.
        """
        self.advance(when)
        end = address + size
        if not size or end > self.model.table.size or self.model.table.at(address) is None:
            return StatusError.ACCESS, b""
        if address < 147 and end > _PRESENT_AT:
            self._refresh(when)
        return StatusError.NONE, bytes(self.memory.data[address:end])

    def write(self, address: int, data: bytes) -> StatusError:
        """Write registers and do what that brings about.

        Parameters
        ----------
        address : int
            Of the first byte.
        data : bytes
            All of it is written, or none with an error.

        Returns
        -------
        StatusError
            See `rules.refusal`.
        """
        error = refusal(self.model, self.memory, address, data)
        if error:
            return error
        if self._shut_down and address <= 64 < address + len(data) and data[64 - address]:
            return StatusError.RESULT_FAIL
        registers = self.model.table.whole_registers(address, len(data)) or ()
        before = {register.name: self.memory.value(register.name) for register in registers}
        self.memory.data[address : address + len(data)] = data
        for register, value in split(registers, address, data):
            self._wrote(register.name, before[register.name], value)
        return StatusError.NONE

    def register_write(self, address: int, data: bytes) -> StatusError:
        """Keep a write for the next action; a later one replaces it."""
        error = refusal(self.model, self.memory, address, data)
        if not error:
            self._registered = (address, data)
            self.memory.store("Registered Instruction", 1)
        return error

    def act(self) -> StatusError:
        """Do the registered write; an instruction error if there is none."""
        if self._registered is None:
            return StatusError.INSTRUCTION
        address, data = self._registered
        self._registered = None
        self.memory.store("Registered Instruction", 0)
        return self.write(address, data)

    def reboot(self, when: float) -> None:
        """Start anew: RAM to its defaults, torque off, deaf for `BOOT_TIME`."""
        self.advance(when)
        self._boot(when, BOOT_TIME)

    def factory_reset(self, when: float, keep_id: bool, keep_baud_rate: bool) -> None:
        """Put the EEPROM to its defaults, then reboot."""
        kept = {"ID": keep_id, "Baud Rate": keep_baud_rate}
        values = {name: self.memory.value(name) for name, keep in kept.items() if keep}
        self.memory.reset(Area.EEPROM)
        self._store_identity()
        for name, value in values.items():
            self.memory.store(name, value)
        self.reboot(when)

    # -- what a test may do -------------------------------------------------------------------

    def raise_hardware_error(self, error: HardwareError) -> None:
        """Let it detect an error; those in Shutdown(63) drop the torque until a reboot.

        Parameters
        ----------
        error : HardwareError
            What it detects.
        """
        self.memory.data[70] |= error
        if error & self.memory.value("Shutdown"):
            self._shut_down = True
            self._set_torque(on=False)

    def apply_load(self, torque: float) -> None:
        """Load the horn with an external torque against the positive direction, N m."""
        self.drive.motor.load_torque = torque
        self.drive.disturb()

    # -- time ---------------------------------------------------------------------------------

    def advance(self, when: float) -> None:
        """Bring it to a time, s; a past one changes nothing."""
        deadline = self._watchdog_deadline()
        if deadline is not None and deadline <= when:
            self._run_to(deadline)
            self._expire()
        self._run_to(when)

    def _run_to(self, when: float) -> None:
        steps = int((when - self._epoch) / STEP + 1e-6) - self._steps
        if steps > 0:
            self._steps += steps
            self.drive.advance(steps)
            if self.drive.motor.temperature > self._temperature_limit:
                self.raise_hardware_error(HardwareError.OVERHEATING)

    def _watchdog_deadline(self) -> float | None:
        value = self.memory.data[98]
        if not self.drive.torque_on or not 0 < value < WATCHDOG_EXPIRED:
            return None
        return self._fed_at + value * _WATCHDOG_UNIT

    def _expire(self) -> None:
        """Stop where the shaft is, and refuse goals from now on."""
        self.memory.data[98] = WATCHDOG_EXPIRED
        self.memory.store("Profile Acceleration", 0)
        self.memory.store("Profile Velocity", 0)
        self.drive.stop()
        self.memory.store("Goal Position", self.position(self.drive.goal))

    # -- positions ----------------------------------------------------------------------------

    def position(self, angle: float) -> int:
        """Return what the position registers show for a shaft angle in ticks."""
        return round(self._direction * angle) + self._shift

    def _angle(self, position: int) -> float:
        return float(self._direction * (position - self._shift))

    def _offset(self) -> int:
        """Homing offset in effect: position mode ignores a large one."""
        offset = self.memory.value("Homing Offset")
        in_position_mode = self.memory.value("Operating Mode") == OperatingMode.POSITION
        return 0 if in_position_mode and abs(offset) > HOMING_LIMIT else offset

    def _fold(self) -> None:
        """Count the position within one turn again."""
        turns = round(self._direction * self.drive.motor.angle) // TICKS_PER_TURN
        self._turn_shift = -turns * TICKS_PER_TURN
        self._shift = self._turn_shift + self._offset()

    # -- what writing brings about ------------------------------------------------------------

    def _wrote(self, name: str, before: int, value: int) -> None:
        if name == "Goal Position":
            self._new_goal()
        elif name == "Torque Enable":
            if value != before:
                self._set_torque(on=bool(value))
        elif name == "Operating Mode":
            if value != before:
                self._switch_mode()
        elif name == "Bus Watchdog":
            pass  # its value is its state
        else:
            self._read_settings()
            self._apply_settings()
        if name in GOAL_NAMES and self._drive_mode & TORQUE_ON_BY_GOAL and not self._shut_down:
            self._set_torque(on=True)

    def _set_torque(self, on: bool) -> None:
        self.memory.store("Torque Enable", int(on))
        if not on:
            self.drive.release()
        elif not self.drive.torque_on:
            if self.memory.value("Operating Mode") == OperatingMode.POSITION:
                self._fold()
            self.drive.engage()
            self._new_goal()

    def _new_goal(self) -> None:
        if self.drive.torque_on:
            self.drive.follow(self._profile_to(self._angle(self.memory.value("Goal Position"))))

    def _profile_to(self, goal: float) -> Profile:
        velocity = self.memory.value("Profile Velocity")
        acceleration = self.memory.value("Profile Acceleration")
        start, speed = self.drive.trajectory, self.drive.trajectory_velocity
        if self._drive_mode & TIME_BASED_PROFILE:
            return time_profile(start, speed, goal, velocity * 1e-3, acceleration * 1e-3)
        return velocity_profile(
            start, speed, goal, velocity * VELOCITY_UNIT, acceleration * ACCELERATION_UNIT
        )

    def _switch_mode(self) -> None:
        """Reset gains, profile and goals as the manual's note on Operating Mode(11) says."""
        table = self.model.table.by_name
        for name in ("Position P Gain", "Position I Gain", "Position D Gain"):
            self.memory.store(name, table[name].default)
        for name in ("Profile Velocity", "Profile Acceleration"):
            self.memory.store(name, 0)
        self._reset_goals()
        if self.memory.value("Operating Mode") == OperatingMode.POSITION:
            self._fold()
        self._read_settings()
        self._apply_settings()

    def _reset_goals(self) -> None:
        pairs = (("Goal PWM", "PWM Limit"), ("Goal Current", "Current Limit"))
        for goal, limit in pairs:
            if goal in self.model.table.by_name:
                self.memory.store(goal, self.memory.value(limit))
        self.memory.store("Goal Velocity", self.memory.value("Velocity Limit"))

    def _read_settings(self) -> None:
        """Copy what is needed often out of the registers."""
        value = self.memory.value
        self.servo_id = value("ID")
        self.baud_rate = self.model.baud_rates[value("Baud Rate")]
        self.return_delay = value("Return Delay Time") * _RETURN_DELAY_UNIT
        self.status_return_level = value("Status Return Level")
        self._temperature_limit = value("Temperature Limit")
        self._drive_mode = value("Drive Mode")
        self._direction = -1 if self._drive_mode & REVERSE_MODE else 1

    def _apply_settings(self) -> None:
        value = self.memory.value
        self._shift = self._turn_shift + self._offset()
        self.drive.pwm_cap = float(abs(value("Goal PWM")))
        self.drive.set_gains(
            value("Position P Gain"), value("Position I Gain"), value("Position D Gain")
        )

    # -- boot and present values --------------------------------------------------------------

    def _store_identity(self) -> None:
        self.memory.store("Model Number", self.model.number)
        self.memory.store("Firmware Version", self.model.firmware)

    def _boot(self, when: float, deaf_for: float) -> None:
        self.memory.reset(Area.RAM)
        self._registered = None
        self._shut_down = False
        self._booted_at = self._fed_at = when
        self._deaf_until = when + deaf_for
        self.drive.release()
        self._reset_goals()
        self._read_settings()
        self._fold()
        self._apply_settings()
        self.memory.store("Goal Position", self.position(self.drive.motor.angle))
        low, high = self.memory.value("Min Voltage Limit"), self.memory.value("Max Voltage Limit")
        if not low <= round(self.supply_voltage * 10.0) <= high:
            self.raise_hardware_error(HardwareError.INPUT_VOLTAGE)

    def _refresh(self, when: float) -> None:
        """Put the present values into registers 120 to 146."""
        drive = self.drive
        motor = drive.motor
        sign = self._direction
        moving = abs(motor.velocity) > self.memory.value("Moving Threshold") * VELOCITY_UNIT
        _PRESENT.pack_into(
            self.memory.data,
            _PRESENT_AT,
            math.floor((when - self._booted_at) * 1e3 + 1e-6) % 32_768,
            1 if moving or drive.under_way else 0,
            self._moving_status(),
            round(sign * drive.pwm),
            self._present_effort(),
            round(sign * motor.velocity / VELOCITY_UNIT),
            self.position(motor.angle),
            round(sign * drive.trajectory_velocity / VELOCITY_UNIT),
            self.position(drive.trajectory),
            round(self.supply_voltage * 10.0),
            min(255, max(0, round(motor.temperature))),
        )

    def _present_effort(self) -> int:
        """Register 126: current, or load where there is no current sensor."""
        motor = self.drive.motor
        if self.model.current_unit is None:
            load = round(self._direction * motor.relative_torque * 1000.0)
            return max(-1000, min(1000, load))
        return round(self._direction * motor.current / self.model.current_unit)

    def _moving_status(self) -> int:
        drive = self.drive
        status = int(drive.kind)
        if drive.under_way:
            status |= 0x02
        elif abs(drive.goal - drive.motor.angle) <= _IN_POSITION:
            status |= 0x01
        if abs(drive.trajectory - drive.motor.angle) > _FOLLOWING_ERROR:
            status |= 0x08
        return status
