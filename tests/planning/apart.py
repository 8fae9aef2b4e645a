"""What `armsyn.planning.allowed.tried` does in one compiled call, a part at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.kernels.bells import count_along
from armsyn.kernels.judging import judge_reaches
from armsyn.kernels.pacing import pace_reaches, sample_reaches
from armsyn.kernels.rates import RateLimits
from armsyn.kinematics import SerialChain
from armsyn.planning import timing
from armsyn.planning.evenness import measure_of
from armsyn.planning.pacing import EASE, Paced
from armsyn.planning.verdicts import Verdicts, tolerances_at
from armsyn.safety import Clearances

FloatArray = NDArray[np.float64]


def pace(arm: ArmDescription, angles: FloatArray, durations: FloatArray, rate_hz: float) -> Paced:
    """Ease, slow and sample many motions."""
    motions = np.ascontiguousarray(angles, dtype=np.float64)
    count = len(motions)
    frames, scales = np.empty(count, dtype=np.int64), np.empty(count)
    pace_reaches(
        motions,
        np.maximum(durations, timing.SHORTEST_S),
        RateLimits(*timing.Rates.of(arm)),
        float(rate_hz),
        max(1, round(timing.JERK_SPAN * rate_hz)),
        EASE,
        frames,
        scales,
    )
    first = np.concatenate([[0], np.cumsum(frames)])
    paths = np.empty((int(first[-1]), motions.shape[2]))
    sample_reaches(motions, EASE, first, paths)
    return Paced(paths, first, scales, rate_hz)


def judge(arm: ArmDescription, paced: Paced) -> Verdicts:
    """Hold reaches against an arm's ranges, speeds, accelerations, jerks and shapes."""
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


def uneven_reaches(chain: SerialChain, paced: Paced) -> NDArray[np.bool_]:
    """Which hands speed up more than once."""
    counts, rate = np.empty(len(paced.scales), dtype=np.int64), float(paced.rate_hz)
    count_along(
        chain.arrays, paced.paths, paced.first, rate, paced.scales, measure_of(rate), counts
    )
    return np.asarray(counts > 1)
