"""Residuals of roll-outs against captured landmarks, for least squares."""

from __future__ import annotations

import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.lanes import Tasks, plan_for, play_lanes, play_plainly
from armsyn.kernels.optimisers import OptimiserSettings
from armsyn.kernels.plain import Captures, Synergies, Timing
from armsyn.kernels.types import FloatArray


def residual_lanes(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    synergies: Synergies,
    timing: Timing,
    captures: Captures,
    motion: int,
    result: FloatArray,
) -> None:
    """Fill `result`, shape (lanes, frames, landmarks, 3), with synthesized minus captured, m.

    Lane k plays synergy k against capture `motion`; the mean of the norms over frames and
    landmarks is the paper's distance (3.4).
    """
    lanes, frames, marks, _ = result.shape
    rows = tuple(captures.rows.tolist())
    plan = plan_for(chain, optimiser, synergies, timing, "gaps", rows)
    starts = np.repeat(captures.starts[motion : motion + 1], lanes, axis=0)
    targets = np.repeat(captures.targets[motion : motion + 1], lanes, axis=0)
    landmarks = captures.landmarks[motion : motion + 1]
    motions = np.zeros(lanes, dtype=np.int64)
    tasks = Tasks(starts, targets, motions, np.array([frames]), landmarks)
    out = np.empty((lanes, frames, 3 * marks))
    doubtful = play_lanes(plan, synergies, timing, tasks, out).doubtful
    result[:] = out.reshape(result.shape)
    for lane in np.flatnonzero(doubtful).tolist():
        _, positions = play_plainly(chain, optimiser, synergies, timing, tasks, lane)
        result[lane] = positions[:, captures.rows] - landmarks[0, :frames]
