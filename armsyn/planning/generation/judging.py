"""Many reaches judged as `armsyn.safety.check_trajectory` judges one, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.kernels.judging import ALLOWED, Tolerances, judge_reaches
from armsyn.kernels.rates import RateLimits
from armsyn.planning.generation.pacing import Paced
from armsyn.safety import Clearances, collision, limits, trajectory

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


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
        Tolerances(
            position=limits.POSITION_TOLERANCE,
            rate=trajectory.RATE_TOLERANCE,
            rounding=trajectory.ROUNDING,
            jerk_span=max(1, round(trajectory.JERK_SPAN * paced.rate_hz)),
            leaving=collision.LEAVING,
            resolution=collision.RESOLUTION,
        ),
        paced.first,
        paced.paths,
        *found,
    )
    return found


def judge_some(arm: ArmDescription, paced: Paced, asked: BoolArray) -> Verdicts:
    """Judge some reaches, as `judge` does; say `ALLOWED`, and no more, of the others.

    Parameters
    ----------
    arm : ArmDescription
    paced : Paced
    asked : array of bool, shape (M,)

    Returns
    -------
    Verdicts
    """
    lengths, count = paced.lengths, len(asked)
    first = np.concatenate([[0], np.cumsum(lengths[asked])])
    paths = paced.paths[np.repeat(asked, lengths)]
    kinds, frames, items = np.full((3, count), ALLOWED, dtype=np.int64)
    found = Verdicts(kinds, frames, items, np.full(count, np.nan))
    some = judge(arm, Paced(paths, first, paced.scales[asked], paced.rate_hz))
    for whole, part in zip(found, some, strict=True):
        whole[asked] = part
    return found
