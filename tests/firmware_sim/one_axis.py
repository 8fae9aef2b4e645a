"""One axis on a plant of its own, and the data sheets that hand calculations start from."""

import math

from firmware_sim.physics.axis import Axes
from firmware_sim.physics.kernel import STEP
from firmware_sim.physics.motor_data import MotorData
from firmware_sim.physics.plant import JointsPlant

TICK = 2.0 * math.pi / 4096
"""Encoder count of an X-series servo, rad."""

DATA_SHEETS = {  # e-Manual, "Specifications"; inertia chosen
    "xm430-w350": MotorData(12.0, 4.1, 2.3, 46.0, 0.0085),
    "xm540-w270": MotorData(12.0, 10.6, 4.4, 30.0, 0.034),
    "xl430-w250": MotorData(12.0, 1.5, 1.4, 61.0, 0.0023),
    "xl330-m288": MotorData(5.0, 0.52, 1.47, 103.0, 0.00048),
}


class OneAxis:
    """An axis and its plant, with an ideal supply unless another is asked for."""

    def __init__(
        self,
        motor: MotorData | str = "xm430-w350",
        supply: float | None = None,
        start: float = 0.0,
        supply_resistance: float = 0.0,
    ) -> None:
        self.motor = DATA_SHEETS[motor] if isinstance(motor, str) else motor
        self.axes = Axes(1)
        self.axis = self.axes[0]
        voltage = self.motor.nominal_voltage if supply is None else supply
        self.axis.configure(self.motor, TICK, voltage, start)
        self.plant = JointsPlant(self.axes, supply_resistance)

    def run(self, duration: float) -> None:
        """Advance by a duration, s."""
        self.plant.advance(round(duration / STEP))

    @property
    def no_load_speed(self) -> float:
        """At nominal voltage, rad/s."""
        return self.motor.no_load_speed * 2.0 * math.pi / 60.0

    @property
    def relative_torque(self) -> float:
        """Of the motor, over its stall torque: as its current over the stall current."""
        return self.axis.current / self.motor.stall_current

    @property
    def friction(self) -> float:
        """Coulomb friction, N m."""
        return self.motor.friction * self.motor.stall_torque

    @property
    def drag(self) -> float:
        """Speed-dependent loss, N m per rad/s."""
        return self.motor.drag * self.motor.stall_torque / self.no_load_speed

    def held(self, p: float = 4.6) -> "OneAxis":
        """Switch position control on, with a gain in duty per rad (4.6: P of 800 / 128)."""
        self.axis.set_position_gains(p)
        self.axis.hold()
        return self
