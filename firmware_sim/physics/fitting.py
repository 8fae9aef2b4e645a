"""From the figures of a data sheet to the constants of the motor's equations."""

from __future__ import annotations

import math

from firmware_sim.physics import kernel as k
from firmware_sim.physics.motor_data import MotorData

_NEARLY_STANDING = 0.02
"""Share of the no-load speed below which a shaft nearly stands (for overload); chosen."""

_MASS = 0.082
"""Of an XM430, to which the two figures below belong, kg (e-Manual, "Specifications")."""

_THERMAL_RESISTANCE = 8.0
"""Winding to air, K/W. No data sheet has it: chosen so that a fifth of the stall current, which the
maker calls the rating for continuous use, warms an XM430-W350 by about 9 K."""

_THERMAL_TIME = 240.0
"""Time constant of warming, s; chosen. A servo of another size takes the power of 2/3 of the ratio
of the masses less of the first, since its surface grows so, and 1/3 more of the second, since the
product of the two is its heat capacity, which grows as the mass."""

_LEAST_DRAG = 1.0e-3
"""Share below which drag is not taken: the closed form of free running divides by it."""


def fit_motor(row: memoryview[float], motor: MotorData) -> None:
    """Put a data sheet's figures into the columns of the motor.

    Torque is the current's alone, so that the stall current gives the stall torque; the back-EMF is
    such that the losses of the gears leave the no-load speed at the nominal voltage.

    Parameters
    ----------
    row : memoryview of float
        An axis' row of the state.
    motor : MotorData
        The data sheet.
    """
    speed = motor.no_load_speed * 2.0 * math.pi / 60.0
    resistance = motor.nominal_voltage / motor.stall_current
    torque_constant = motor.stall_torque / motor.stall_current
    drag_share = max(motor.drag, _LEAST_DRAG)
    lost = motor.friction + drag_share
    back_emf = motor.nominal_voltage * (1.0 - lost) / speed
    drag = drag_share * motor.stall_torque / speed
    row[k.RESISTANCE] = resistance
    row[k.TORQUE_CONSTANT] = torque_constant
    row[k.BACK_EMF] = back_emf
    row[k.INERTIA] = motor.inertia
    row[k.DRAG] = drag
    row[k.FRICTION] = motor.friction * motor.stall_torque
    row[k.BACKLASH] = motor.backlash
    row[k.DRIVEN_LAG] = motor.inertia / (torque_constant * back_emf / resistance + drag)
    row[k.FREE_LAG] = motor.inertia / drag
    row[k.DRIVEN_KEPT] = math.exp(-k.STEP / row[k.DRIVEN_LAG])
    row[k.FREE_KEPT] = math.exp(-k.STEP / row[k.FREE_LAG])
    row[k.NEARLY_STANDING] = _NEARLY_STANDING * speed
    _fit_heat(row, motor.mass)


def _fit_heat(row: memoryview[float], mass: float) -> None:
    """Scale the XM430's figures by surface, mass^(2/3), and by heat capacity, mass."""
    size = mass / _MASS
    row[k.THERMAL_RESISTANCE] = _THERMAL_RESISTANCE * size ** (-2.0 / 3.0)
    row[k.THERMAL_TIME] = _THERMAL_TIME * size ** (1.0 / 3.0)
    row[k.WARMING] = 1.0 - math.exp(-k.STEP / row[k.THERMAL_TIME])
