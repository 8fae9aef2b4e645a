"""One servo as the protocol sees it: an identity, registers to read and write, and its firmware.

A servo has no clock: `world.World` tells all of them the time and moves their axes. Source: the
e-Manual's pages of the models, "Control Table Description", and Protocol 2.0, "Instruction".
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from firmware_sim.firmware.backup import Backup
from firmware_sim.firmware.codes import (
    CLEAR_MULTI_TURN,
    STARTUP_RAM_RESTORE,
    STARTUP_TORQUE_ON,
    HardwareError,
    StatusError,
)
from firmware_sim.firmware.control_table import Area
from firmware_sim.firmware.family import make_firmware
from firmware_sim.firmware.identity import IDENTITY_NAMES, Identity
from firmware_sim.firmware.indirect import IndirectMap
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.reading import Reader
from firmware_sim.firmware.snapshot import put_snapshot, take_snapshot
from firmware_sim.firmware.timeline import Timeline
from firmware_sim.firmware.watchdog import BusWatchdog
from firmware_sim.physics.axis import Axis

__all__ = ["BOOT_TIME", "CLEAR_MULTI_TURN", "Servo"]

BOOT_TIME = 0.1
"""How long a servo is deaf after a reboot, s. Not published; drivers in use wait 0.1 to 0.5 s."""


class Servo(Identity):
    """One simulated servo; `Identity` has what the protocol needs of its registers.

    Parameters
    ----------
    model : ServoModel
        What it is.
    servo_id : int
        0 to 252.
    axis : Axis
        What it drives.
    timeline : Timeline
        The time.
    start_tick : int
        Where its horn lies at the start, as Present Position reads with the registers given.
    supply_voltage : float, optional
        V; the motor's nominal voltage by default.
    registers : mapping of str to int, optional
        EEPROM registers by name that differ from the factory's.

    Attributes
    ----------
    silenced : bool
        Whether it hears nothing and says nothing, as one whose cable has come loose.
    watches : bool
        Whether its bus watchdog may have to be fed.
    """

    def __init__(
        self,
        model: ServoModel,
        servo_id: int,
        axis: Axis,
        timeline: Timeline,
        *,
        start_tick: int = 2048,
        supply_voltage: float | None = None,
        registers: Mapping[str, int] | None = None,
    ) -> None:
        memory = Memory(model.table)
        for name, value in {**(registers or {}), "ID": servo_id}.items():
            memory.store(name, value)
        super().__init__(model, memory, timeline)
        self.axis = axis
        self.supply_voltage = supply_voltage or model.motor.nominal_voltage
        self.silenced = False
        self.backed_up = Backup(self.memory)
        self.firmware = make_firmware(model, self.memory, axis, timeline)
        self.firmware.install(self.firmware.angle(start_tick), self.supply_voltage)
        self._watchdog = BusWatchdog(self.memory)
        self.watches = False
        indirect = IndirectMap(self.memory)
        holes = model.family == "classic"
        self._reader = Reader(self.memory, self.firmware, indirect, from_holes=holes)
        self._own_settings = IDENTITY_NAMES.union(indirect.names)
        self._registered: tuple[int, bytes, bool] | None = None
        self._power_on_at = math.inf
        self._boot()
        self._deaf_until = timeline.now

    @property
    def alert(self) -> int:
        """The alert bit for a status packet's error field: 0x80 or 0."""
        return self.firmware.alert

    @property
    def error_bits(self) -> int:
        """The error byte of protocol 1.0, without the bits that speak of the instruction."""
        return self.firmware.error_bits

    @property
    def moving(self) -> bool:
        """Whether its physics must go on even if nobody asks for a while."""
        return not self.axis.settled or self.axis.saturated_for > 0.0

    @property
    def hears(self) -> bool:
        """Whether it has power, has booted and is not cut off."""
        now = self._timeline.now
        if self.silenced or now < self._deaf_until:
            return False
        return now >= self.firmware.deaf_until

    def feed(self, when: float) -> None:
        """Tell its bus watchdog of an instruction, at a time in s."""
        self._watchdog.fed_at = when

    def read(self, address: int, size: int) -> tuple[StatusError, bytes]:
        """Return registers' bytes as of the present moment.

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
        return self._reader.read(address, size)

    def write(self, address: int, data: bytes, *, ram_only: bool = False) -> StatusError:
        """Write registers and do what that brings about.

        Parameters
        ----------
        address : int
            Of the first byte.
        data : bytes
            All of it is written, or none with an error.
        ram_only : bool
            Whether EEPROM is out of reach, as through the secondary ID.

        Returns
        -------
        StatusError
            Why it was refused.
        """
        error, values = self.firmware.check_write(address, data, ram_only)
        if error:
            return error
        memory = self.memory
        changes = []
        for register, value in values:
            changes.append((register, value, memory.value(register.name) != value))
            memory.store(register.name, value)
        self.firmware.wrote(changes)
        for register, _value, changed in changes:
            if changed and register.name in self._own_settings:
                self._take_setting(register.name)
        self._watchdog.fed_at = self._timeline.now
        deadline = self._watchdog.deadline
        self.watches = deadline < math.inf
        if deadline < self._timeline.alarm:
            self._timeline.wake_at(deadline)
        return StatusError.NONE

    def register_write(self, address: int, data: bytes, *, ram_only: bool = False) -> StatusError:
        """Keep a write for the next action; a later one replaces it."""
        error, _values = self.firmware.check_write(address, data, ram_only)
        if not error:
            self._keep((address, data, ram_only))
        return error

    def act(self) -> StatusError:
        """Do the registered write; an instruction error if there is none."""
        if self._registered is None:
            return StatusError.INSTRUCTION
        address, data, ram_only = self._registered
        self._keep(None)
        return self.write(address, data, ram_only=ram_only)

    def clear(self, option: bytes) -> StatusError:
        """Obey the instruction clear; `option` is all of its parameters."""
        return self.firmware.clear(option)

    def backup(self) -> StatusError:
        """Keep a copy of the control table; a result fail with the torque on."""
        if not self.model.understands_backup:
            return StatusError.INSTRUCTION
        if self.memory.value("Torque Enable"):
            return StatusError.RESULT_FAIL
        self.backed_up.store()
        return StatusError.NONE

    def restore(self) -> StatusError:
        """Put the copy's EEPROM back and reboot; a result fail with torque on or without a copy."""
        if not self.model.understands_backup:
            return StatusError.INSTRUCTION
        if self.backed_up.values is None or self.memory.value("Torque Enable"):
            return StatusError.RESULT_FAIL
        self.backed_up.restore_eeprom()
        self.reboot()
        return StatusError.NONE

    def reboot(self) -> None:
        """Start anew: RAM to its defaults, torque off, deaf for `BOOT_TIME`."""
        self._boot()

    def power_cycle(self, off_for: float = 0.0) -> None:
        """Take its supply away for a time in s; it boots when that returns."""
        self.firmware.power_off()
        self._power_on_at = self._timeline.now + off_for
        self._deaf_until = self._power_on_at + BOOT_TIME
        self._timeline.wake_at(self._power_on_at)

    def factory_reset(self, keep_id: bool, keep_baud_rate: bool) -> None:
        """Put the EEPROM to its defaults, but for what is kept, then reboot."""
        kept = {"ID": keep_id, "Baud Rate": keep_baud_rate}
        values = {name: self.memory.value(name) for name, keep in kept.items() if keep}
        self.memory.reset(Area.EEPROM)
        for name, value in values.items():
            self.memory.store(name, value)
        self.reboot()

    def raise_hardware_error(self, error: HardwareError) -> None:
        """Let it notice a hardware error; only a reboot clears it."""
        self.firmware.raise_hardware_error(error)

    def apply_load(self, torque: float) -> None:
        """Load the horn with an external torque against the shaft's positive direction, N m."""
        self.axis.apply_load(torque)

    def inspect(self) -> None:
        """Let it look for causes of errors."""
        if self._power_on_at == math.inf:
            self.firmware.inspect()

    @property
    def next_event(self) -> float:
        """When it does something of itself next, s; infinity for never."""
        return min(self._power_on_at, self._watchdog.deadline, self.firmware.next_event)

    def wake(self) -> None:
        """Do what was to be done at `next_event`."""
        now = self._timeline.now
        if self._power_on_at <= now:
            self._boot()
        if self._watchdog.deadline <= now:
            self._watchdog.expire()
            self.firmware.stop()
        self.firmware.wake()

    def snapshot(self) -> dict[str, Any]:
        """Return what survives without power, as a JSON object: EEPROM, backup, angle."""
        return take_snapshot(self)

    def restore_snapshot(self, snapshot: Mapping[str, Any]) -> None:
        """Take over what `snapshot` returned, and boot.

        Raises
        ------
        ValueError
            If it is not one of this model: one line that says why; nothing was changed.
        """
        put_snapshot(self, snapshot)
        self._boot()
        self._deaf_until = self._timeline.now

    def _boot(self) -> None:
        """Begin anew with what the EEPROM holds; deaf for `BOOT_TIME`."""
        value = self.memory.value
        self._power_on_at = math.inf
        self._deaf_until = self._timeline.now + BOOT_TIME
        self.memory.reset(Area.RAM)
        self.memory.store("Model Number", self.model.number)
        self.memory.store("Firmware Version", self.model.firmware)
        self._registered = None
        self.backed_up.show()
        startup = 0
        if "Startup Configuration" in self.model.table.by_name:
            startup = value("Startup Configuration")
        if startup & STARTUP_RAM_RESTORE:
            self.backed_up.restore_ram()
        self._reader.forget()
        self.firmware.boot()
        self.take_identity()
        if startup & STARTUP_TORQUE_ON:
            self.write(self.model.table["Torque Enable"].address, b"\x01")
        self._watchdog.fed_at = self._timeline.now

    def _keep(self, registered: tuple[int, bytes, bool] | None) -> None:
        self._registered = registered
        self.memory.store("Registered Instruction", int(registered is not None))

    def _take_setting(self, name: str) -> None:
        """Look again at what a register says that the servo itself lives by."""
        if name in IDENTITY_NAMES:
            self.take_identity()
        else:
            self._reader.forget()
