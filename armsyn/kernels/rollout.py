"""Roll-outs: one motion, and many side by side by code generated for their chain.

Many lanes run as generated code whatever their number, so that a lane's result never depends on
its company. What that code marks as doubtful the plain kernels do again.
"""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor

import numba
import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiled import Play, compiled
from armsyn.kernels.generator import WIDTH, Plan, polynomial_ranges, rows_of
from armsyn.kernels.optimisers import OptimiserSettings
from armsyn.kernels.plain import (
    Captures,
    Synergies,
    Task,
    Timing,
    paper_distance,
    plain_distance_lanes,
    plain_roll_out_lanes,
    ramp_value,
    roll_out,
    task_error,
)
from armsyn.kernels.types import BoolArray, FloatArray, IntArray

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

_LEAST_SHARE = 40_000
"""Steps of lanes that are worth a thread: a millisecond."""

_LEAST_OFFSET = -600.0
"""Below it e^offset, which is carried from frame to frame, is too small to grow again exactly."""


def roll_out_lanes(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    synergies: Synergies,
    timing: Timing,
    targets: FloatArray,
    paths: FloatArray,
) -> None:
    """Fill `paths`, shape (lanes, frames, n), on all cores, rad or m.

    Lane k plays synergy k from the posture in its first row towards ``targets[k]``, shape (3,), m.
    """
    lanes, frames, _ = paths.shape
    plan = _plan(chain, optimiser, synergies, timing, ())
    slots = _slots(np.zeros(lanes, dtype=np.int64))
    states = _states(plan, timing, synergies, paths[:, 0], targets, slots)
    _play(
        compiled(plan),
        states,
        np.full(slots.shape[0], frames),
        np.zeros(slots.shape[0], dtype=np.int64),
        timing,
        np.empty((1, 1, 1, 3)),
        paths,
    )
    doubtful = _doubtful(plan, states, slots, lanes)
    if doubtful.any():
        again = np.ascontiguousarray(paths[doubtful])
        plain_roll_out_lanes(
            chain, optimiser, _some(synergies, doubtful), timing, targets[doubtful], again
        )
        paths[doubtful] = again


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
    plan = _plan(chain, optimiser, synergies, timing, tuple(captures.rows.tolist()))
    slots = _slots(motions)
    played = motions[slots[:, 0]]
    starts, targets = captures.starts[motions], captures.targets[motions]
    states = _states(plan, timing, synergies, starts, targets, slots)
    marks = np.ascontiguousarray(captures.landmarks)
    _play(
        compiled(plan),
        states,
        captures.frames[played],
        played,
        timing,
        marks,
        np.empty((0, 0, plan.dof)),
    )
    totals = states.reshape(slots.shape[0], -1, WIDTH)[:, rows_of(plan).total]
    result[slots] = totals / (captures.frames[played] * captures.rows.size)[:, None]
    doubtful = _doubtful(plan, states, slots, motions.size)
    if doubtful.any():
        again = np.empty(np.count_nonzero(doubtful))
        plain_distance_lanes(
            chain,
            optimiser,
            _some(synergies, doubtful),
            timing,
            captures,
            motions[doubtful],
            again,
        )
        result[doubtful] = again


def _plan(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    synergies: Synergies,
    timing: Timing,
    rows: tuple[int, ...],
) -> Plan:
    shared = synergies.slopes.shape[1] == 1
    return Plan(chain, optimiser, shared, timing.limit_rate * timing.dt < 1.0, rows)


def _some(synergies: Synergies, lanes: BoolArray) -> Synergies:
    return Synergies(*(part[lanes] for part in synergies))


def _slots(motions: IntArray) -> IntArray:
    """Lanes of each block, shape (blocks, WIDTH): of one motion, the first again for the rest."""
    order = np.argsort(motions, kind="stable")
    counts = np.bincount(motions)
    blocks = -(-counts // WIDTH)
    before = np.cumsum(blocks * WIDTH - counts) - (blocks * WIDTH - counts)
    slots = np.full(blocks.sum() * WIDTH, -1)
    slots[np.arange(motions.size) + before[motions[order]]] = order
    slots = slots.reshape(-1, WIDTH)
    return np.where(slots < 0, slots[:, :1], slots)


def _states(
    plan: Plan,
    timing: Timing,
    synergies: Synergies,
    starts: FloatArray,
    targets: FloatArray,
    slots: IntArray,
) -> FloatArray:
    """State of every block before its first frame, shape (blocks, rows WIDTH)."""
    gains, slopes, offsets = synergies
    rows = rows_of(plan)
    state = np.zeros((starts.shape[0], rows.size))
    with np.errstate(over="ignore"):
        powers, decays = np.exp(offsets), np.exp(-slopes * timing.dt)
    # Infinite powers make a lane doubtful at once
    powers[np.isfinite(offsets) & (offsets < _LEAST_OFFSET)] = np.inf
    powers[~(np.abs(starts) <= polynomial_ranges(plan.chain)).all(axis=1)] = np.inf
    parts = (starts, gains, powers, decays, targets)
    state[:, : rows.doubt] = np.concatenate(parts, axis=1)
    return np.ascontiguousarray(state[slots].transpose(0, 2, 1)).reshape(slots.shape[0], -1)


def _doubtful(plan: Plan, states: FloatArray, slots: IntArray, lanes: int) -> BoolArray:
    doubts = states.reshape(slots.shape[0], -1, WIDTH)[:, rows_of(plan).doubt]
    doubtful = np.empty(lanes, dtype=np.bool_)
    doubtful[slots] = doubts > 0.0
    return doubtful


def _play(
    play: Play,
    states: FloatArray,
    frames: IntArray,
    motions: IntArray,
    timing: Timing,
    marks: FloatArray,
    paths: FloatArray,
) -> None:
    """Play all blocks, in as many threads as numba may use and as are worth it."""
    steps = np.arange(frames.max(initial=0))
    ramps = np.array([ramp_value(step * timing.dt, timing.ramp) for step in steps])
    factors = timing.rate * timing.dt * ramps
    share = timing.limit_rate * timing.dt
    work = np.cumsum(frames * WIDTH)
    threads = min(numba.get_num_threads(), int(work[-1] // _LEAST_SHARE) + 1, work.size)
    bounds = np.searchsorted(work, work[-1] * np.arange(1, threads) / threads)
    parts = list(itertools.pairwise([0, *bounds.tolist(), work.size]))

    def chunk(first: int, last: int) -> None:
        play(states, frames, motions, first, last, factors, share, marks, paths)

    if threads == 1:
        chunk(*parts[0])
        return
    with ThreadPoolExecutor(threads - 1) as pool:
        others = [pool.submit(chunk, *part) for part in parts[1:]]
        chunk(*parts[0])
        for other in others:
            other.result()
