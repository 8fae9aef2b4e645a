"""What servos' motors and position loops hold, by model, as they leave the factory."""

from __future__ import annotations

import math
from typing import NamedTuple

from armsyn.arm.calibration import radians_per_tick

FULL_PWM = 885
"""Counts of PWM that are the whole voltage (e-Manual, Goal PWM: 0.113 % each)."""


class Motor(NamedTuple):
    """A row of `MOTORS`.

    Attributes
    ----------
    stall_torque : float
        N m at `voltage` (e-Manual, "Specifications", Stall Torque).
    voltage : float
        V.
    p_gain : int or None
        Initial Position P Gain (e-Manual, "Control Table"); None where the loop is another one.
    """

    stall_torque: float
    voltage: float
    p_gain: int | None


MOTORS: dict[tuple[str, int], Motor] = {
    ("xm430-w350", 2): Motor(4.1, 12.0, 800),
    ("xm430-w210", 2): Motor(3.0, 12.0, 800),
    ("xl430-w250", 2): Motor(1.5, 12.0, 640),
    ("2xl430-w250", 2): Motor(1.4, 11.1, 640),
    ("xc430-w150", 2): Motor(1.6, 12.0, 460),
    ("xc430-w240", 2): Motor(1.9, 12.0, 700),
    ("xm540-w270", 2): Motor(10.6, 12.0, 800),
    ("xm540-w150", 2): Motor(7.3, 12.0, 800),
    ("xl330-m077", 2): Motor(0.215, 5.0, 400),
    ("xl330-m288", 2): Motor(0.52, 5.0, 400),
    ("xc330-t288", 2): Motor(0.92, 11.1, 900),
    ("xc330-m288", 2): Motor(0.93, 5.0, 1100),
    ("mx-28", 2): Motor(2.5, 12.0, 850),
    ("mx-64", 2): Motor(6.0, 12.0, 850),
    ("mx-106", 2): Motor(8.4, 12.0, 850),
    ("ax-12a", 1): Motor(1.5, 12.0, None),
    ("ax-18a", 1): Motor(1.8, 12.0, None),
}
"""By model and protocol."""

_COMPLIANCE_SLOPE = 32
"""Ticks of error to full output of AX servos (e-Manual, Compliance Slope: initial value)."""


def position_stiffness(model: str, protocol: int, volts: float, p_gain: int | None = None) -> float:
    """How stiff a servo's position loop is.

    Without an integral part an error makes P/128 counts of PWM a tick (e-Manual, "Position PID
    Gain"), `FULL_PWM` counts are the whole voltage, and that gives the stall torque to a shaft
    that stands: (P / 128) / 885 / tick times stall torque times voltage over nominal voltage. AX
    servos give all they have at `_COMPLIANCE_SLOPE` ticks (their punch and margin are left out).

    Parameters
    ----------
    model : str
        Such as ``xm430-w350``.
    protocol : {1, 2}
    volts : float
        At the servo.
    p_gain : int, optional
        Its Position P Gain as it reads; the model's initial one by default.

    Returns
    -------
    float
        N m/rad; NaN for a servo whose loop is not known (MX with protocol 1.0, XL-320).
    """
    motor = MOTORS.get((model, protocol))
    if motor is None:
        return math.nan
    gain = motor.p_gain if p_gain is None else p_gain
    duty = 1.0 / _COMPLIANCE_SLOPE if gain is None else gain / 128.0 / FULL_PWM
    return duty / radians_per_tick(model) * motor.stall_torque * volts / motor.voltage
