"""The gains of the control loops: from registers to duty over SI units.

Source: e-Manual, "Position PID Gain(80, 82, 84), Feedforward 1st/2nd Gains(88, 90)" and "Velocity
PI Gain(76, 78)": the controllers use P/128, I/65536, D/16, feed-forward/4. Where the manual is
silent: they make PWM counts; position errors are in ticks and velocity errors in velocity counts;
I, D and feed-forward count per control period, which is taken to be 1 ms.
"""

from __future__ import annotations

from firmware_sim.firmware.memory import Memory
from firmware_sim.firmware.model import Units
from firmware_sim.physics.axis import Axis
from firmware_sim.physics.kernel import STEP

GAIN_NAMES = (
    "Velocity I Gain",
    "Velocity P Gain",
    "Position D Gain",
    "Position I Gain",
    "Position P Gain",
    "Feedforward 2nd Gain",
    "Feedforward 1st Gain",
)


def set_gains(axis: Axis, memory: Memory, units: Units) -> None:
    """Give an axis the gains that its registers hold.

    Parameters
    ----------
    axis : Axis
        What is driven.
    memory : Memory
        The registers.
    units : Units
        Of them.
    """
    value = memory.value
    per_angle = 1.0 / (units.pwm_full * units.angle)
    per_velocity = 1.0 / (units.pwm_full * units.velocity)
    axis.set_position_gains(
        value("Position P Gain") / 128.0 * per_angle,
        value("Position I Gain") / 65_536.0 * per_angle,
        value("Position D Gain") / 16.0 * per_angle,
        value("Feedforward 1st Gain") / 4.0 * per_angle * STEP,
        value("Feedforward 2nd Gain") / 4.0 * per_angle * STEP * STEP,
    )
    axis.set_velocity_gains(
        value("Velocity P Gain") / 128.0 * per_velocity,
        value("Velocity I Gain") / 65_536.0 * per_velocity,
    )
