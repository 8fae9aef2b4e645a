"""How stiffly an AX holds its goal, and what stands for that in the servos with PID gains.

Output over position error, to either side of the goal: none up to the compliance margin, there
punch at once, from there in proportion up to full output where the compliance slope ends. "CCW"
names the side on which the servo pushes counter-clockwise. Torque Limit caps it.

Sources: e-Manual, docs/en/dxl/ax/ax-12a, "Compliance Slope (28, 29)" (its seven steps and the
diagram), "Punch (48)"; ROBOTIS, RX-64 User's Manual, page 27, for which side is which, and for an
example in figures. MX and XL-320: _includes/en/dxl/control_table_mx_pid, whose table says which P
gain does what a slope did; it leaves the unit of the output open, so that this table sets it here:
a P gain p acts as a slope of 1024/p steps of 0.293 degrees, and I and D keep their proportion.
"""

from __future__ import annotations

from dataclasses import dataclass

from firmware_sim.classic.rows import FULL_SCALE, STEP_UNITS
from firmware_sim.firmware.memory import Memory

_SMALLEST_SLOPE, _LARGEST_SLOPE = 2, 128
_SLOPE_TIMES_GAIN = 1024
_CONTROLLER_P, _CONTROLLER_I, _CONTROLLER_D = 1.0 / 8.0, 1000.0 / 2048.0, 4.0 / 1000.0


def slope_used(value: int) -> int:
    """Return the slope, in steps, that a value of Compliance Slope(28, 29) stands for.

    Parameters
    ----------
    value : int
        0 to 254.

    Returns
    -------
    int
        The largest power of two that is not larger, from 2 to 128.
    """
    return min(_LARGEST_SLOPE, max(_SMALLEST_SLOPE, 1 << max(0, value.bit_length() - 1)))


@dataclass(frozen=True, slots=True)
class Side:
    """What holds the servo on one side of its goal.

    Parameters
    ----------
    margin : float
        Error without output, rad.
    slope : float
        Duty per rad beyond the margin, on top of the punch.
    """

    margin: float
    slope: float


@dataclass(frozen=True, slots=True)
class Compliance:
    """The whole curve of output over error.

    Parameters
    ----------
    counter_clockwise, clockwise : Side
        Where it pushes that way.
    punch : float
        Duty at the margin's edge.
    """

    counter_clockwise: Side
    clockwise: Side
    punch: float


def compliance(memory: Memory) -> Compliance:
    """Return what the compliance registers and Punch(48) of an AX make."""
    punch = memory.value("Punch") / FULL_SCALE
    return Compliance(_side(memory, "CCW", punch), _side(memory, "CW", punch), punch)


def _side(memory: Memory, side: str, punch: float) -> Side:
    steps = slope_used(memory.value(f"{side} Compliance Slope"))
    margin = memory.value(f"{side} Compliance Margin") * STEP_UNITS.angle
    return Side(margin, (1.0 - punch) / (steps * STEP_UNITS.angle))


@dataclass(frozen=True, slots=True)
class Gains:
    """A PID controller from an error of position to a duty.

    Parameters
    ----------
    proportional, integral, derivative : float
        Duty per rad, per rad s, and per rad/s.
    """

    proportional: float
    integral: float
    derivative: float


def gains(memory: Memory) -> Gains:
    """Return what P, I and D Gain of an MX or XL-320 make."""
    unit = 1.0 / (_CONTROLLER_P * _SLOPE_TIMES_GAIN * STEP_UNITS.angle)
    return Gains(
        memory.value("P Gain") * _CONTROLLER_P * unit,
        memory.value("I Gain") * _CONTROLLER_I * unit,
        memory.value("D Gain") * _CONTROLLER_D * unit,
    )
