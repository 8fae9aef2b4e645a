"""What measured joints tell about how an arm follows: its lag, and what it stands off."""

from __future__ import annotations

import math

from armsyn.kernels.compiling import kernel
from armsyn.kernels.types import BoolArray, FloatArray

OFF, EXPECTED, TRAILED, MOVED = range(4)
"""Rows of what is sensed: how far the arm stands off its commands, rad; where it is expected to
be, rad; and, of the line through the origin that tells a joint's lag, the two sums."""

LAGS_S = (0.01, 0.15)
"""Lags of servos that are believed, s."""

LARGEST_OFF = 0.1
"""rad that the arm may stand off its commands and be corrected for."""

SLOW = 0.1
"""rad/s at which a joint tells half as much of what it stands off as one at rest: the faster, the
more of its error is lag."""


@kernel
def sense(
    sensed: FloatArray,
    posture: FloatArray,
    velocity: FloatArray,
    position: FloatArray,
    fresh: BoolArray,
    span: float,
    share: float,
) -> None:
    """Learn from what was measured, `span` seconds after the last time.

    A joint is taken to trail its commands by a first-order lag, which the measurements tell as
    they go: the slope of commanded less measured over the speed expected.

    Parameters
    ----------
    sensed : array, shape (4, n)
        What is known of how measured joints differ from commands; written to.
    posture, velocity : array, shape (n,)
        As commanded, rad, rad/s.
    position : array, shape (n,)
        Measured last, rad.
    fresh : array of bool, shape (n,)
        Which joints were.
    span : float
        s.
    share : float
        Of what a resting arm stands off, how much to learn a second, 1/s; 0 for nothing.
    """
    for i in range(posture.shape[0]):
        q = posture[i]
        lag = min(max(sensed[TRAILED, i] / sensed[MOVED, i], LAGS_S[0]), LAGS_S[1])
        behind = q - sensed[EXPECTED, i]
        known = fresh[i] and math.isfinite(position[i])
        if known:
            speed = behind / lag
            sensed[TRAILED, i] += span * speed * (q - position[i])
            sensed[MOVED, i] += span * speed * speed
        sensed[EXPECTED, i] += behind * (1.0 - math.exp(-span / lag))
        if known:
            gap = position[i] - sensed[EXPECTED, i] - sensed[OFF, i]
            slow = SLOW / (SLOW + abs(velocity[i]))
            off = sensed[OFF, i] + min(span * share * slow, 1.0) * gap
            sensed[OFF, i] = min(max(off, -LARGEST_OFF), LARGEST_OFF)
