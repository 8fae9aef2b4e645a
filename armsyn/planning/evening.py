"""Motions whose hands speed up twice, brought nearer to minimum jerk in steps, till one is a bell.

What a motion has beyond minimum jerk of every joint is first smoothed over phase, which keeps where
people go and takes what makes the hand hesitate; then less and less of it is left. On garza's ways
back, which have ends to be compared with, motions that are smoothed stay as near to the person's as
they were predicted; mixed with minimum jerk at once they go astray by a fifth more.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.planning.ending import EASE
from armsyn.planning.examples import PHASES

FloatArray = NDArray[np.float64]


class Evening(NamedTuple):
    """How the deviation from minimum jerk is changed.

    Attributes
    ----------
    smoothing : float
        The deviation is nought at start and end. Of the half waves that it consists of, the k-th is
        damped by exp(-smoothing (k^2 - 1)), as by diffusion: the first, a bow, stays.
    share : float
        Of it that is taken away, 0 to 1.
    """

    smoothing: float
    share: float


EVENINGS = (
    *(Evening(smoothing, 0.0) for smoothing in (0.01, 0.03, 0.09)),
    *(Evening(0.0, share) for share in (0.2, 0.4, 0.6, 0.8, 1.0)),
)
"""In the order in which they are tried. The last smoothing may take away more than the first share
does: it comes before it since what it leaves, the bow, is where people go."""
WHOLLY = EVENINGS[-1]


def evened(angles: FloatArray, how: Evening) -> FloatArray:
    """Bring motions nearer to minimum jerk of every joint.

    Parameters
    ----------
    angles : array, shape (..., PHASES, n)
        rad or m.
    how : Evening

    Returns
    -------
    array, shape (..., PHASES, n)
        With the same start and end.
    """
    if not how.smoothing:
        start, way = angles[..., :1, :], angles[..., -1:, :] - angles[..., :1, :]
        return np.asarray(angles + how.share * (start + EASE[:, None] * way - angles))
    joints = np.swapaxes(angles, -1, -2)
    smooth = joints.reshape(-1, PHASES) @ _smoother(how.smoothing).T  # one product, of all motions
    return np.ascontiguousarray(np.swapaxes(smooth.reshape(joints.shape), -1, -2))


def nearer(angles: FloatArray, how: Evening) -> FloatArray:
    """Return how much of the deviation from minimum jerk `evened` takes away, 0 to 1.

    Parameters
    ----------
    angles : array, shape (..., PHASES, n)
    how : Evening

    Returns
    -------
    array, shape (...,)
        Root mean square of what is taken, over joints and phases, by that of all there was.
    """
    if not how.smoothing:
        return np.full(angles.shape[:-2], how.share)
    whole, taken = evened(angles, WHOLLY) - angles, evened(angles, how) - angles
    sizes = [np.linalg.norm(part, axis=(-2, -1)) for part in (taken, whole)]
    return np.asarray(sizes[0] / np.maximum(sizes[1], np.finfo(float).tiny))


@cache
def _smoother(smoothing: float) -> FloatArray:
    """Matrix, shape (PHASES, PHASES), from a joint's angles over phase to the smoothed ones."""
    last = PHASES - 1
    k = np.arange(1, last)
    waves = np.sin(np.pi / last * np.outer(np.arange(PHASES), k))  # orthogonal: a sine transform
    waves[[0, -1]] = 0.0
    damped = 2.0 / last * (waves * np.exp(-smoothing * (k**2 - 1.0))) @ waves.T
    plain = np.zeros((PHASES, PHASES))
    plain[:, 0], plain[:, last] = 1.0 - EASE, EASE
    return np.asarray(plain + damped @ (np.eye(PHASES) - plain))
