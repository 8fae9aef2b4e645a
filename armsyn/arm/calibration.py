"""Ticks and radians: the one place where encoder units meet SI units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

RADIANS_PER_TICK = 2.0 * np.pi / 4096
"""X series: 4096 ticks a turn (e-Manual, Present Position)."""


@dataclass(frozen=True)
class Calibration:
    """Zero and direction of each servo.

    Parameters
    ----------
    zero_tick : array of int, shape (n,)
        Position register at the joint's zero.
    direction : array of int, shape (n,)
        1 or -1: sign between ticks and the joint's angle.
    """

    zero_tick: IntArray
    direction: IntArray

    def to_ticks(self, angles: ArrayLike) -> IntArray:
        """Nearest ticks of joint angles, shape (..., n), rad."""
        turns = np.asarray(angles, dtype=np.float64) / RADIANS_PER_TICK
        return np.asarray(np.rint(self.zero_tick + self.direction * turns), dtype=np.int64)

    def to_radians(self, ticks: ArrayLike) -> FloatArray:
        """Joint angles of ticks, shape (..., n), rad."""
        offset = np.asarray(ticks, dtype=np.float64) - self.zero_tick
        return np.asarray(self.direction * offset * RADIANS_PER_TICK)
