"""Which writes a servo of the X series refuses, and with which error number.

Source: e-Manual, Protocol 2.0, "Error": data range for a value outside the register's own range,
data limit for one outside a limit register, data length for part of a register, access for
read-only, undefined, and EEPROM while torque is on; "Bus Watchdog(98)": goals are refused with a
data range error after it expired; "External Port Data(152)": written in output mode only. Where the
manual is silent: Torque Enable is refused with a result fail after a shutdown.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from firmware_sim.firmware.codes import (
    SLAVE_MODE,
    WATCHDOG_EXPIRED,
    OperatingMode,
    StatusError,
)
from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import ServoModel
from firmware_sim.firmware.writing import Guard, WriteChecker

GOAL_NAMES = frozenset(("Goal PWM", "Goal Current", "Goal Velocity", "Goal Position"))

LIMITED_BY = {
    "Goal PWM": "PWM Limit",
    "Goal Current": "Current Limit",
    "Goal Velocity": "Velocity Limit",
}
"""Goals, and which register says how large they may be either way."""

ACCELERATION_LIMIT = "Acceleration Limit"
"""What Profile Acceleration(108) cannot exceed, on models that have it (MX with protocol 2.0)."""

PORT_OUTPUT = 1
"""External Port Mode in which the port is an output."""


class Rules:
    """The rules for writes to one servo.

    Parameters
    ----------
    model : ServoModel
        What it is.
    memory : Memory
        Its registers.
    is_shut_down : callable
        Whether only a reboot can bring the torque back.

    Attributes
    ----------
    check : callable
        `WriteChecker.check`, under these rules.
    forget : callable
        `WriteChecker.forget`.
    """

    def __init__(self, model: ServoModel, memory: Memory, is_shut_down: Callable[[], bool]) -> None:
        self._value = memory.value
        self._is_shut_down = is_shut_down
        self._drive_mode_bits = model.drive_mode_bits & ~SLAVE_MODE  # slaves are not modelled
        self._operating_modes = model.operating_modes
        self._protocols = model.protocols
        self._baud_codes = frozenset(model.baud_rates)
        guards: dict[str, Guard] = {
            "Baud Rate": self._refuse_baud_rate,
            "Drive Mode": self._refuse_drive_mode,
            "Operating Mode": self._refuse_operating_mode,
            "Protocol Type": self._refuse_protocol,
            "Torque Enable": self._refuse_torque,
            "Bus Watchdog": self._refuse_watchdog,
            "Goal Position": self._refuse_goal_position,
            **{goal: partial(self._refuse_goal, limit) for goal, limit in LIMITED_BY.items()},
        }
        if ACCELERATION_LIMIT in model.table.by_name:
            guards["Profile Acceleration"] = self._refuse_acceleration
        for name in model.table.by_name:
            if name.startswith("External Port Data"):
                guards[name] = partial(self._refuse_port, name.replace("Data", "Mode"))
        checker = WriteChecker(memory, guards)
        self.check = checker.check
        self.forget = checker.forget

    def _refuse_baud_rate(self, value: int) -> StatusError:
        return StatusError.NONE if value in self._baud_codes else StatusError.DATA_RANGE

    def _refuse_drive_mode(self, value: int) -> StatusError:
        return StatusError.DATA_RANGE if value & ~self._drive_mode_bits else StatusError.NONE

    def _refuse_operating_mode(self, value: int) -> StatusError:
        return StatusError.NONE if value in self._operating_modes else StatusError.DATA_RANGE

    def _refuse_protocol(self, value: int) -> StatusError:
        return StatusError.NONE if value in self._protocols else StatusError.DATA_RANGE

    def _refuse_torque(self, value: int) -> StatusError:
        return StatusError.RESULT_FAIL if value and self._is_shut_down() else StatusError.NONE

    def _refuse_watchdog(self, value: int) -> StatusError:
        expired = self._value("Bus Watchdog") == WATCHDOG_EXPIRED
        return StatusError.DATA_RANGE if value and expired else StatusError.NONE

    def _refuse_acceleration(self, value: int) -> StatusError:
        within = value <= self._value(ACCELERATION_LIMIT)
        return StatusError.NONE if within else StatusError.DATA_LIMIT

    def _refuse_port(self, mode_name: str, _value: int) -> StatusError:
        is_output = self._value(mode_name) == PORT_OUTPUT
        return StatusError.NONE if is_output else StatusError.ACCESS

    def _refuse_goal(self, limit_name: str, value: int) -> StatusError:
        if self._value("Bus Watchdog") == WATCHDOG_EXPIRED:
            return StatusError.DATA_RANGE
        limit = self._value(limit_name)
        return StatusError.NONE if -limit <= value <= limit else StatusError.DATA_LIMIT

    def _refuse_goal_position(self, value: int) -> StatusError:
        read = self._value
        if read("Bus Watchdog") == WATCHDOG_EXPIRED:
            return StatusError.DATA_RANGE
        if read("Operating Mode") != OperatingMode.POSITION:
            return StatusError.NONE
        low, high = read("Min Position Limit"), read("Max Position Limit")
        return StatusError.NONE if low <= value <= high else StatusError.DATA_LIMIT
