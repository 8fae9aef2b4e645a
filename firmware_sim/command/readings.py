"""What a servo reads at a moment, in units for people, whatever its family.

The simulator's process only collects the numbers; `live_table` makes text of them in another.
"""

from __future__ import annotations

from firmware_sim.firmware.control_table import Register
from firmware_sim.firmware.readable import hardware_errors, mode_name, value_in_words
from firmware_sim.firmware.servo import Servo

_NAMES = {
    "torque": ("Torque Enable",),
    "position": ("Present Position",),
    "goal": ("Goal Position",),
    "velocity": ("Present Velocity", "Present Speed"),
    "effort": ("Present Current", "Present Load"),
    "temperature": ("Present Temperature",),
    "voltage": ("Present Input Voltage", "Present Voltage"),
}


class Reader:
    """Takes readings of one servo as often as asked, without an instruction on its bus.

    Parameters
    ----------
    servo : Servo
        The servo.
    """

    def __init__(self, servo: Servo) -> None:
        self._servo = servo
        table = servo.model.table.by_name
        self._registers: dict[str, Register] = {}
        for what, names in _NAMES.items():
            found = next((table[name] for name in names if name in table), None)
            if found is not None:
                self._registers[what] = found
        present = [row for row in self._registers.values() if row.name.startswith("Present")]
        self._first = min((row.address for row in present), default=0)
        self._size = max((row.end for row in present), default=0) - self._first

    def take(self) -> list[str]:
        """Return what it reads now.

        Returns
        -------
        list of str
            ID, model, mode, torque, position and goal (in counts of the encoder, whatever the
            family), velocity, current or load, temperature, voltage, errors; empty where the servo
            has no such thing.
        """
        servo = self._servo
        servo.read(self._first, self._size)  # brings its present values up to date
        words = [
            self._words(self._registers[what]) if what in self._registers else "" for what in _NAMES
        ]
        torque = {"0": "off", "1": "on"}.get(words[0], "") if servo.hears else "deaf"
        name = servo.model.name
        return [str(servo.servo_id), name, self._mode(), torque, *words[1:], self._errors()]

    def _words(self, register: Register) -> str:
        value = self._servo.memory.value(register.name)
        return str(value) if "Position" in register.name else value_in_words(register, value)

    def _mode(self) -> str:
        memory, table = self._servo.memory, self._servo.model.table.by_name
        if "Operating Mode" in table:
            return mode_name(memory.value("Operating Mode"))
        if "Control Mode" in table:
            return "wheel" if memory.value("Control Mode") == 1 else "joint"
        limits = memory.value("CW Angle Limit"), memory.value("CCW Angle Limit")
        return "wheel" if limits == (0, 0) else "joint"

    def _errors(self) -> str:
        if self._servo.model.family == "x":
            return hardware_errors(self._servo.memory.value("Hardware Error Status"))
        bits = self._servo.error_bits
        return f"0x{bits:02x}" if bits else ""
