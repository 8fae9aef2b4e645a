"""The checks of what servos report now and then: temperature, current, voltage."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import ServoLoadError
from armsyn.safety.limits import CommandLimits
from armsyn.safety.state import TickState

FloatArray = NDArray[np.float64]

CURRENT_MEMORY = 0.5
"""Time constant of the smoothing of currents before they are judged, s: accelerating takes short
ones."""

WARM = 5.0
"""Degrees Celsius below its limit at which a servo is warned of."""


def check_load(state: TickState, limits: CommandLimits) -> ServoLoadError | None:
    """Whether no servo is too hot, takes too much current or has a wrong voltage.

    Parameters
    ----------
    state : TickState
    limits : CommandLimits

    Returns
    -------
    ServoLoadError or None
    """
    n = (len(limits.names),)
    for value, beyond, limit, text in (
        (
            state.temperature,
            state.temperature > limits.max_temperature,
            limits.max_temperature,
            "is {0:.0f} degrees Celsius hot, {1:.0f} are allowed: let it cool down",
        ),
        (
            state.current,
            np.abs(state.current) > limits.max_current,
            limits.max_current,
            "takes {0:.2f} A, {1:.2f} A are allowed: something holds it, or the load is too much",
        ),
        (
            state.voltage,
            state.voltage < limits.min_voltage,
            limits.min_voltage,
            "is supplied with {0:.1f} V, at least {1:.1f} V are needed: check supply and cables",
        ),
        (
            state.voltage,
            state.voltage > limits.max_voltage,
            limits.max_voltage,
            "is supplied with {0:.1f} V, at most {1:.1f} V are allowed: check the supply",
        ),
    ):
        if beyond.any():
            joint = int(np.argmax(beyond))
            found, most = float(np.broadcast_to(value, n)[joint]), float(limit[joint])
            name = limits.names[joint]
            return ServoLoadError(
                f"joint {name}: its servo {text.format(found, most)}", name, found, most
            )
    return None


def warm_joints(state: TickState, limits: CommandLimits) -> tuple[str, ...]:
    """Names of the joints whose servos are within `WARM` of too hot, or beyond."""
    warm = np.broadcast_to(state.temperature > limits.max_temperature - WARM, (len(limits.names),))
    return tuple(name for name, is_warm in zip(limits.names, warm, strict=True) if is_warm)


def averaged_current(average: FloatArray, current: FloatArray, period: float) -> FloatArray:
    """Let an average of how much current flows, either way, take in what flows now.

    It is smoothed exponentially with the time constant `CURRENT_MEMORY`. Of currents that change
    their sign the magnitude counts: they heat a servo as much, and would cancel otherwise.

    Parameters
    ----------
    average, current : array, shape (n,)
        A; NaN where unknown. An unknown average begins with the magnitude of the current, and an
        unknown current leaves the average as it is.
    period : float
        Since the last one, s.

    Returns
    -------
    array, shape (n,)
        A, not negative.
    """
    share = min(period / CURRENT_MEMORY, 1.0)
    current = np.abs(current)
    moved = np.where(np.isnan(average), current, average + share * (current - average))
    return np.where(np.isnan(current), average, moved)
