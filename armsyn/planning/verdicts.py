"""What is said of many reaches that are judged as `armsyn.safety.check_trajectory` judges one."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.judging import Tolerances
from armsyn.safety import collision, limits, trajectory

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class Verdicts(NamedTuple):
    """What is to be said against each reach.

    Attributes
    ----------
    kinds : array of int, shape (M,)
        `armsyn.kernels.judging.ALLOWED` or what it breaks.
    frames : array of int, shape (M,)
        Where; of a contact, the frame at or before which it begins.
    items : array of int, shape (M,)
        The joint, or the pair of shapes (`Solids.names`).
    values : array, shape (M,)
        The angle, rate (rad and s, or m) or least clearance (m) that is refused.
    """

    kinds: IntArray
    frames: IntArray
    items: IntArray
    values: FloatArray


@cache
def tolerances_at(rate_hz: float) -> Tolerances:
    """Return what `armsyn.safety.check_trajectory` forgives at a rate of frames."""
    return Tolerances(
        position=limits.POSITION_TOLERANCE,
        rate=trajectory.RATE_TOLERANCE,
        rounding=trajectory.ROUNDING,
        jerk_span=max(1, round(trajectory.JERK_SPAN * rate_hz)),
        leaving=collision.LEAVING,
        resolution=collision.RESOLUTION,
    )
