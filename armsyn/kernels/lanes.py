"""Many lanes played by generated code: packed into blocks, spread over threads, unpacked.

Lanes are played so whatever their number: a lane's result does not depend on its company. What
the generated code marks as doubtful is left to the caller, who has the plain kernels do it again.
"""

from __future__ import annotations

import itertools
import math
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import NamedTuple

import numba
import numpy as np

from armsyn.kernels.chain import ChainArrays
from armsyn.kernels.compiled import Play, compiled
from armsyn.kernels.compiling import kernel
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


@kernel
def _slots(motions: IntArray) -> IntArray:
    """Lanes of each block, shape (blocks, WIDTH): of one motion, the first again for the rest."""
    counts = np.bincount(motions)
    first = np.zeros(counts.size + 1, dtype=np.int64)
    for motion in range(counts.size):
        first[motion + 1] = first[motion] + (counts[motion] + WIDTH - 1) // WIDTH
    slots = np.empty((first[-1], WIDTH), dtype=np.int64)
    placed = np.zeros(counts.size, dtype=np.int64)
    for lane in range(motions.size):
        motion = motions[lane]
        block, place = divmod(placed[motion], WIDTH)
        if place == 0:
            slots[first[motion] + block] = lane
        slots[first[motion] + block, place] = lane
        placed[motion] += 1
    return slots


def _states(
    plan: Plan, timing: Timing, synergies: Synergies, tasks: Tasks, slots: IntArray
) -> FloatArray:
    """State of every block before its first frame, shape (blocks, rows WIDTH)."""
    state = np.zeros((slots.shape[0], rows_of(plan).size, WIDTH))
    ranges = polynomial_ranges(plan.chain)
    starts = np.ascontiguousarray(tasks.starts)  # or it would be compiled for either
    _fill_states(slots, synergies, timing.dt, ranges, starts, tasks.targets, state)
    return state.reshape(slots.shape[0], -1)


@kernel
def _fill_states(
    slots: IntArray,
    synergies: Synergies,
    dt: float,
    ranges: FloatArray,
    starts: FloatArray,
    targets: FloatArray,
    state: FloatArray,
) -> None:
    """Fill state, shape (blocks, rows, WIDTH), as `rows_of` says; infinite powers are doubtful."""
    gains, slopes, offsets = synergies
    n, k = gains.shape[1], slopes.shape[1]
    for block in range(slots.shape[0]):
        for place in range(WIDTH):
            lane = slots[block, place]
            within = True
            for j in range(n):
                state[block, j, place] = starts[lane, j]
                state[block, n + j, place] = gains[lane, j]
                within &= abs(starts[lane, j]) <= ranges[j]
            for j in range(k):
                offset = offsets[lane, j]
                small = -np.inf < offset < _LEAST_OFFSET
                power = math.exp(offset) if within and not small else np.inf
                state[block, 2 * n + j, place] = power
                state[block, 2 * n + k + j, place] = math.exp(-slopes[lane, j] * dt)
            for j in range(3):
                state[block, 2 * n + 2 * k + j, place] = targets[lane, j]


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
    if frames.size == 1:
        return [(0, 1)]
    work = np.cumsum(frames)
    most = int(work[-1]) * WIDTH // _LEAST_SHARE
    threads = max(min(numba.get_num_threads(), most, frames.size), 1)
    inner = np.searchsorted(work, work[-1] * np.arange(1, threads) / threads)
    return list(itertools.pairwise([0, *inner.tolist(), frames.size]))
