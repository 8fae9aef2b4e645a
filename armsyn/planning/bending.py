"""Bend a predicted motion: to another end posture, and back into the joints' ranges.

Both leave where it starts and how its hand travels: what one joint may not do, the others make up
for, frame by frame, by the smallest change of posture.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import LimitError
from armsyn.kernels.keeping import keep_hand
from armsyn.kinematics import SerialChain
from armsyn.planning.ending import EASE
from armsyn.planning.postures import tips

FloatArray = NDArray[np.float64]

_CLOSE_M = 1e-4
_PASSES = 12
INSIDE = 1e-6
"""rad (or m) past a limit that are rounding."""
_INSET = 0.01
"""rad (or m) inside its limit at which a joint is stopped, for splines swing a hair past."""
_DAMPING_M = 5e-3


def to_end(angles: FloatArray, end: FloatArray) -> FloatArray:
    """Return a motion that ends in another posture.

    The change comes in by minimum jerk (Flash and Hogan, 1985, eq. 6), so the start stays.

    Parameters
    ----------
    angles : array, shape (phases, n)
        rad or m.
    end : array, shape (n,)

    Returns
    -------
    array, shape (phases, n)
    """
    return np.asarray(angles + EASE[:, None] * (end - angles[-1]))


def keeping_hand(
    chain: SerialChain, angles: FloatArray, hand: FloatArray, fixed: FloatArray | None = None
) -> FloatArray | None:
    """Bring the hand of a motion back to a path, by the joints that are free to.

    Parameters
    ----------
    chain : SerialChain
    angles : array, shape (phases, n)
        rad or m.
    hand : array, shape (phases, 3)
        Where the hand is to be, m.
    fixed : array of bool, shape (n,), optional
        Joints that stay as they are.

    Returns
    -------
    array, shape (phases, n), or None
        The first row is unchanged; None where the hand cannot be brought back without a joint
        leaving its range, which would be a corner in the motion.
    """
    bent, path = np.array(angles), np.ascontiguousarray(hand)
    moving = np.ones(chain.dof) if fixed is None else np.where(fixed, 0.0, 1.0)
    if not keep_hand(chain.arrays, path, moving, _CLOSE_M, _DAMPING_M, _PASSES, bent):
        return None
    return None if leaves_range(chain, bent) and not leaves_range(chain, angles) else bent


def leaves_range(chain: SerialChain, angles: FloatArray) -> LimitError | None:
    """Return the refusal of a motion that leaves the joints' ranges; None for one that does not.

    Parameters
    ----------
    chain : SerialChain
    angles : array, shape (phases, n)
        rad or m.
    """
    beyond = np.maximum(chain.lower - angles, angles - chain.upper)
    frame, joint = divmod(int(beyond.argmax()), chain.dof)
    if beyond[frame, joint] <= INSIDE:
        return None
    name, value = chain.names[joint], float(angles[frame, joint])
    limit = float(chain.lower[joint] if value < chain.lower[joint] else chain.upper[joint])
    return LimitError(
        f"{name} would have to turn to {value:.3f} rad, its limit is {limit:.3f} rad:"
        " choose another target or --plan",
        name,
        value,
        limit,
    )


def within_ranges(chain: SerialChain, angles: FloatArray, *, inset: bool = False) -> FloatArray:
    """Bend a motion back into the joints' ranges; start and end stay, the hand on its path.

    A joint that would leave its range nears its limit smoothly instead, and the others bring the
    hand back to where it was, or, where they cannot, to the end only.

    Parameters
    ----------
    chain : SerialChain
    angles : array, shape (phases, n)
        rad or m; the first and the last row within the limits.
    inset : bool
        Bend also a motion whose samples are within the ranges, for the spline through them is not.

    Returns
    -------
    array, shape (phases, n)
        Within the limits, unless `leaves_range` still says otherwise.
    """
    if not inset and leaves_range(chain, angles) is None:
        return angles
    ends = angles[[0, -1]]
    lower = np.minimum(chain.lower + _INSET, ends.min(axis=0))
    upper = np.maximum(chain.upper - _INSET, ends.max(axis=0))
    bent = -_squeezed(-_squeezed(angles, upper), -lower)
    stopped = (bent != angles).any(axis=0)
    bent = to_end(bent, angles[-1])
    kept = keeping_hand(chain, bent, tips(chain, angles), stopped)
    return bent if kept is None else to_end(kept, angles[-1])


def _squeezed(angles: FloatArray, limit: FloatArray) -> FloatArray:
    """Take [knee, greatest] to [knee, limit] by a parabola that starts with slope 1.

    With width w = greatest - knee and excess e = greatest - limit it is x - e (x / w)^2, which
    still rises at its end where w >= 2 e. The knee lies neither below start nor end, which stay.
    """
    greatest = angles.max(axis=0)
    excess = np.maximum(greatest - limit, 0.0)
    knee = np.maximum(limit - excess, angles[[0, -1]].max(axis=0))
    width = np.maximum(greatest - knee, 1e-12)
    x = np.maximum(angles - knee, 0.0)
    return np.asarray(np.minimum(angles - excess * (x / width) ** 2, limit))
