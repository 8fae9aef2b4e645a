"""What differs between models of servos, beside their control tables."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_sim.control_table import ControlTable

TICKS_PER_TURN = 4096
"""Encoder counts of one turn of the horn, X series (e-Manual, "Degree of Precision")."""

PWM_FULL = 885
"""Register count of a PWM of 100 % (e-Manual, "Goal PWM(100)": 0.113 % a count)."""

VELOCITY_UNIT = 0.229 * TICKS_PER_TURN / 60
"""Ticks per second of one velocity count (e-Manual, "Goal Velocity(104)": 0.229 rev/min)."""

ACCELERATION_UNIT = 214.577 * TICKS_PER_TURN / 3600
"""Ticks per second squared of one acceleration count (e-Manual: 214.577 rev/min^2)."""

X_BAUD_RATES = (9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
"""Baud rates by the code in Baud Rate(8), bit/s (e-Manual, "Baud Rate(8)")."""


@dataclass(frozen=True, slots=True)
class MotorData:
    """A motor with its gears, at the horn, as its data sheet has it.

    Parameters
    ----------
    nominal_voltage : float
        Of the figures below, V.
    stall_torque : float
        N m.
    stall_current : float
        A.
    no_load_speed : float
        rev/min.
    inertia : float
        Rotor and gears seen from the horn, with a light horn, kg m^2. No data sheet has it: it is
        chosen for a mechanical time constant of about 10 ms.
    """

    nominal_voltage: float
    stall_torque: float
    stall_current: float
    no_load_speed: float
    inertia: float


@dataclass(frozen=True, slots=True)
class ServoModel:
    """One model.

    Parameters
    ----------
    name : str
        The maker's, in lower case.
    number : int
        What Model Number(0) reads.
    firmware : int
        What Firmware Version(6) reads; the control table is that firmware's.
    table : ControlTable
        Its registers.
    baud_rates : tuple of int
        By the code in Baud Rate(8), bit/s.
    drive_mode_bits : int
        The bits of Drive Mode(10) that are modelled; others are refused.
    current_unit : float or None
        Amperes of one count of Present Current(126); None where 126 is Present Load, in 0.1 %.
    motor : MotorData
        Its motor.
    """

    name: str
    number: int
    firmware: int
    table: ControlTable
    baud_rates: tuple[int, ...]
    drive_mode_bits: int
    current_unit: float | None
    motor: MotorData
