"""Many reaches judged as `armsyn.safety.check_trajectory` judges one, compiled."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.kernels.judging import Tolerances, judge_reaches
from armsyn.kernels.rates import RateLimits
from armsyn.planning.generation.pacing import Paced
from armsyn.safety import Clearances, collision, limits, trajectory

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


def judge(arm: ArmDescription, paced: Paced) -> Verdicts:
    """Hold reaches against an arm's ranges, speeds, accelerations, jerks and shapes.

    A contact in which a reach starts may be left, as with ``check_collision(leaving=True)``.

    Parameters
    ----------
    arm : ArmDescription
    paced : Paced
        A reach without frames is not judged.

    Returns
    -------
    Verdicts

    Raises
    ------
    InputError
        Shapes of the arm that touch at rest.
    """
    count = len(paced.scales)
    clearances = Clearances.of(arm)
    kinds, frames, items = np.empty((3, count), dtype=np.int64)
    found = Verdicts(kinds, frames, items, np.empty(count))
    judge_reaches(
        arm.chain.arrays,
        clearances.solids.arrays,
        clearances.solids.reach,
        clearances.required,
        RateLimits(arm.max_velocity, arm.max_acceleration, arm.max_jerk),
        float(paced.rate_hz),
        tolerances_at(paced.rate_hz),
        paced.first,
        paced.paths,
        *found,
    )
    return found
