"""A direct-current motor with its gears, seen from the horn.

The voltage on the winding is the duty of the PWM times the supply. Without inductance the current
is what voltage and back-EMF leave over, and torque follows current, so speed follows the voltage
as a first-order lag:

    tau dv/dt = v0 (u s - T/T0) - v,    i = i0 (u s - v/v0),    tau = J v0 / T0

with no-load speed v0, stall torque T0 and stall current i0 at the nominal voltage, duty u in [-1,
1], supply over nominal voltage s, load torque T, and inertia J. Within one step u and T are
constant, so the step is exact. Losses i^2 R heat one thermal mass.
"""

from __future__ import annotations

import math

from firmware_sim.model import TICKS_PER_TURN, MotorData

STEP = 1.0e-3
"""Length of one step of physics and of the position loop, s."""

AMBIENT_TEMPERATURE = 25.0
"""Of the air, degrees Celsius."""

THERMAL_RESISTANCE = 8.0
"""Winding to air, K/W. No data sheet has it: chosen so that a fifth of the stall current, which the
maker calls the rating for continuous use, warms an XM430-W350 by about 9 K."""

THERMAL_TIME = 240.0
"""Time constant of warming, s; chosen, see `THERMAL_RESISTANCE`."""

COASTING_TIME = 0.02
"""Time constant of gears running down without torque, s; chosen: geared motors stop at once."""


class Motor:
    """Angle, speed, current and temperature of one motor.

    Parameters
    ----------
    data : MotorData
        Its data sheet.
    angle : float
        At the start, ticks, counter-clockwise positive, over all turns.
    supply_voltage : float
        V.
    """

    __slots__ = (
        "_coasting",
        "_copper",
        "_decay",
        "_lag",
        "_no_load_speed",
        "_stall_current",
        "_stall_torque",
        "_supply",
        "_warming",
        "angle",
        "current",
        "load_torque",
        "pull",
        "temperature",
        "velocity",
    )

    def __init__(self, data: MotorData, angle: float, supply_voltage: float) -> None:
        self.angle = angle
        self.velocity = 0.0  # ticks/s
        self.current = 0.0  # A
        self.temperature = AMBIENT_TEMPERATURE
        self.load_torque = 0.0
        """External torque against the positive direction, N m."""
        self.pull = 0.0
        """Speed that present voltage and load would settle at, ticks/s."""
        speed = data.no_load_speed / 60.0
        self._no_load_speed = speed * TICKS_PER_TURN
        self._stall_torque = data.stall_torque
        self._stall_current = data.stall_current
        self._supply = supply_voltage / data.nominal_voltage
        self._copper = data.nominal_voltage / data.stall_current * THERMAL_RESISTANCE  # K/A^2
        self._lag = data.inertia * speed * 2.0 * math.pi / data.stall_torque
        self._decay = math.exp(-STEP / self._lag)
        self._coasting = math.exp(-STEP / COASTING_TIME)
        self._warming = 1.0 - math.exp(-STEP / THERMAL_TIME)

    @property
    def relative_torque(self) -> float:
        """Torque of the motor over its stall torque at nominal voltage."""
        return self.current / self._stall_current

    def drive(self, duty: float) -> None:
        """Go on by one step with a voltage on the winding.

        Parameters
        ----------
        duty : float
            Of the PWM, -1 to 1.
        """
        voltage = duty * self._supply
        pull = self._no_load_speed * (voltage - self.load_torque / self._stall_torque)
        surplus = self.velocity - pull
        kept = surplus * self._decay
        self.velocity = pull + kept
        self.angle += pull * STEP + (surplus - kept) * self._lag
        self.pull = pull
        self.current = self._stall_current * (voltage - self.velocity / self._no_load_speed)
        self._warm(self._warming)

    def coast(self) -> None:
        """Go on by one step with the winding open: gears stop it, and loads do not move it."""
        kept = self.velocity * self._coasting
        self.angle += (self.velocity - kept) * COASTING_TIME
        self.velocity = kept
        self.pull = 0.0
        self.current = 0.0
        self._warm(self._warming)

    def rest(self, duration: float) -> None:
        """Let time pass with speed and current as they are: only the temperature goes on.

        Parameters
        ----------
        duration : float
            s.
        """
        self._warm(1.0 - math.exp(-duration / THERMAL_TIME))

    def _warm(self, share: float) -> None:
        target = AMBIENT_TEMPERATURE + self._copper * self.current * self.current
        self.temperature += (target - self.temperature) * share
