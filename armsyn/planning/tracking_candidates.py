"""With which synergies a new target may be reached for, and whether its reach is a new one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from armsyn.planning.tracking_state import Candidate, Going
from armsyn.synergy import SynergyLibrary

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
    library: SynergyLibrary,
    ik: str,
    model: str,
    hand: FloatArray,
    goal: FloatArray,
    going: Going | None,
) -> Iterator[Candidate]:
    """Synergies that may serve, the likeliest first.

    Parameters
    ----------
    library : SynergyLibrary
    ik, model : str
        As `armsyn.planning.tracking_plan.LawPlanner` has them.
    hand, goal : array, shape (3,)
        Where the hand is and is to go, m, base frame.
    going : Going or None
        What is followed until then.

    Yields
    ------
    Candidate
    """
    if going is not None and goes_on(going, goal, hand):
        then = going.planned
        phase = (then.law.clock + going.elapsed) / then.time_scale
        yield Candidate(
            then.learned, then.rank, then.synergy, then.time_scale, then.chosen_for, phase
        )
    for rank, (learned, chosen) in enumerate(library.nearest(hand, goal, ik, model)):
        yield Candidate(learned.name, rank, library.synergy(chosen), 1.0, goal)


def goes_on(going: Going, goal: FloatArray, hand: FloatArray) -> bool:
    """Whether a new target belongs to the reach that is on its way."""
    then = going.planned
    shift = float(np.linalg.norm(goal - then.law.target))
    streamed = going.elapsed <= STREAM_S and shift <= STREAM_M
    near = shift <= SAME_REACH * float(np.linalg.norm(goal - hand))
    return (near or streamed) and float(np.linalg.norm(goal - then.chosen_for)) <= SAME_PLACE
