"""What the control tables of AX, MX with protocol 1.0 and XL-320 have in common.

Source: e-Manual, docs/en/dxl/ax, docs/en/dxl/mx and docs/en/dxl/x/xl320, "Control Table"; the
units of position and speed in "Goal Position(30)" and "Moving Speed(32)" there, that of
acceleration in "Goal Acceleration(73)".
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from firmware_sim.firmware.control_table import Access, Area, Register
from firmware_sim.firmware.model import Units

FIRST_RAM_ADDRESS = 24
"""Where the RAM area begins: Torque Enable(24)."""

FULL_SCALE = 1023
"""Count of a speed, load, torque or output register's ten bits at 100 %."""

DIRECTION_BIT = 1024
"""Bit 10 of a speed or load register: clockwise."""

POTENTIOMETER_STEPS = 1024
"""Positions of AX and XL-320 over `POTENTIOMETER_RANGE`."""

POTENTIOMETER_RANGE = math.radians(300.0)
"""Angle over which AX and XL-320 know where they are, rad."""

_RPM = 2.0 * math.pi / 60.0


@dataclass(frozen=True, slots=True)
class PotentiometerUnits(Units):
    """Units of a servo whose positions cover 300 of 360 degrees.

    ``ticks_per_turn`` is rounded from 1228.8; `angle` is exact.
    """

    @property
    def angle(self) -> float:
        """Rad of one step, 0.293 degrees."""
        return POTENTIOMETER_RANGE / POTENTIOMETER_STEPS


STEP_UNITS = PotentiometerUnits(
    ticks_per_turn=1229, velocity=0.111 * _RPM, acceleration=0.0, pwm_full=FULL_SCALE
)
"""Of AX and XL-320: 0.111 rev/min a count of speed; they have no register of acceleration."""

MX_UNITS = Units(
    ticks_per_turn=4096,
    velocity=0.114 * _RPM,
    acceleration=math.radians(8.583),
    pwm_full=FULL_SCALE,
)
"""Of MX with protocol 1.0: 0.114 rev/min, 8.583 deg/s^2."""

AX_BAUD_RATES: Mapping[int, int] = MappingProxyType(
    {code: round(2_000_000 / (code + 1)) for code in range(1, 255)}
)
"""bit/s by the code in Baud Rate(4): 1 Mbit/s down to 7843 bit/s."""

MX_BAUD_RATES: Mapping[int, int] = MappingProxyType(
    {code: round(2_000_000 / (code + 1)) for code in range(250)}
    | {250: 2_250_000, 251: 2_500_000, 252: 3_000_000}
)
"""bit/s by the code in Baud Rate(4): 2 Mbit/s down to 8000 bit/s, and three above."""


def classic_row(
    address: int,
    size: int,
    name: str,
    access: str,
    default: int,
    value_range: tuple[int, int] | None = None,
    unit: str = "",
) -> Register:
    """Return a register as `control_table.row` does, with these servos' border of the areas.

    Parameters
    ----------
    address, size, name
        See `Register`.
    access : str
        ``"R"`` or ``"RW"``.
    default : int
        Initial value; 0 where the manual has none.
    value_range : (int, int), optional
        Smallest and largest value; every unsigned value of this size by default.
    unit : str
        Of one count.

    Returns
    -------
    Register
        In EEPROM below address 24, in RAM from there on.
    """
    low, high = value_range or (0, 256**size - 1)
    area = Area.EEPROM if address < FIRST_RAM_ADDRESS else Area.RAM
    return Register(address, size, name, Access(access), area, default, low, high, unit)
