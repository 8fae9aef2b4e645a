"""With which synergies a new target may be reached for, and whether its reach is a new one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from armsyn.planning.posing import HandOrientation, HandTask
from armsyn.planning.tracking_sources import Source
from armsyn.planning.tracking_state import Candidate, Going

FloatArray = NDArray[np.float64]

SAME_REACH = 0.25
"""A target that has moved by no more than this share of what is left to it is the same reach's:
synergy, slowing and clock go on."""

STREAM_S = 0.25
STREAM_M = 0.03
"""So is one that has moved by no more than that within that time of the last."""

SAME_PLACE = 0.15
"""But not beyond this distance from the target that the synergy was chosen for, m."""


def candidates(
    sources: tuple[Source, ...],
    posture: FloatArray,
    hand: FloatArray,
    task: HandTask,
    going: Going | None,
) -> Iterator[Candidate]:
    """Synergies that may serve, the likeliest first.

    Parameters
    ----------
    sources : tuple of Source
    posture : array, shape (n,)
        Where the arm is, rad.
    hand : array, shape (3,)
        Where its hand is, m, base frame.
    task : HandTask
        Where it is to go.
    going : Going or None
        What is followed until then.

    Yields
    ------
    Candidate
    """
    if going is not None and goes_on(going, task, hand):
        then = going.planned
        phase = (then.law.clock + going.elapsed) / then.chosen.scale
        yield then.chosen._replace(phase=phase)
    for source in sources:
        yield from source.candidates(posture, hand, task.goal)


def goes_on(going: Going, task: HandTask, hand: FloatArray) -> bool:
    """Whether a new target belongs to the reach that is on its way."""
    then, goal = going.planned, task.goal
    if not _same(then.task.orientation, task.orientation):
        return False
    shift = float(np.linalg.norm(goal - then.task.goal))
    streamed = going.elapsed <= STREAM_S and shift <= STREAM_M
    near = shift <= SAME_REACH * float(np.linalg.norm(goal - hand))
    return (near or streamed) and float(np.linalg.norm(goal - then.chosen.chosen_for)) <= SAME_PLACE


def _same(one: HandOrientation | None, other: HandOrientation | None) -> bool:
    """Whether two tasks want the hand turned alike."""
    if one is None or other is None:
        return one is other
    return one.angles == other.angles and np.array_equal(one.wanted, other.wanted)
