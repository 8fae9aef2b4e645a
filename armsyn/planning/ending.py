"""Predicted motions led to the exact start and end that were asked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain
from armsyn.planning.examples import PHASE
from armsyn.planning.leading import lead_each
from armsyn.planning.postures import descent_of

FloatArray = NDArray[np.float64]

FADE = 1.0 - PHASE
EASE = PHASE**3 * (10 - 15 * PHASE + 6 * PHASE**2)
"""Minimum jerk from 0 to 1 (Flash and Hogan 1985)."""


def led_to(
    chain: SerialChain, angles: FloatArray, starts: FloatArray, targets: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Move motions to their starts and targets, as the human floor does with a mean of repeats.

    The offset to the start fades out linearly; the end is led to the target along minimum jerk, by
    the change of posture that inverse kinematics finds there. A joint that would leave its range on
    the way stays at its limit meanwhile.

    Parameters
    ----------
    chain : SerialChain
    angles : array, shape (M, PHASES, n)
        rad or m.
    starts : array, shape (M, n)
        First postures.
    targets : array, shape (M, 3)
        Where the hand is to end, base frame, m.

    Returns
    -------
    angles : array, shape (M, PHASES, n)
        Starting at `starts` exactly.
    errors : array, shape (M,)
        Distance of the hand to the target at the end, m.
    """
    return _led(chain, angles, starts, targets)


def ended_at(
    chain: SerialChain, angles: FloatArray, targets: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Move motions to their targets only; see `led_to`."""
    return _led(chain, angles, angles[:, 0], targets)


def carried_to(
    chain: SerialChain, angles: FloatArray, starts: FloatArray, targets: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Carry over to other starts what motions have beyond minimum jerk.

    From start to end every joint goes by minimum jerk. What the given motion deviates from its own
    minimum jerk is added, in proportion to how much of its hand's way is gone again: all of it from
    where it starts, the less the shorter the way and the more it turns from there, none of it on a
    way across or back. The end is found, and joints are kept within their ranges, as by `led_to`,
    whose parameters and returns these are.
    """
    return _led(chain, angles, starts, targets, fade=1.0 - EASE, scaled=True)


def _led(
    chain: SerialChain,
    angles: FloatArray,
    starts: FloatArray,
    targets: FloatArray,
    *,
    fade: FloatArray = FADE,
    scaled: bool = False,
) -> tuple[FloatArray, FloatArray]:
    led, errors = np.array(angles, order="C"), np.empty(len(angles))
    first, goals = np.array(starts, order="C"), np.ascontiguousarray(targets)
    lead_each(chain.arrays, first, goals, fade, EASE, scaled, descent_of(chain), led, errors)
    return led, errors
