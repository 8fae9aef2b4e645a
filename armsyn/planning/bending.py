"""Bend a predicted motion: to another end posture, and back into the joints' ranges.

Both leave where it starts and how its hand travels: what one joint may not do, the others make up
for, frame by frame, by the smallest change of posture.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import LimitError
from armsyn.kinematics import SerialChain
from armsyn.planning.postures import jacobians

FloatArray = NDArray[np.float64]

_CLOSE_M = 1e-4
_PASSES = 12
_INSIDE = 1e-6
"""rad (or m) past a limit that are rounding."""
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
    x = np.linspace(0.0, 1.0, angles.shape[0])[:, None]
    return np.asarray(angles + x**3 * (10.0 - 15.0 * x + 6.0 * x**2) * (end - angles[-1]))


def keeping_hand(
    chain: SerialChain, angles: FloatArray, hand: FloatArray, fixed: FloatArray | None = None
) -> FloatArray:
    """Bring the hand of a motion back to a path, within the joints' limits as far as they let it.

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
    array, shape (phases, n)
        The first row is unchanged.
    """
    bent = np.array(angles)
    moving = np.ones(chain.dof) if fixed is None else np.where(fixed, 0.0, 1.0)
    for _ in range(_PASSES):
        gap = hand - chain.positions(bent)[:, -1]
        gap[0] = 0.0
        if np.linalg.norm(gap, axis=1).max() < _CLOSE_M:
            break
        J = jacobians(chain, bent) * moving
        square = J @ J.transpose(0, 2, 1) + _DAMPING_M**2 * np.eye(3)
        bent += np.einsum("fij,fi->fj", J, np.linalg.solve(square, gap[..., None])[..., 0])
        bent = np.clip(bent, np.minimum(angles, chain.lower), np.maximum(angles, chain.upper))
    return bent


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
    if beyond[frame, joint] <= _INSIDE:
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


def within_ranges(chain: SerialChain, angles: FloatArray) -> FloatArray:
    """Bend a motion back into the joints' ranges; the hand stays on its path.

    A joint that would leave its range nears its limit smoothly instead, and the others bring the
    hand back to where it was. A target at which they cannot is missed, which the caller has to
    judge.

    Parameters
    ----------
    chain : SerialChain
    angles : array, shape (phases, n)
        rad or m; the first row within the limits.

    Returns
    -------
    array, shape (phases, n)
        Within the limits.
    """
    if leaves_range(chain, angles) is None:
        return np.clip(angles, chain.lower, chain.upper)
    hand, bent = chain.positions(angles)[:, -1], angles
    stopped = np.zeros(chain.dof, dtype=bool)
    for _ in range(chain.dof):
        out = ((bent < chain.lower - _INSIDE) | (bent > chain.upper + _INSIDE)).any(axis=0)
        if not out.any():
            break
        bent = _saturated(bent, chain.lower, chain.upper)
        stopped |= out
        bent = keeping_hand(chain, bent, hand, stopped)
    return np.clip(bent, chain.lower, chain.upper)


def _saturated(angles: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Squeeze what lies beyond a limit into the range, monotonously and without corners."""
    below = -_squeezed(-angles, -lower)
    return _squeezed(below, upper)


def _squeezed(angles: FloatArray, limit: FloatArray) -> FloatArray:
    """Take [knee, greatest] to [knee, limit] by a parabola that starts with slope 1.

    With width w = greatest - knee and excess e = greatest - limit it is x - e (x / w)^2, which
    still rises at its end where w >= 2 e.
    """
    greatest = angles.max(axis=0)
    excess = np.maximum(greatest - limit, 0.0)
    # not before the start: that posture is where the arm is
    knee = np.maximum(np.minimum(limit - excess, greatest), angles[0])
    width = np.maximum(greatest - knee, 1e-12)
    x = np.maximum(angles - knee, 0.0)
    return np.asarray(np.minimum(angles - excess * (x / width) ** 2, np.maximum(limit, angles[0])))
