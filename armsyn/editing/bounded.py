"""A prioritised step inside linear bounds: level by level, a least-squares problem with limits.

In the latent space a joint's limit is not a coordinate to be fixed but a half-space, G x <= h, for
every frame and limited joint. Each level is solved within what the levels above leave free
(hierarchical least squares; Kanoun, Lamiraux and Wieber 2011), and each of these problems by
Lawson and Hanson's least-distance programming ("Solving Least Squares Problems", chapter 23).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from armsyn.editing.priorities import RANK, Damping, Level, priority_step

FloatArray = NDArray[np.float64]
_LEAST_DAMPING = 1e-9
_ROUNDING = 1e-11
"""rad and m."""


class Bounds(NamedTuple):
    """Half-spaces G x <= h that hold at x = 0.

    Attributes
    ----------
    G : array, shape (bounds, q)
    h : array, shape (bounds,)
        Not negative.
    """

    G: FloatArray
    h: FloatArray


def bounded_step(
    levels: Sequence[Level],
    damping: Damping,
    bounds: Bounds,
    x: FloatArray,
    z: FloatArray | None = None,
) -> FloatArray:
    """Solve one step that keeps x within bounds.

    Parameters
    ----------
    levels : sequence of Level
        The first priority first.
    damping : Damping
    bounds : Bounds
    x : array, shape (q,)
        Where the step starts; within the bounds.
    z : array, shape (q,), optional
        What to do with what freedom is left.

    Returns
    -------
    array, shape (q,)
        The step of `priority_step` where that stays inside; within the bounds to rounding.
    """
    slack = np.maximum(bounds.h - bounds.G @ x, 0.0)
    free, _ = priority_step(levels, damping, z)
    if (bounds.G @ free <= slack).all():
        return free
    step, Z = np.zeros(x.size), np.eye(x.size)
    wishes = [*levels] if z is None else [*levels, Level(np.eye(x.size), z)]
    for J, error in wishes:
        A = J @ Z
        whole = float(np.linalg.norm(J, 2))
        xi = damping.value * whole if damping.relative else damping.value
        xi = max(xi, _LEAST_DAMPING * max(whole, 1.0))
        left = np.maximum(slack - bounds.G @ step, 0.0)
        step = step + Z @ _within(A, error - J @ step, xi, bounds.G @ Z, left)
        _, s, V = np.linalg.svd(A, full_matrices=len(A) < A.shape[1])
        Z = Z @ V[int(np.sum(s > RANK * whole)) :].T
        if not Z.shape[1]:
            break
    return step * _share_inside(bounds.G @ step, slack)


def _share_inside(gone: FloatArray, slack: FloatArray) -> float:
    """How much of a step stays inside, to rounding: a bound that is met already is no reason."""
    over = gone > slack + _ROUNDING
    return float(np.min((slack[over] + _ROUNDING) / gone[over], initial=1.0))


def _within(A: FloatArray, b: FloatArray, xi: float, G: FloatArray, h: FloatArray) -> FloatArray:
    """Minimise |A y - b|^2 + xi^2 |y|^2 subject to G y <= h, bounds joining as they are met."""
    q = A.shape[1]
    Q, R = np.linalg.qr(np.concatenate([A, xi * np.eye(q)]))
    wanted = Q.T @ np.concatenate([b, np.zeros(q)])
    y = np.linalg.solve(R, wanted)
    met = np.zeros(len(h), dtype=np.bool_)
    while True:
        beyond = (G @ y > h + 0.1 * _ROUNDING) & ~met
        if not beyond.any():
            return np.asarray(y)
        met |= beyond
        through = np.linalg.solve(R.T, G[met].T).T
        y = np.linalg.solve(R, wanted + _least_distance(-through, through @ wanted - h[met]))


def _least_distance(G: FloatArray, h: FloatArray) -> FloatArray:
    """Minimise |u| subject to G u >= h."""
    q = G.shape[1]
    goal = np.zeros(q + 1)
    goal[q] = 1.0
    E = np.concatenate([G.T, h[None]])
    weights, _ = nnls(E, goal)
    left = E @ weights - goal
    return np.asarray(-left[:q] / left[q])
