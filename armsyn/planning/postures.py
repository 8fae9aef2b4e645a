"""Inverse kinematics of many reaches at once: the posture next to a given one that is there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.ik import optimiser_settings
from armsyn.kinematics import SerialChain
from armsyn.planning.leading import Descent, descend_each, jacobian_each

FloatArray = NDArray[np.float64]

TOLERANCE_M = 1e-5
MOST_STEPS = 100
_LONGEST_STEP = 0.1
"""Of the chain's reach, as in `armsyn.ik.solve_ik`."""
_SETTINGS = optimiser_settings("svd")


def postures_at(
    chain: SerialChain, near: FloatArray, targets: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Lead postures to where their hands are at the targets: `armsyn.ik.solve_ik` for many.

    Parameters
    ----------
    chain : SerialChain
    near : array, shape (M, n)
        Postures to start from, rad or m.
    targets : array, shape (M, 3)
        Base frame, m.

    Returns
    -------
    postures : array, shape (M, n)
        Within the limits; the best ones met where a target is out of reach.
    errors : array, shape (M,)
        Distance of the hand to the target, m.
    """
    q, errors = np.clip(near, chain.lower, chain.upper), np.empty(len(near))
    descend_each(chain.arrays, np.ascontiguousarray(targets), descent_of(chain), q, errors)
    return q, errors


def descent_of(chain: SerialChain) -> Descent:
    """Return how a chain's postures are led to targets."""
    return Descent(_SETTINGS, _LONGEST_STEP * chain.reach, TOLERANCE_M, MOST_STEPS)


def tips(chain: SerialChain, q: FloatArray) -> FloatArray:
    """Return where the tips of postures, shape (M, n), are, shape (M, 3), m."""
    return np.asarray(chain.positions(q)[:, -1])


def jacobians(chain: SerialChain, q: FloatArray) -> FloatArray:
    """Geometric Jacobians of the tip.

    Parameters
    ----------
    chain : SerialChain
    q : array, shape (M, n)
        Postures, rad or m.

    Returns
    -------
    array, shape (M, 3, n)
        Base frame, m/rad (m/m for prismatic joints).
    """
    J = np.empty((len(q), 3, chain.dof))
    jacobian_each(chain.arrays, np.ascontiguousarray(q), J)
    return J
