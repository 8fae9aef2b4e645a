"""Other postures with the hand where it is: what a redundant arm can do at the end of a reach."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain
from armsyn.planning.posing import HandTask, settled

FloatArray = NDArray[np.float64]

SPACING = 0.06
"""Share of the arm's reach between one other posture and the next, of the joint that moves most."""

MOST = 6
"""Other postures to either side."""

_FREE = 1e-3
_SHORT_M = 5e-4
_TURNED = 5e-3
_STEP = 0.1
_STEPS = 60
"""Of `_STEP` rad of the joint that turns most: once round."""


class Swivel(NamedTuple):
    """Another posture with the hand where it was.

    Attributes
    ----------
    posture : array, shape (n,)
        rad or m.
    moved_m : float
        How far from where it was the joint is that moved most (the elbow, of an arm like a
        person's), m.
    """

    posture: FloatArray
    moved_m: float


def swivels(chain: SerialChain, task: HandTask, posture: FloatArray) -> Iterator[Swivel]:
    """Postures on the self-motion of an arm, to either side in turn, the nearest first.

    Each side follows the null space of the hand's Jacobian, in the direction that moves the arm's
    joints most, as far as the joints' limits let it.

    Parameters
    ----------
    chain : SerialChain
    task : HandTask
        What the hand must go on doing.
    posture : array, shape (n,)
        Where to start, in which it does so; rad or m.

    Yields
    ------
    Swivel
        None at all of an arm that has no joint to spare for the task.
    """
    ways = [_one_way(chain, task, posture, sign) for sign in (1.0, -1.0)]
    while ways:
        for way in list(ways):
            found = next(way, None)
            if found is None:
                ways.remove(way)
            else:
                yield found


def _one_way(
    chain: SerialChain, task: HandTask, posture: FloatArray, sign: float
) -> Iterator[Swivel]:
    origins = chain.positions(posture[None])[0]
    direction = sign * _self_motion(chain, task, posture)
    q, wanted = posture, 1
    for _ in range(_STEPS):
        if wanted > MOST or not direction.any():
            return
        ahead = np.clip(q + _STEP * direction, chain.lower, chain.upper)
        there = settled(chain, task, ahead, steps=8)
        distance, angle = task.errors(chain, there)
        if distance > _SHORT_M or angle > _TURNED or np.abs(there - q).max() < 0.2 * _STEP:
            return
        q = there
        moved = float(np.linalg.norm(chain.positions(q[None])[0] - origins, axis=1).max())
        if moved >= wanted * SPACING * chain.reach:
            yield Swivel(q, moved)
            wanted += 1
        onward = _self_motion(chain, task, q)
        direction = onward if onward @ direction >= 0.0 else -onward


def _self_motion(chain: SerialChain, task: HandTask, posture: FloatArray) -> FloatArray:
    """Unit change of posture that leaves the hand and moves the joints most; 0 for none."""
    _, jacobian = task.left(chain, posture)
    _, sizes, rows = np.linalg.svd(jacobian)
    rank = int(np.count_nonzero(sizes > _FREE * sizes[0]))
    free = rows[rank:]
    if not free.shape[0]:
        return np.zeros(chain.dof)
    moves = np.stack([_moves(chain, posture, along) for along in free], axis=1)
    _, speeds, mixes = np.linalg.svd(moves, full_matrices=False)
    if speeds[0] < _FREE * chain.reach:  # the hand's own roll, which moves nothing
        return np.zeros(chain.dof)
    found = mixes[0] @ free
    return np.asarray(found / np.abs(found).max())


def _moves(chain: SerialChain, posture: FloatArray, along: FloatArray) -> FloatArray:
    """How a change of posture moves all joints' origins, m/rad, by central differences."""
    pair = np.stack([posture + 1e-5 * along, posture - 1e-5 * along])
    there, back = chain.positions(pair)
    return np.asarray((there - back).ravel() / 2e-5)
