"""The firmware of the X series, and of MX with protocol 2.0.

Source: the e-Manual's X-series pages, "Control Table Description".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from firmware_sim.firmware.actuator import Actuator
from firmware_sim.firmware.codes import (
    ALERT,
    CLEAR_MULTI_TURN,
    HardwareError,
    StatusError,
)
from firmware_sim.firmware.control_table import Area
from firmware_sim.firmware.family import Change, Values
from firmware_sim.firmware.health import Health
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.present import Present
from firmware_sim.firmware.rules import GOAL_NAMES, Rules
from firmware_sim.firmware.timeline import Timeline
from firmware_sim.physics.axis import Axis

_BLINKS_FROM = 41
"""Firmware whose LED blinks after a shutdown ("Shutdown(63)")."""

_BLINK_TIME = 0.5
"""Half of a second in which it blinks once, s."""


class XFirmware:
    """The firmware of one servo; see `firmware.Firmware` for what its methods are to do.

    Parameters
    ----------
    model : ServoModel
        What it is.
    memory : Memory
        Its registers, with their EEPROM values in place.
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
        self.deaf_until = -math.inf
        """Never deaf but while it boots."""
        self.actuator = Actuator(model, memory, axis)
        self.health = Health(model, memory, axis, timeline, self._drop_torque)
        self._rules = Rules(model, memory, lambda: self.health.shut_down)
        self._present = Present(model, memory, self.actuator, timeline)

    @property
    def alert(self) -> int:
        """The alert bit of a status packet's error field."""
        return ALERT if self.health.status else 0

    @property
    def error_bits(self) -> int:
        """The error byte of protocol 1.0."""
        return self.health.protocol_1_bits

    @property
    def led(self) -> int:
        """What the LED shows: the register, or 1 and 0 in turn after a shutdown; XW540 has none."""
        if "LED" not in self._memory.table.by_name:
            return 0
        if self.health.shut_down and self._model.firmware >= _BLINKS_FROM:
            return 1 - int(self._timeline.now / _BLINK_TIME) % 2
        return self._memory.value("LED")

    @property
    def next_event(self) -> float:
        """When `wake` is to be called next, s."""
        return self.health.next_look

    def angle(self, tick: int) -> float:
        """Return the horn's angle, rad, at which Present Position reads a number."""
        return self.actuator.frame.angle(tick)

    def install(self, angle: float, supply_voltage: float) -> None:
        """Put the horn to an angle (rad) and connect the supply (V)."""
        model = self._model
        self._axis.configure(
            model.motor, model.units.angle, supply_voltage, angle, senses_input=model.senses_input
        )

    def power_off(self) -> None:
        """Take the supply away."""
        self._memory.store("Torque Enable", 0)
        self._drop_torque()

    def boot(self) -> None:
        """Begin, with all RAM registers at their defaults."""
        self._present.booted_at = self._timeline.now
        self._rules.forget()
        self.actuator.boot()
        self.health.boot()

    def check_write(self, address: int, data: bytes, ram_only: bool) -> tuple[StatusError, Values]:
        """Return why a write is refused, and what it writes."""
        return self._rules.check(address, data, ram_only)

    def wrote(self, changes: Sequence[Change]) -> None:
        """Do what a write brings about, one register at a time, in address order."""
        for register, value, changed in changes:
            name = register.name
            if name in GOAL_NAMES:
                self._new_goal(name)
            elif changed:
                self._new_setting(name, value, register.area)

    def present(self, name: str) -> Callable[[], int] | None:
        """Return what measures the register of this name."""
        return self._present.measure(name)

    def inspect(self) -> None:
        """Look for causes of errors."""
        self.health.inspect()

    def wake(self) -> None:
        """Look again at what may be an error."""
        if self.health.next_look <= self._timeline.now:
            self.health.inspect()

    def stop(self) -> None:
        """Stop the horn."""
        self.actuator.stop()

    def clear(self, option: bytes) -> StatusError:
        """Clear the turns of Present Position; a result fail while it moves."""
        if option != CLEAR_MULTI_TURN:
            return StatusError.DATA_RANGE
        measure = self.present("Moving")
        if measure is not None and measure():
            return StatusError.RESULT_FAIL
        self.actuator.clear_turns()
        return StatusError.NONE

    def raise_hardware_error(self, error: HardwareError) -> None:
        """Note an error, and shut down if Shutdown says so."""
        self.health.raise_error(error)

    def _new_goal(self, name: str) -> None:
        actuator = self.actuator
        if actuator.torque_on_by_goal and not self._axis.torque_on and not self.health.shut_down:
            actuator.set_torque(on=True)
        elif name == actuator.leading_goal:
            actuator.lead()
        if name != "Goal Position":
            actuator.take_caps()

    def _new_setting(self, name: str, value: int, area: Area) -> None:
        if name == "Torque Enable":
            self.actuator.set_torque(on=bool(value))
        elif name == "Operating Mode":
            self.actuator.switch_mode()
        elif name.endswith("Gain"):
            self.actuator.take_settings()
        elif name.startswith("Indirect Address"):
            self._rules.forget()
        elif area is Area.EEPROM:
            self.actuator.keep_goals_within_limits()
            self.actuator.take_settings()
            self.actuator.count_anew()
            self.health.take_settings()

    def _drop_torque(self) -> None:
        self.actuator.set_torque(on=False)


make_firmware = XFirmware
"""The maker that `firmware.make_firmware` looks for."""
