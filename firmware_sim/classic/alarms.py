"""What goes wrong in an older servo, and what it does about it.

A voltage or a temperature out of its limits, and a load that the output at its cap cannot move, are
errors for as long as they last. An error whose bit is in Shutdown puts Torque Limit to 0, which
makes the servo run free. Once the cause has gone, any other Torque Limit lets it work again; with
the cause still there, Torque Limit falls back to 0.

Sources: e-Manual, docs/en/dxl/ax/ax-12a, "Alarm LED(17), Shutdown(18)", "Torque Limit (34)";
docs/en/dxl/x/xl320, "Shutdown(18)" (whose bits lie otherwise), "Hardware Error Status(50)", and
"Min/Max Voltage Limit(13, 14)": a shutdown of XL-320 clears Torque Enable as well. AX-12 User's
Manual, page 16: the LED blinks on for 2 s after the error. Where they are silent: how long a load
must last is `OVERLOAD_TIME`; what took the torque away is reported until Torque Limit is written;
so are all bits of XL-320's Hardware Error Status; half of each second of blinking is light.
"""

from __future__ import annotations

from enum import IntFlag

from firmware_sim.firmware.codes import HardwareError
from firmware_sim.firmware.memory import Memory
from firmware_sim.physics.axis import Axis

OVERLOAD_TIME = 0.5
"""How long the output must be at its cap, with the shaft nearly standing, s. Not published."""

BLINKING_AFTER = 2.0
"""How long the LED goes on blinking after an error, s."""


class Error(IntFlag):
    """Bits of protocol 1.0's error byte and of Alarm LED(17) and Shutdown(18)."""

    INPUT_VOLTAGE = 0x01
    ANGLE_LIMIT = 0x02
    OVERHEATING = 0x04
    RANGE = 0x08
    CHECKSUM = 0x10
    OVERLOAD = 0x20
    INSTRUCTION = 0x40


_XL320_BITS = {Error.OVERLOAD: 0x01, Error.OVERHEATING: 0x02, Error.INPUT_VOLTAGE: 0x04}

_OF_HARDWARE = {
    HardwareError.INPUT_VOLTAGE: Error.INPUT_VOLTAGE,
    HardwareError.OVERHEATING: Error.OVERHEATING,
    HardwareError.OVERLOAD: Error.OVERLOAD,
}
"""What these servos detect of what a newer one does: no encoder error, no electrical shock."""

_LASTING = Error.INPUT_VOLTAGE | Error.OVERHEATING | Error.OVERLOAD
"""Errors of the servo; the others are those of an instruction."""


class Alarms:
    """The errors of one servo.

    Parameters
    ----------
    memory : Memory
        Its registers.
    axis : Axis
        What it drives.
    """

    def __init__(self, memory: Memory, axis: Axis) -> None:
        self._memory = memory
        self._axis = axis
        self._is_xl320 = "Hardware Error Status" in memory.table.by_name
        self._kept = Error(0)
        self._blinks_until = -1.0

    def boot(self) -> None:
        """Forget what was."""
        self._kept = Error(0)
        self._blinks_until = -1.0

    @property
    def errors(self) -> Error:
        """All that is wrong now."""
        return self._kept | self._present()

    def check(self, when: float) -> bool:
        """Look at voltage, temperature and load; return whether torque has just been taken away.

        Parameters
        ----------
        when : float
            The time, s.
        """
        return self._raise(self._present(), when)

    def notice(self, errors: Error, when: float) -> bool:
        """Take note of an instruction's errors; return whether torque has just been taken away."""
        return self._raise(errors, when)

    def detect(self, error: HardwareError, when: float) -> bool:
        """Be told of an error as if it were detected; it lasts until Torque Limit is written."""
        found = _OF_HARDWARE.get(error, Error(0))
        self._kept |= found
        return self._raise(found, when)

    def restore(self) -> None:
        """Let a new Torque Limit end what only lasts because of a shutdown."""
        self._kept = Error(0)
        if self._is_xl320:
            self._memory.store("Hardware Error Status", 0)

    def led(self, when: float) -> int:
        """Return what the LED shows at a time in s: the register, or red blinking by the second."""
        if when >= self._blinks_until and not self._coded(self.errors) & self._shown:
            return self._memory.value("LED")
        return int(when % 1.0 < 0.5)

    @property
    def _shown(self) -> int:
        """Which errors make the LED blink."""
        return self._memory.value("Shutdown" if self._is_xl320 else "Alarm LED")

    def _present(self) -> Error:
        value = self._memory.value
        found = Error(0)
        tenths = round(self._axis.voltage * 10.0)
        if not value("Min Voltage Limit") <= tenths <= value("Max Voltage Limit"):
            found |= Error.INPUT_VOLTAGE
        if self._axis.temperature > value("Temperature Limit"):
            found |= Error.OVERHEATING
        if self._axis.saturated_for > OVERLOAD_TIME:
            found |= Error.OVERLOAD
        return found

    def _raise(self, errors: Error, when: float) -> bool:
        if not errors:
            return False
        if self._coded(errors) & self._shown:
            self._blinks_until = when + BLINKING_AFTER
        if self._is_xl320:
            status = self._memory.value("Hardware Error Status")
            self._memory.store("Hardware Error Status", status | self._coded(errors))
        mask = self._memory.value("Shutdown")
        causes = [error for error in errors if self._coded(error) & mask]
        if not causes:
            return False
        for error in causes:
            self._kept |= error & _LASTING
        if not self._memory.value("Torque Limit"):
            return False
        self._memory.store("Torque Limit", 0)
        if self._is_xl320:
            self._memory.store("Torque Enable", 0)
        return True

    def _coded(self, errors: Error) -> int:
        """Return errors as the bits of Shutdown have them."""
        if not self._is_xl320:
            return int(errors)
        return sum(bit for error, bit in _XL320_BITS.items() if errors & error)
