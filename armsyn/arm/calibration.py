"""Ticks and radians: the one place where encoder units meet SI units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

RADIANS_PER_TICK = 2.0 * np.pi / 4096
"""X and MX series: 4096 ticks a turn (e-Manual, Present Position)."""

RADIANS_PER_COARSE_TICK = np.deg2rad(300.0) / 1023
"""AX series and XL-320: ticks 0 to 1023 cover 300 degrees (e-Manual, Goal Position)."""

_COARSE = ("ax-", "xl-320")


def radians_per_tick(model: str) -> float:
    """Angle of one tick of a servo model, by its name, rad."""
    return float(RADIANS_PER_COARSE_TICK if model.startswith(_COARSE) else RADIANS_PER_TICK)


@dataclass(frozen=True)
class Calibration:
    """Zero, direction and resolution of each servo.

    Parameters
    ----------
    zero_tick : array of int, shape (n,)
        Position register at the joint's zero.
    direction : array of int, shape (n,)
        1 or -1: sign between ticks and the joint's angle.
    radians_per_tick : array, shape (n,), or float
        Of each servo's position register.
    """

    zero_tick: IntArray
    direction: IntArray
    radians_per_tick: FloatArray | float = RADIANS_PER_TICK

    def to_ticks(self, angles: ArrayLike) -> IntArray:
        """Nearest ticks of joint angles, shape (..., n), rad."""
        turns = np.asarray(angles, dtype=np.float64) / self.radians_per_tick
        return np.asarray(np.rint(self.zero_tick + self.direction * turns), dtype=np.int64)

    def to_radians(self, ticks: ArrayLike) -> FloatArray:
        """Joint angles of ticks, shape (..., n), rad."""
        offset = np.asarray(ticks, dtype=np.float64) - self.zero_tick
        return np.asarray(self.direction * offset * self.radians_per_tick)
