"""A servo's registers as a dictionary, with the manual's rules written down a second time.

It knows nothing of motors: what depends on where the horn is, the test tells it.
"""

from firmware_sim.firmware.codes import StatusError
from firmware_sim.firmware.control_table import Access, Area, ControlTable, Register

LIMITS = {
    "Goal PWM": "PWM Limit",
    "Goal Current": "Current Limit",
    "Goal Velocity": "Velocity Limit",
}
GOALS = {*LIMITS, "Goal Position"}
LEADING = {0: "Goal Current", 1: "Goal Velocity", 16: "Goal PWM"}
RESET_BY_MODE = ("Gain", "Profile Velocity", "Profile Acceleration")
KEPT_IN_RAM = (*RESET_BY_MODE, "Indirect Address")


class PlainServo:
    """What should be in every register that is not measured."""

    def __init__(self, table: ControlTable, **settings: int) -> None:
        self.table = table
        self.values = {r.name: r.default for r in table.registers}
        self.values |= {name.replace("_", " "): value for name, value in settings.items()}
        self.backup: dict[str, int] | None = None
        self.registered: tuple[Register, int] | None = None
        self.shut_down = False
        self.boot()

    def refuses(self, register: Register, value: int) -> StatusError:
        """Say which error a write should end in."""
        now, name = self.values, register.name
        locked = register.area is Area.EEPROM and now["Torque Enable"]
        if register.access is Access.READ or locked:
            return StatusError.ACCESS
        if not register.minimum <= value <= register.maximum:
            return StatusError.DATA_RANGE
        unknown = (
            (name == "Drive Mode" and value & 0b10)
            or (name == "Operating Mode" and value not in (0, 1, 3, 4, 5, 16))
            or (name in GOALS and now["Bus Watchdog"] == 255)
            or (name == "Bus Watchdog" and value and now[name] == 255)
        )
        if unknown:
            return StatusError.DATA_RANGE
        if name == "Torque Enable" and value and self.shut_down:
            return StatusError.RESULT_FAIL
        return StatusError.NONE if self._is_within_limits(name, value) else StatusError.DATA_LIMIT

    def write(self, register: Register, value: int) -> None:
        """Do what a write that was not refused does."""
        name, now = register.name, self.values
        changed = now[name] != value
        offset = self.offset()
        now[name] = value
        if name == "Homing Offset":
            now["Goal Position"] += self.offset() - offset
        if name == "Operating Mode" and changed:
            self._reset(RESET_BY_MODE)
            self._reset_goals()
        elif register.area is Area.EEPROM and changed:
            for goal, limit in LIMITS.items():
                now[goal] = max(-now[limit], min(now[limit], now[goal]))
        if name in GOALS and now["Drive Mode"] & 8 and not self.shut_down:
            now["Torque Enable"] = 1

    def boot(self) -> None:
        """Start anew with what the EEPROM holds."""
        now = self.values
        now |= {r.name: r.default for r in self.table.registers if r.area is Area.RAM}
        now["Backup Ready"] = int(self.backup is not None)
        self.registered = None
        self.shut_down = False
        self._reset_goals()
        if now["Startup Configuration"] & 2 and self.backup is not None:
            now |= {n: v for n, v in self.backup.items() if self.table[n].area is Area.RAM}
        now["Torque Enable"] = now["Startup Configuration"] & 1

    def store(self) -> None:
        """Make a backup."""
        self.backup = {
            r.name: self.values[r.name]
            for r in self.table.registers
            if (r.area is Area.EEPROM and r.access is Access.READ_WRITE)
            or any(part in r.name for part in KEPT_IN_RAM)
        }
        self.values["Backup Ready"] = 1

    def restore(self) -> None:
        """Take the EEPROM back, and reboot."""
        assert self.backup is not None
        self.values |= {n: v for n, v in self.backup.items() if self.table[n].area is Area.EEPROM}
        self.boot()

    def factory_reset(self, kept: tuple[str, ...]) -> None:
        """Take the factory's EEPROM but for what is kept, and reboot."""
        self.values |= {
            r.name: r.default
            for r in self.table.registers
            if r.area is Area.EEPROM and r.name not in kept
        }
        self.boot()

    def expire(self) -> None:
        """Do what the bus watchdog does to the registers."""
        self.values |= {"Bus Watchdog": 255, "Profile Velocity": 0, "Profile Acceleration": 0}
        leading = LEADING.get(self.values["Operating Mode"])
        if leading:
            self.values[leading] = 0

    def byte_at(self, address: int) -> int:
        """Return the byte at an address, 0 in a hole."""
        register = self.table.at(address)
        if register is None:
            return 0
        value = self.values[register.name] % 256**register.size
        return value >> 8 * (address - register.address) & 0xFF

    def offset(self) -> int:
        """Return what the homing offset adds: too large a one nothing, in position mode."""
        offset = self.values["Homing Offset"]
        return 0 if self.values["Operating Mode"] == 3 and abs(offset) > 1024 else offset

    def _is_within_limits(self, name: str, value: int) -> bool:
        now = self.values
        if name in LIMITS:
            return abs(value) <= now[LIMITS[name]]
        if name == "Goal Position" and now["Operating Mode"] == 3:
            return now["Min Position Limit"] <= value <= now["Max Position Limit"]
        return True

    def _reset(self, parts: tuple[str, ...]) -> None:
        for register in self.table.registers:
            if any(part in register.name for part in parts):
                self.values[register.name] = register.default

    def _reset_goals(self) -> None:
        now = self.values
        now |= {goal: now[limit] for goal, limit in LIMITS.items()}
        leading = LEADING.get(now["Operating Mode"])
        if leading:
            now[leading] = 0
