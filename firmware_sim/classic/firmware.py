"""The firmware of AX, of MX with protocol 1.0 and of XL-320, as `firmware.Firmware` wants it.

Sources: e-Manual, docs/en/dxl/ax/ax-12a, docs/en/dxl/mx, docs/en/dxl/x/xl320, "Control Table
Description". A goal written with the torque off switches it on in AX and MX: users see it (poppy-
project/poppy-docs issue 36), the manual is silent; XL-320, of which nobody says so, waits for
Torque Enable(24), as the X series does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from firmware_sim.classic.alarms import Alarms, Error
from firmware_sim.classic.counting import Mode
from firmware_sim.classic.motion import Motion
from firmware_sim.classic.present import Present
from firmware_sim.classic.rules import check_write, xl320_checker
from firmware_sim.firmware.codes import ALERT, HardwareError, StatusError
from firmware_sim.firmware.control_table import Area
from firmware_sim.firmware.family import Change, Values
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.timeline import Timeline
from firmware_sim.physics.axis import Axis

_EEPROM_TIME = 6.0e-3
"""How long an AX is deaf for each byte written to its EEPROM, s; measured by users on an AX-12."""

_MODE_NAMES = frozenset(("CW Angle Limit", "CCW Angle Limit", "Control Mode"))

_DRIVING_NAMES = frozenset(
    (
        "Torque Enable",
        "Torque Limit",
        "Goal Position",
        "Moving Speed",
        "Goal Acceleration",
        "Goal Torque",
        "Torque Control Mode Enable",
        "CW Compliance Margin",
        "CCW Compliance Margin",
        "CW Compliance Slope",
        "CCW Compliance Slope",
        "Punch",
        "P Gain",
        "I Gain",
        "D Gain",
        "Multi Turn Offset",
        "Resolution Divider",
        "Drive Mode",
    )
)
"""Registers that change what the motor is to do."""

_INSTRUCTION_ERRORS = {
    StatusError.DATA_RANGE: Error.RANGE,
    StatusError.DATA_LIMIT: Error.ANGLE_LIMIT,
}


class ClassicFirmware:
    """The family's own part of one servo; see `firmware.Firmware`.

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
    """

    def __init__(self, model: ServoModel, memory: Memory, axis: Axis, timeline: Timeline) -> None:
        self._model = model
        self._memory = memory
        self._axis = axis
        self._timeline = timeline
        self._is_xl320 = model.family == "xl320"
        self._checker = xl320_checker(memory) if self._is_xl320 else None
        self.motion = Motion(model, memory, axis)
        self.alarms = Alarms(memory, axis)
        self._present = Present(model, memory, self.motion, timeline)
        self._mode = self.motion.mode
        self.deaf_until = timeline.now
        """Until when it hears nothing because it writes its EEPROM, s: AX only."""

    @property
    def alert(self) -> int:
        """The alert bit: XL-320 only has it."""
        return ALERT if self._is_xl320 and self._memory.value("Hardware Error Status") else 0

    @property
    def error_bits(self) -> int:
        """The error byte: input voltage, overheating, overload."""
        return int(self.alarms.errors)

    @property
    def next_event(self) -> float:
        """Never: these servos have no bus watchdog."""
        return math.inf

    @property
    def led(self) -> int:
        """What the LED shows now: the register, or 1 and 0 in turn while an alarm blinks."""
        return self.alarms.led(self._timeline.now)

    def angle(self, tick: int) -> float:
        """Return the horn's angle, rad, at which Present Position reads a number."""
        return self.motion.angle(tick)

    def install(self, angle: float, supply_voltage: float) -> None:
        """Put the horn to an angle (rad) and connect the supply (V); the torque is off."""
        self._axis.configure(self._model.motor, self._model.units.angle, supply_voltage, angle)
        self.motion.install()

    def power_off(self) -> None:
        """Take the supply away: nothing holds the horn."""
        self._axis.release()

    def boot(self) -> None:
        """Begin, with all RAM registers at their defaults: Torque Limit is Max Torque."""
        self._memory.store("Torque Limit", self._memory.value("Max Torque"))
        self.alarms.boot()
        self._present.booted_at = self._timeline.now
        self._mode = self.motion.mode
        self.motion.boot()
        self._memory.store("Goal Position", self.motion.position)
        self.inspect()

    def check_write(self, address: int, data: bytes, ram_only: bool) -> tuple[StatusError, Values]:
        """Return why a write is refused (`StatusError.NONE` if it is not) and what it writes.

        Without a secondary ID, these servos never have `ram_only` to obey.
        """
        if self._checker is not None:
            error, values = self._checker.check(address, data, ram_only)
        else:
            error, values = check_write(self._memory, address, data)
        found = _INSTRUCTION_ERRORS.get(error)
        if found and self.alarms.notice(found, self._timeline.now):
            self.motion.drive()
        return error, values

    def wrote(self, changes: Sequence[Change]) -> None:
        """Do what a write brings about; the registers hold the new values already."""
        if "CW Compliance Slope" in self._memory.table.by_name:
            kept = sum(r.size for r, _, _ in changes if r.area is Area.EEPROM)
            self.deaf_until = max(self.deaf_until, self._timeline.now + kept * _EEPROM_TIME)
        written = {register.name: value for register, value, _ in changes}
        changed = {register.name for register, _, differs in changes if differs}
        if changed & _MODE_NAMES and self.motion.mode is not self._mode:
            self._mode = self.motion.mode
            self.motion.switch_mode()
        if "Goal Position" in written and self._mode is not Mode.WHEEL and not self._is_xl320:
            self._memory.store("Torque Enable", 1)
        elif "Torque Enable" in changed and self._mode is not Mode.WHEEL:
            self._memory.store("Goal Position", self.motion.position)
        if written.get("Torque Limit"):
            self.alarms.restore()
        if changed & _DRIVING_NAMES or "Goal Position" in written:
            self.motion.drive()

    def present(self, name: str) -> Callable[[], int] | None:
        """Return what measures the register of this name, None if it reads what was stored."""
        return self._present.by_name.get(name)

    def inspect(self) -> None:
        """Look for causes of errors."""
        if self.alarms.check(self._timeline.now):
            self.motion.drive()

    def wake(self) -> None:
        """Nothing is ever to be done: see `next_event`."""

    def stop(self) -> None:
        """Stop the horn where it is."""
        self._memory.store("Moving Speed", 0)
        self._memory.store("Goal Position", self.motion.position)
        self.motion.drive()

    def clear(self, option: bytes) -> StatusError:  # noqa: ARG002 - the interface has it
        """Refuse the instruction clear, which is newer than XL-320."""
        return StatusError.INSTRUCTION

    def raise_hardware_error(self, error: HardwareError) -> None:
        """Note an error, and shut down if Shutdown says so."""
        if self.alarms.detect(error, self._timeline.now):
            self.motion.drive()


def make_firmware(
    model: ServoModel, memory: Memory, axis: Axis, timeline: Timeline
) -> ClassicFirmware:
    """Return the firmware of an AX, an MX with protocol 1.0, or an XL-320."""
    return ClassicFirmware(model, memory, axis, timeline)
