"""The present values in registers 120 to 146, made when somebody reads them.

Source: e-Manual, "Realtime Tick(120)" to "Present Temperature(146)". The manual does not say how
near counts as in position, nor how far as a following error: see the constants.
"""

from __future__ import annotations

import math
import struct

from firmware_sim.actuator import Actuator
from firmware_sim.drive import PositionDrive
from firmware_sim.memory import Memory
from firmware_sim.model import VELOCITY_UNIT, ServoModel

IN_POSITION = 10.0
"""Distance to the goal that counts as in position, ticks."""

FOLLOWING_ERROR = 100.0
"""Distance to the trajectory that counts as a following error, ticks."""

FIRST = 120
"""Address of the first such register."""

_LAYOUT = struct.Struct("<HBBhhiiiiHB")

END = FIRST + _LAYOUT.size
"""Address after the last."""

_TICK_WRAP = 32_768
_ONGOING = 0x02
_REACHED = 0x01
_FOLLOWING = 0x08


def write_present(memory: Memory, model: ServoModel, actuator: Actuator, uptime: float) -> None:
    """Put the present values into their registers.

    Parameters
    ----------
    memory : Memory
        Where they go.
    model : ServoModel
        Whose they are.
    actuator : Actuator
        What they are read from.
    uptime : float
        Since the last boot, s.
    """
    drive, frame = actuator.drive, actuator.frame
    motor = drive.motor
    sign = frame.direction
    fast = abs(motor.velocity) > memory.value("Moving Threshold") * VELOCITY_UNIT
    _LAYOUT.pack_into(
        memory.data,
        FIRST,
        math.floor(uptime * 1e3 + 1e-6) % _TICK_WRAP,  # Realtime Tick
        fast or drive.under_way,  # Moving
        moving_status(drive),  # Moving Status
        round(sign * drive.pwm),  # Present PWM
        sign * _effort(model, actuator),  # Present Current, or Present Load
        round(sign * motor.velocity / VELOCITY_UNIT),  # Present Velocity
        frame.position(motor.angle),  # Present Position
        round(sign * drive.trajectory_velocity / VELOCITY_UNIT),  # Velocity Trajectory
        frame.position(drive.trajectory),  # Position Trajectory
        round(actuator.supply_voltage * 10.0),  # Present Input Voltage
        min(255, round(motor.temperature)),  # Present Temperature
    )


def moving_status(drive: PositionDrive) -> int:
    """Return what Moving Status(123) reads."""
    status = int(drive.kind)
    if drive.under_way:
        status |= _ONGOING
    elif abs(drive.goal - drive.motor.angle) <= IN_POSITION:
        status |= _REACHED
    if abs(drive.trajectory - drive.motor.angle) > FOLLOWING_ERROR:
        status |= _FOLLOWING
    return status


def _effort(model: ServoModel, actuator: Actuator) -> int:
    """Return the current in the model's unit, or torque in 0.1 % where none is sensed."""
    motor = actuator.drive.motor
    if model.current_unit is not None:
        return round(motor.current / model.current_unit)
    return max(-1000, min(1000, round(motor.relative_torque * 1000.0)))
