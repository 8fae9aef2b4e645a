"""Stall torques of servos' motors, for how far their position loops give way under a load."""

from __future__ import annotations

_STALL: dict[str, tuple[float, float]] = {
    "xm430-w350": (4.1, 12.0),
    "xm430-w210": (3.0, 12.0),
    "xl430-w250": (1.5, 12.0),
    "2xl430-w250": (1.4, 11.1),
    "xc430-w150": (1.6, 12.0),
    "xc430-w240": (1.9, 12.0),
    "xm540-w270": (10.6, 12.0),
    "xm540-w150": (7.3, 12.0),
    "xl330-m077": (0.215, 5.0),
    "xl330-m288": (0.52, 5.0),
    "xc330-t288": (0.92, 11.1),
    "xc330-m288": (0.93, 5.0),
    "mx-28": (2.5, 12.0),
    "mx-64": (6.0, 12.0),
    "mx-106": (8.4, 12.0),
}
"""N m at V, by model (e-Manual, "Specifications", Stall Torque)."""


def stall_torque(model: str, volts: float) -> float:
    """Torque of a servo that stands at full duty, N m; NaN for a model that is not known.

    Parameters
    ----------
    model : str
        Such as ``xm430-w350``.
    volts : float
        At the servo.
    """
    torque, nominal = _STALL.get(model, (float("nan"), 1.0))
    return torque * volts / nominal
