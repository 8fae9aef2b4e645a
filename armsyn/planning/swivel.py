"""Other postures with the hand where it is: what a redundant arm can do at the end of a reach."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.swivelling import next_swivel, self_motion
from armsyn.kinematics import SerialChain
from armsyn.planning.posing import HandTask

FloatArray = NDArray[np.float64]

SPACING = 0.06
"""Share of the arm's reach between one other posture and the next, of the joint that moves most."""

MOST = 6
"""Other postures to either side."""

_STEPS = 60
"""Of `armsyn.kernels.swivelling.STEP` rad of the joint that turns most: once round."""


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
    q, origins, direction = np.array(posture), np.empty((chain.dof + 1, 3)), np.empty(chain.dof)
    _, jacobian = task.left(chain, q)
    self_motion(chain.arrays, jacobian, chain.reach, q, direction, origins)
    direction *= sign
    what, steps = (*task.arguments(chain), chain.reach), _STEPS
    for wanted in range(1, MOST + 1):
        least = wanted * SPACING * chain.reach
        steps, moved = next_swivel(chain.arrays, *what, origins, least, steps, q, direction)
        if moved < 0.0:
            return
        yield Swivel(q.copy(), moved)
