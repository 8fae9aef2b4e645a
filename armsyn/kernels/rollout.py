"""Roll-outs: one motion, and many lanes side by side by code generated for their chain."""

from __future__ import annotations

import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.lanes import Tasks, plan_for, play_lanes, play_plainly
from armsyn.kernels.optimisers import OptimiserSettings
from armsyn.kernels.plain import (
    Captures,
    Synergies,
    Task,
    Timing,
    paper_distance,
    roll_out,
    task_error,
)
from armsyn.kernels.types import FloatArray, IntArray

__all__ = [
    "Captures",
    "Synergies",
    "Task",
    "Timing",
    "distance_lanes",
    "paper_distance",
    "roll_out",
    "roll_out_lanes",
    "task_error",
]


def roll_out_lanes(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    synergies: Synergies,
    timing: Timing,
    targets: FloatArray,
    paths: FloatArray,
) -> None:
    """Fill `paths`, shape (lanes, frames, n), rad or m.

    Lane k plays synergy k from the posture in its first row towards ``targets[k]``, shape (3,), m.
    """
    lanes, frames, _ = paths.shape
    plan = plan_for(chain, optimiser, synergies, timing, "paths", ())
    motions = np.zeros(lanes, dtype=np.int64)
    tasks = Tasks(paths[:, 0], targets, motions, np.array([frames]), np.empty((1, 1, 1, 3)))
    doubtful = play_lanes(plan, synergies, timing, tasks, paths).doubtful
    for lane in np.flatnonzero(doubtful).tolist():
        paths[lane], _ = play_plainly(chain, optimiser, synergies, timing, tasks, lane)


def distance_lanes(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    synergies: Synergies,
    timing: Timing,
    captures: Captures,
    motions: IntArray,
    result: FloatArray,
) -> None:
    """Fill `result`, shape (lanes,), with the paper's distance of each lane to its capture, m.

    Lane k plays synergy k against capture ``motions[k]`` over all of that capture's frames.
    """
    rows = tuple(captures.rows.tolist())
    plan = plan_for(chain, optimiser, synergies, timing, "distances", rows)
    starts, targets = captures.starts[motions], captures.targets[motions]
    tasks = Tasks(starts, targets, motions, captures.frames, captures.landmarks)
    played = play_lanes(plan, synergies, timing, tasks, np.empty((0, 0, 0)))
    result[:] = played.totals / (captures.frames[motions] * len(rows))
    for lane in np.flatnonzero(played.doubtful).tolist():
        _, positions = play_plainly(chain, optimiser, synergies, timing, tasks, lane)
        landmarks = captures.landmarks[motions[lane], : positions.shape[0]]
        result[lane] = paper_distance(positions, captures.rows, landmarks)
