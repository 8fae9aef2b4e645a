"""One servo as the protocol sees it: registers to read and write, and time that passes.

Source: the e-Manual's X-series pages, "Control Table Description". Where the manual is silent: a
read may span holes between registers, which read 0, but not begin in one; Torque Enable is refused
with a result fail after a shutdown.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firmware_sim.actuator import Actuator
from firmware_sim.codes import ALERT, TORQUE_ON_BY_GOAL, HardwareError, StatusError
from firmware_sim.control_table import Area
from firmware_sim.memory import Memory
from firmware_sim.model import ServoModel
from firmware_sim.motor import STEP
from firmware_sim.present import END, FIRST, write_present
from firmware_sim.rules import GOAL_NAMES, Values, check_write
from firmware_sim.watchdog import BusWatchdog

BOOT_TIME = 0.1
"""How long a servo is deaf after a reboot, s. Not published; drivers in use wait 0.1 to 0.5 s."""

CLEAR_MULTI_TURN = bytes((0x01, 0x44, 0x58, 0x4C, 0x22))
"""Parameters of the instruction clear that reset the turns of Present Position."""

MAX_ID = 252
"""Highest ID; a higher secondary ID means none."""

_PROTOCOL_1_BITS = {
    HardwareError.INPUT_VOLTAGE: 0x01,
    HardwareError.OVERHEATING: 0x04,
    HardwareError.OVERLOAD: 0x20,
}

_RETURN_DELAY_UNIT = 2.0e-6


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
        for name, value in {**(settings or {}), "ID": servo_id}.items():
            self.memory.store(name, value)
        voltage = supply_voltage or model.motor.nominal_voltage
        self.actuator = Actuator(model, self.memory, start_tick, voltage)
        self._watchdog = BusWatchdog(self.memory)
        self._backup: dict[str, int] | None = None
        self.silenced = False
        """Whether it hears nothing and says nothing, as one whose cable has come loose."""
        self._registered: tuple[int, bytes] | None = None
        self._epoch = self._now = when
        self._steps = 0
        self._boot(deaf_for=0.0)

    @property
    def alert(self) -> int:
        """The alert bit for a status packet's error field."""
        return ALERT if self.memory.value("Hardware Error Status") else 0

    @property
    def moving(self) -> bool:
        """Whether its physics must go on even if nobody asks for a while."""
        return not self.actuator.drive.settled

    @property
    def hears(self) -> bool:
        """Whether it has booted and is not cut off."""
        return self._now >= self._deaf_until and not self.silenced

    @property
    def error_bits(self) -> int:
        """The error byte of protocol 1.0, without the bits that speak of the instruction."""
        status = self.memory.value("Hardware Error Status")
        return sum(bit for error, bit in _PROTOCOL_1_BITS.items() if status & error)

    @property
    def watchdog_deadline(self) -> float | None:
        """When its bus watchdog expires unless it is fed, s; None while it does not watch."""
        return self._watchdog.deadline()

    def feed(self, when: float) -> None:
        """Tell its bus watchdog of an instruction, at a time in s."""
        self._watchdog.feed(when)

    def notice_instruction(self, when: float) -> None:
        """Bring it to `when` (s) and feed its bus watchdog."""
        self.advance(when)
        self.feed(when)

    def read(self, address: int, size: int) -> tuple[StatusError, bytes]:
        """Return registers' bytes as of the time it was brought to.

        Parameters
        ----------
        address, size : int
            The range, bytes.

        Returns
        -------
        error : StatusError
            An access error when the range begins in a hole or ends behind the table.
        data : bytes
            Empty with an error.
        """
        end = address + size
        if not size or end > self.model.table.size or self.model.table.at(address) is None:
            return StatusError.ACCESS, b""
        if address < END and end > FIRST:
            write_present(self.memory, self.model, self.actuator, self._now - self._booted_at)
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
            See `rules.check_write`.
        """
        error, values = check_write(self.model, self.memory, address, data)
        if not error and self.actuator.shut_down and _switches_on(values):
            error = StatusError.RESULT_FAIL
        if error:
            return error
        changes = [self.memory.value(register.name) != value for register, value in values]
        self.memory.data[address : address + len(data)] = data
        for (register, value), changed in zip(values, changes, strict=True):
            self._wrote(register.name, value, changed)
        return StatusError.NONE

    def register_write(self, address: int, data: bytes) -> StatusError:
        """Keep a write for the next action; a later one replaces it."""
        error, _values = check_write(self.model, self.memory, address, data)
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

    def reboot(self) -> None:
        """Start anew: RAM to its defaults, torque off, deaf for `BOOT_TIME`."""
        self._boot(BOOT_TIME)

    def factory_reset(self, keep_id: bool, keep_baud_rate: bool) -> None:
        """Put the EEPROM to its defaults, but for what is kept, then reboot."""
        kept = {"ID": keep_id, "Baud Rate": keep_baud_rate}
        values = {name: self.memory.value(name) for name, keep in kept.items() if keep}
        self.memory.reset(Area.EEPROM)
        for name, value in values.items():
            self.memory.store(name, value)
        self.reboot()

    def power_cycle(self, off_for: float = 0.0) -> None:
        """Take its supply away for a time in s; it boots when that returns."""
        self._boot(off_for + BOOT_TIME)

    def clear(self, option: bytes) -> StatusError:
        """Clear the turns counted in Present Position; a result fail while it moves."""
        if option != CLEAR_MULTI_TURN:
            return StatusError.DATA_RANGE
        if self.actuator.drive.under_way:
            return StatusError.RESULT_FAIL
        self.actuator.frame.fold(self.actuator.drive.motor.angle)
        return StatusError.NONE

    def backup(self) -> StatusError:
        """Keep a copy of the control table; a result fail with the torque on."""
        if self.memory.value("Torque Enable"):
            return StatusError.RESULT_FAIL
        self._backup = self.memory.values(Area.EEPROM)
        return StatusError.NONE

    def restore(self) -> StatusError:
        """Put the copy back; a result fail with the torque on, or without a copy."""
        if self._backup is None or self.memory.value("Torque Enable"):
            return StatusError.RESULT_FAIL
        for name, value in self._backup.items():
            self.memory.store(name, value)
        self._take_settings()
        return StatusError.NONE

    def snapshot(self) -> dict[str, Any]:
        """Return what survives without power, as a JSON document: EEPROM, backup, angle."""
        return {
            "model": self.model.name,
            "eeprom": self.memory.values(Area.EEPROM),
            "backup": self._backup,
            "angle": self.actuator.drive.motor.angle,
        }

    def restore_snapshot(self, snapshot: Mapping[str, Any]) -> None:
        """Take over what `snapshot` returned, and boot."""
        for name, value in snapshot["eeprom"].items():
            self.memory.store(name, value)
        self._backup = snapshot["backup"]
        self.actuator.drive.motor.angle = snapshot["angle"]
        self._boot(deaf_for=0.0)

    def advance(self, when: float) -> None:
        """Bring it to a time, s; a past one changes nothing."""
        deadline = self._watchdog.deadline()
        if deadline is not None and deadline <= when:
            self._run_to(deadline)
            self._watchdog.expire()
            self.actuator.stop()
        self._run_to(when)
        self._now = max(self._now, when)

    def raise_hardware_error(self, error: HardwareError) -> None:
        """Let it detect a hardware error, as a test may want; only a reboot clears it."""
        self.actuator.raise_hardware_error(error)

    def apply_load(self, torque: float) -> None:
        """Load the horn with an external torque against the shaft's positive direction, N m."""
        self.actuator.drive.motor.load_torque = torque
        self.actuator.drive.disturb()

    def _run_to(self, when: float) -> None:
        steps = int((when - self._epoch) / STEP + 1e-6) - self._steps
        if steps > 0:
            self._steps += steps
            self.actuator.advance(steps)

    def _wrote(self, name: str, value: int, changed: bool) -> None:
        """Do what a write brings about, one register at a time, in address order."""
        if name == "Goal Position":
            self.actuator.start_for_goal()
        elif name == "Torque Enable":
            if changed:
                self.actuator.set_torque(on=bool(value))
        elif name == "Operating Mode":
            if changed:
                self.actuator.switch_mode()
        elif changed:
            self._take_settings()
            self.actuator.take_settings()
        if name in GOAL_NAMES and self.memory.value("Drive Mode") & TORQUE_ON_BY_GOAL:
            self.actuator.set_torque(on=not self.actuator.shut_down)

    def _take_settings(self) -> None:
        """Copy what the protocol needs often out of the registers."""
        value = self.memory.value
        self.servo_id = value("ID")
        self.baud_rate = self.model.baud_rates[value("Baud Rate")]
        self.return_delay = value("Return Delay Time") * _RETURN_DELAY_UNIT
        self.status_return_level = value("Status Return Level")
        secondary = value("Secondary(Shadow) ID")
        self.secondary_id = secondary if secondary <= MAX_ID else None
        self.protocol = value("Protocol Type")

    def _boot(self, deaf_for: float) -> None:
        self.memory.store("Model Number", self.model.number)
        self.memory.store("Firmware Version", self.model.firmware)
        self.memory.reset(Area.RAM)
        self._registered = None
        self._booted_at = self._now
        self._deaf_until = self._now + deaf_for
        self._take_settings()
        self.actuator.boot()


def _switches_on(values: Values) -> bool:
    return any(register.name == "Torque Enable" and value for register, value in values)
