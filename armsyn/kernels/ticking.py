"""A tick of an arm that follows a law: what its joints measured, and what is commanded next."""

from __future__ import annotations

import math

import numpy as np

from armsyn.kernels.arm_numbers import unpacked
from armsyn.kernels.compiling import kernel
from armsyn.kernels.following import (
    EXPECTED,
    MOVED,
    OFF,
    POSTURE,
    TRAILED,
    VELOCITY,
    advance,
)
from armsyn.kernels.types import BoolArray, FloatArray

LAGS_S = (0.01, 0.15)
"""Lags of servos that are believed, s."""

LARGEST_OFF = 0.1
"""rad that the arm may stand off its commands and be corrected for."""

SLOW = 0.1
"""rad/s at which a joint tells half as much of what it stands off as one at rest: the faster, the
more of its error is lag."""


@kernel
def _sense(
    state: FloatArray, position: FloatArray, fresh: BoolArray, span: float, share: float
) -> None:
    """Learn from what was measured, `span` seconds after the last time.

    A joint is taken to trail its commands by a first-order lag, which the measurements tell as
    they go: the slope of commanded less measured over the speed expected.
    """
    for i in range(state.shape[1]):
        q = state[POSTURE, i]
        lag = min(max(state[TRAILED, i] / state[MOVED, i], LAGS_S[0]), LAGS_S[1])
        behind = q - state[EXPECTED, i]
        known = fresh[i] and abs(position[i]) < math.inf
        if known:
            speed = behind / lag
            state[TRAILED, i] += span * speed * (q - position[i])
            state[MOVED, i] += span * speed * speed
        state[EXPECTED, i] += behind * (1.0 - math.exp(-span / lag))
        if known:
            gap = position[i] - state[EXPECTED, i] - state[OFF, i]
            slow = SLOW / (SLOW + abs(state[VELOCITY, i]))
            off = state[OFF, i] + min(span * share * slow, 1.0) * gap
            state[OFF, i] = min(max(off, -LARGEST_OFF), LARGEST_OFF)


@kernel  # keeps other threads waiting: to take up Python again would cost more than it takes
def tick(
    arm: FloatArray,
    hand: FloatArray,
    joints: FloatArray,
    state: FloatArray,
    position: FloatArray,
    fresh: BoolArray,
    elapsed: float,
    span: float,
    longest: float,
    share: float,
) -> tuple[FloatArray, float, float]:
    """Learn from what was measured, then follow a law for `span` seconds, in one call.

    Parameters
    ----------
    arm, hand, joints, elapsed
        As `follow`; velocities are kept within the bounds.
    state : array, shape (7, n)
        How the arm moves.
    position : array, shape (n,)
        Measured last, rad.
    fresh : array of bool, shape (n,)
        Which joints were.
    span : float
        s.
    longest : float
        Longest step, s.
    share : float
        Of what a resting arm stands off, how much to learn a second, 1/s; 0 for nothing.

    Returns
    -------
    tuple of (array, float, float)
        How the arm moves then; the hand's distance to its target, m; and the fastest joint's
        speed, rad/s.
    """
    then = state.copy()
    _sense(then, position, fresh, span, share)
    steps = max(1, math.ceil(span / longest - 1e-6))
    plain, path = unpacked(arm, state.shape[1]), np.empty((0, state.shape[1]))
    step = span / steps
    done = advance(plain, hand, joints, then, elapsed, step, steps, -1.0, True, path)
    return then, done.distance, done.fastest
