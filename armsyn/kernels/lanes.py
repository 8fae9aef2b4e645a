"""Many lanes played by generated code: packed into blocks, spread over threads, unpacked.

Lanes are played so whatever their number: a lane's result does not depend on its company. What
the generated code marks as doubtful is left to the caller, who has the plain kernels do it again.
"""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import NamedTuple

import numba
import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiled import Play, compiled
from armsyn.kernels.generator import WIDTH, Output, Plan, polynomial_ranges, rows_of
from armsyn.kernels.optimisers import OptimiserSettings
from armsyn.kernels.plain import Synergies, Task, Timing, ramp_value, roll_out
from armsyn.kernels.types import BoolArray, FloatArray, IntArray

_LEAST_SHARE = 20_000
"""Steps of lanes that are worth a thread: half a millisecond."""

_LEAST_OFFSET = -600.0
"""Below it e^offset, which is carried from frame to frame, is too small to grow again exactly."""


class Tasks(NamedTuple):
    """What each lane is to do.

    Attributes
    ----------
    starts : array, shape (lanes, n)
        Postures, rad or m.
    targets : array, shape (lanes, 3)
        Positions of the hand, m.
    motions : array of int, shape (lanes,)
        Whose frames and landmarks count; lanes of one motion share blocks.
    frames : array of int, shape (motions,)
        How many to play.
    landmarks : array, shape (motions, frames, landmarks, 3)
        m; of any shape for paths.
    """

    starts: FloatArray
    targets: FloatArray
    motions: IntArray
    frames: IntArray
    landmarks: FloatArray


class Played(NamedTuple):
    """What is known of each lane after its last frame.

    Attributes
    ----------
    totals : array, shape (lanes,)
        Sums of the distances to landmarks, m; zero where none were asked for.
    doubtful : array of bool, shape (lanes,)
        To be played again by the plain kernels.
    """

    totals: FloatArray
    doubtful: BoolArray


def plan_for(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    synergies: Synergies,
    timing: Timing,
    output: Output,
    rows: tuple[int, ...],
) -> Plan:
    """Choose the code that serves these lanes."""
    shared = synergies.slopes.shape[1] == 1
    damped_limits = timing.limit_rate * timing.dt < 1.0
    return Plan(chain, optimiser, shared, damped_limits, output, rows)


def play_plainly(
    chain: ChainArrays,
    optimiser: OptimiserSettings,
    synergies: Synergies,
    timing: Timing,
    tasks: Tasks,
    lane: int,
) -> tuple[FloatArray, FloatArray]:
    """Play one lane by the plain kernel.

    Returns
    -------
    tuple of (array, array)
        Postures, shape (frames, n), and positions of every joint and the tip, shape
        (frames, n + 1, 3), m.
    """
    path = np.empty((tasks.frames[tasks.motions[lane]], tasks.starts.shape[1]))
    path[0] = tasks.starts[lane]
    positions = np.empty((path.shape[0], path.shape[1] + 1, 3))
    task = Task(tasks.targets[lane], np.empty((0, 0)))
    gains, slopes, offsets = (part[lane] for part in synergies)
    roll_out(chain, optimiser, gains, slopes, offsets, timing, task, -1.0, path, positions)
    return path, positions


def play_lanes(
    plan: Plan, synergies: Synergies, timing: Timing, tasks: Tasks, out: FloatArray
) -> Played:
    """Play all lanes, in as many threads as numba may use and as are worth it.

    Parameters
    ----------
    plan : Plan
    synergies : Synergies
    timing : Timing
    tasks : Tasks
    out : array, shape (lanes, frames, values)
        Filled with the postures of a plan for paths, or with the gaps of one for gaps, whose
        lanes then all are of one motion.

    Returns
    -------
    Played
    """
    lanes = tasks.motions.size
    if not lanes:
        return Played(np.empty(0), np.empty(0, dtype=np.bool_))
    slots = _slots(tasks.motions)
    states = _states(plan, timing, synergies, tasks, slots)
    _play(compiled(plan), states, tasks, tasks.motions[slots[:, 0]], timing, out)
    rows, state = rows_of(plan), states.reshape(slots.shape[0], -1, WIDTH)
    played = Played(np.empty(lanes), np.empty(lanes, dtype=np.bool_))
    played.totals[slots] = state[:, rows.total]
    played.doubtful[slots] = state[:, rows.doubt] > 0.0
    return played


def _slots(motions: IntArray) -> IntArray:
    """Lanes of each block, shape (blocks, WIDTH): of one motion, the first again for the rest."""
    order = np.argsort(motions, kind="stable")
    counts = np.bincount(motions)
    padding = -counts % WIDTH
    before = np.cumsum(padding) - padding
    slots = np.full(motions.size + padding.sum(), -1)
    slots[np.arange(motions.size) + before[motions[order]]] = order
    blocks = slots.reshape(-1, WIDTH)
    return np.where(blocks < 0, blocks[:, :1], blocks)


def _states(
    plan: Plan, timing: Timing, synergies: Synergies, tasks: Tasks, slots: IntArray
) -> FloatArray:
    """State of every block before its first frame, shape (blocks, rows WIDTH)."""
    gains, slopes, offsets = synergies
    rows = rows_of(plan)
    with np.errstate(over="ignore"):
        powers, decays = np.exp(offsets), np.exp(-slopes * timing.dt)
    # Infinite powers make a lane doubtful at once
    powers[np.isfinite(offsets) & (offsets < _LEAST_OFFSET)] = np.inf
    powers[~(np.abs(tasks.starts) <= polynomial_ranges(plan.chain)).all(axis=1)] = np.inf
    state = np.zeros((tasks.motions.size, rows.size))
    parts = (tasks.starts, gains, powers, decays, tasks.targets)
    np.concatenate(parts, axis=1, out=state[:, : rows.doubt])
    return np.ascontiguousarray(state[slots].transpose(0, 2, 1)).reshape(slots.shape[0], -1)


def _play(
    play: Play,
    states: FloatArray,
    tasks: Tasks,
    motions: IntArray,
    timing: Timing,
    out: FloatArray,
) -> None:
    frames = tasks.frames[motions]
    factors = _factors(timing, int(frames.max()))
    share = timing.limit_rate * timing.dt
    landmarks = np.ascontiguousarray(tasks.landmarks)

    def part(first: int, last: int) -> None:
        play(states, frames, motions, first, last, factors, share, landmarks, out)

    first, *others = _parts(frames)
    if not others:
        part(*first)
        return
    with ThreadPoolExecutor(len(others)) as pool:
        waiting = [pool.submit(part, *other) for other in others]
        part(*first)
        for done in waiting:
            done.result()


@lru_cache(maxsize=16)
def _factors(timing: Timing, frames: int) -> FloatArray:
    """Lambda dt times the ramp of phi in every frame, shape (frames,)."""
    factors = np.full(frames, timing.rate * timing.dt)
    for frame in range(min(frames, int(timing.ramp / timing.dt) + 1)):
        factors[frame] *= ramp_value(frame * timing.dt, timing.ramp)
    return factors


def _parts(frames: IntArray) -> list[tuple[int, int]]:
    """First and last of the blocks that each thread plays, of about equal numbers of frames."""
    work = np.cumsum(frames)
    most = int(work[-1]) * WIDTH // _LEAST_SHARE
    threads = max(min(numba.get_num_threads(), most, frames.size), 1)
    inner = np.searchsorted(work, work[-1] * np.arange(1, threads) / threads)
    return list(itertools.pairwise([0, *inner.tolist(), frames.size]))
