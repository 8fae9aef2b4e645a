"""What differs between families of servos, behind one interface.

A `Servo` keeps registers, identity, registered writes and time, which all families have; what its
registers mean to a motor, which writes are refused and how errors show is its family's `Firmware`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Protocol

from firmware_sim.firmware.codes import HardwareError, StatusError
from firmware_sim.firmware.control_table import Register
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.timeline import Timeline
from firmware_sim.physics.axis import Axis

Values = list[tuple[Register, int]]
"""Registers, each with what is to be written there."""

Change = tuple[Register, int, bool]
"""A register, what was written there, and whether that differs from what it held."""


class Firmware(Protocol):
    """The family's own part of one servo."""

    @property
    def alert(self) -> int:
        """The alert bit of a status packet of protocol 2.0: `codes.ALERT` or 0."""

    @property
    def error_bits(self) -> int:
        """The error byte of protocol 1.0, without the bits that speak of the instruction."""

    @property
    def deaf_until(self) -> float:
        """Until when it hears nothing for another reason than a boot, s."""

    @property
    def led(self) -> int:
        """What the LED shows now; after a shutdown that may differ from its register."""

    @property
    def next_event(self) -> float:
        """When `wake` is to be called next, s; infinity for never."""

    def angle(self, tick: int) -> float:
        """Return the horn's angle, rad, at which Present Position reads a number."""

    def install(self, angle: float, supply_voltage: float) -> None:
        """Put the horn to an angle (rad) and connect the supply (V); the torque is off."""

    def power_off(self) -> None:
        """Take the supply away: nothing holds the horn."""

    def boot(self) -> None:
        """Begin, with all RAM registers at their defaults."""

    def check_write(self, address: int, data: bytes, ram_only: bool) -> tuple[StatusError, Values]:
        """Return why a write is refused (`StatusError.NONE` if it is not) and what it writes.

        With `ram_only`, as for a secondary ID, registers in EEPROM are refused.
        """

    def wrote(self, changes: Sequence[Change]) -> None:
        """Do what a write brings about; the registers hold the new values already."""

    def present(self, name: str) -> Callable[[], int] | None:
        """Return what measures the register of this name, None if it reads what was stored."""

    def inspect(self) -> None:
        """Look for causes of errors; called every `world.INSPECTION_STEPS` while it moves."""

    def wake(self) -> None:
        """Do what was to be done at `next_event`."""

    def stop(self) -> None:
        """Stop the horn, as the bus watchdog wants it."""

    def clear(self, option: bytes) -> StatusError:
        """Obey the instruction clear, with its parameters."""

    def raise_hardware_error(self, error: HardwareError) -> None:
        """Note an error, and shut down if Shutdown says so."""


_FAMILIES = {
    "x": "firmware_sim.firmware.x_firmware",
    "classic": "firmware_sim.classic.firmware",
    "xl320": "firmware_sim.classic.firmware",
}
"""Where each family's ``make_firmware(model, memory, axis, timeline)`` is."""


def make_firmware(model: ServoModel, memory: Memory, axis: Axis, timeline: Timeline) -> Firmware:
    """Return the firmware of a model's family.

    Parameters
    ----------
    model : ServoModel
        What it is.
    memory : Memory
        Its registers, with their EEPROM values in place.
    axis : Axis
        What it drives; `Firmware.install` configures it.
    timeline : Timeline
        The time.
    """
    make: Callable[[ServoModel, Memory, Axis, Timeline], Firmware]
    make = import_module(_FAMILIES[model.family]).make_firmware
    return make(model, memory, axis, timeline)
