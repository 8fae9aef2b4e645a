"""Arms of one link on motors with round figures, for what can be worked out by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firmware_sim.physics import kernel
from firmware_sim.physics.axis import Axes, Axis
from firmware_sim.physics.motor_data import MotorData
from firmware_sim.physics.mujoco import MujocoPlant

TICK = 2.0 * np.pi / 4096
GRAVITY = 9.80665
MASS, REACH, THICKNESS = 0.5, 0.2, 1e-3
"""Of the link: kg, m from the axis to its centre of mass, kg m2 about that centre."""

MOTOR = MotorData(12.0, 4.0, 2.0, 46.0, 0.008)
P_GAIN = 800 / 128 / 885 / TICK
"""Duty per rad: the X series' default P gain of 800."""

STIFFNESS = P_GAIN * MOTOR.stall_torque
"""N m per rad at the nominal voltage."""

PENDULUM = f"""
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 {{gravity}}"/>
  <worldbody>
    <body>
      <joint name="hinge" axis="0 -1 0"/>
      <inertial pos="{REACH} 0 0" mass="{MASS}"
                diaginertia="{THICKNESS} {THICKNESS} {THICKNESS}"/>
    </body>
  </worldbody>
</mujoco>
"""
"""A link along x at zero, lifted by positive angles: gravity takes m g l cos(angle)."""

LINK_INERTIA = MASS * REACH**2 + THICKNESS
WEIGHT = MASS * GRAVITY * REACH
"""Greatest torque of gravity, N m."""


def seconds(duration: float) -> int:
    """Steps of physics."""
    return round(duration / kernel.STEP)


def make_axes(angles: Sequence[float], motor: MotorData = MOTOR) -> Axes:
    """Axes of one motor, torque off, with the default gain."""
    axes = Axes(len(angles))
    for axis, angle in zip(axes, angles, strict=True):
        axis.configure(motor, TICK, motor.nominal_voltage, angle)
        axis.set_position_gains(P_GAIN)
    return axes


def pendulum(
    angle: float, motor: MotorData = MOTOR, gravity: float = GRAVITY
) -> tuple[Axis, MujocoPlant]:
    """One motor with the link on it and a supply that does not sag."""
    axes = make_axes([angle], motor)
    mjcf = PENDULUM.format(gravity=-gravity)
    return axes[0], MujocoPlant(axes, mjcf, ["hinge"], supply_resistance=0.0)


def frictionless(axis: Axis, plant: MujocoPlant) -> None:
    """Take all losses from the gears."""
    axis.set_friction(0.0)
    plant.axes.state[:, kernel.DRAG] = 0.0
