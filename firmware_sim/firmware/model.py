"""What differs between models of servos, beside their control tables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from firmware_sim.firmware.control_table import ControlTable
from firmware_sim.physics.motor_data import MotorData

__all__ = [
    "ALL_MODES",
    "MODES_WITHOUT_CURRENT",
    "PWM_FULL",
    "TICKS_PER_TURN",
    "X_BAUD_RATES",
    "MotorData",
    "ServoModel",
    "Units",
]

TICKS_PER_TURN = 4096
"""Encoder counts of one turn of the horn, X series (e-Manual, "Degree of Precision")."""

PWM_FULL = 885
"""Register count of a PWM of 100 % (e-Manual, "Goal PWM(100)": 0.113 % a count)."""

X_BAUD_RATES: Mapping[int, int] = MappingProxyType(
    {
        0: 9_600,
        1: 57_600,
        2: 115_200,
        3: 1_000_000,
        4: 2_000_000,
        5: 3_000_000,
        6: 4_000_000,
        7: 4_500_000,
    }
)
"""Baud rates by the code in Baud Rate(8), bit/s (e-Manual, "Baud Rate(8)")."""

ALL_MODES = frozenset((0, 1, 3, 4, 5, 16))
"""Operating modes of a servo that senses its current (e-Manual, "Operating Mode(11)")."""

MODES_WITHOUT_CURRENT = frozenset((1, 3, 4, 16))
"""Operating modes of a servo that does not, as the XL430."""


@dataclass(frozen=True, slots=True)
class Units:
    """What one count of a register means, in SI units at the horn.

    Parameters
    ----------
    ticks_per_turn : int
        Encoder counts of one turn of the horn.
    velocity : float
        rad/s of one count of a velocity register.
    acceleration : float
        rad/s^2 of one count of an acceleration register.
    pwm_full : int
        Count of a PWM register at full duty.
    """

    ticks_per_turn: int = TICKS_PER_TURN
    velocity: float = 0.229 * 2.0 * math.pi / 60.0
    acceleration: float = 214.577 * 2.0 * math.pi / 3600.0
    pwm_full: int = PWM_FULL

    @property
    def angle(self) -> float:
        """Rad of one tick."""
        return 2.0 * math.pi / self.ticks_per_turn


@dataclass(frozen=True, slots=True)
class ServoModel:
    """One model with one layout of its control table.

    Parameters
    ----------
    name : str
        The maker's, in lower case.
    number : int
        What Model Number(0) reads.
    firmware : int
        What Firmware Version(6) reads.
    table : ControlTable
        Its registers.
    baud_rates : mapping of int to int
        bit/s by the code in Baud Rate.
    drive_mode_bits : int
        The bits of Drive Mode(10) that it knows; others are refused.
    current_unit : float or None
        Amperes of one count of Present Current(126); None where 126 is Present Load, in 0.1 %.
    motor : MotorData
        Its motor.
    protocol : int
        1 or 2: what it speaks from the factory.
    protocols : frozenset of int
        All that it can be set to.
    units : Units
        Of its registers.
    family : str
        ``"x"`` (X series, MX with protocol 2.0), ``"classic"`` (AX, MX with protocol 1.0) or
        ``"xl320"``.
    operating_modes : frozenset of int
        Values that Operating Mode(11) takes.
    first_firmware, last_firmware : int, int or None
        Which firmware versions have this layout; None for an open end.
    backup_from, fast_from : int or None
        Firmware from which control table backup and fast reads are understood; None for never.
    detects : int
        Bits of Hardware Error Status(70) that it can set ("Shutdown(63)").
    pwm_slope_unit : float or None
        V per ms of one count of PWM Slope(62); None without that register.
    senses_input : bool
        Whether it measures its current where that comes from the supply, not in the winding.
    """

    name: str
    number: int
    firmware: int
    table: ControlTable
    baud_rates: Mapping[int, int]
    drive_mode_bits: int
    current_unit: float | None
    motor: MotorData
    protocol: int = 2
    protocols: frozenset[int] = frozenset((2,))
    units: Units = Units()
    family: str = "x"
    operating_modes: frozenset[int] = ALL_MODES
    first_firmware: int = 0
    last_firmware: int | None = None
    backup_from: int | None = None
    fast_from: int | None = None
    detects: int = 0x3D
    pwm_slope_unit: float | None = None
    senses_input: bool = False

    @property
    def understands_backup(self) -> bool:
        """Whether its firmware knows the instruction control table backup."""
        return self.backup_from is not None and self.firmware >= self.backup_from

    @property
    def understands_fast_reads(self) -> bool:
        """Whether its firmware knows fast sync read and fast bulk read."""
        return self.fast_from is not None and self.firmware >= self.fast_from
