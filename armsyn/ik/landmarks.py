"""A posture whose landmarks lie where captured ones do."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.kinematics import SerialChain

FloatArray = NDArray[np.float64]

_POSTURE_WEIGHT_M = 0.003
"""Metres of misfit that one radian away from `near` weighs: it settles only what the landmarks
leave open (the roll of a hand that is one point)."""


class PostureFit(NamedTuple):
    """A fitted posture.

    Attributes
    ----------
    posture : array, shape (n,)
        Within the limits, rad or m.
    residual : float
        Mean distance of the landmarks, m.
    """

    posture: FloatArray
    residual: float


def fit_posture(
    chain: SerialChain, rows: tuple[int, ...], landmarks: ArrayLike, near: ArrayLike
) -> PostureFit:
    """Fit a posture to landmark positions by bounded least squares.

    Parameters
    ----------
    chain : SerialChain
    rows : tuple of int
        For each landmark its row in ``chain.positions``.
    landmarks : array_like, shape (landmarks, 3)
        Wanted positions, base frame, m.
    near : array_like, shape (n,)
        Posture to start from, and to stay near where the landmarks leave a choice.

    Returns
    -------
    PostureFit

    Raises
    ------
    InputError
        Wrong shapes, not finite, no landmarks, or rows that the chain does not have.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415  heavy, only learning needs it

    wanted = np.asarray(landmarks, dtype=np.float64)
    if wanted.shape != (len(rows), 3) or not np.isfinite(wanted).all():
        raise InputError(f"{len(rows)} landmarks need shape ({len(rows)}, 3), finite")
    if not rows or not all(0 <= row <= chain.dof for row in rows):
        raise InputError(f"landmarks need rows 0 to {chain.dof} of this chain, got {rows}")
    start = np.clip(chain.checked_posture(near), chain.lower + 1e-6, chain.upper - 1e-6)

    def misfit(q: FloatArray) -> FloatArray:
        gaps = chain.positions(q[None])[0, list(rows)] - wanted
        return np.concatenate([gaps.ravel(), _POSTURE_WEIGHT_M * (q - start)])

    found = least_squares(misfit, start, bounds=(chain.lower, chain.upper)).x
    gaps = chain.positions(found[None])[0, list(rows)] - wanted
    return PostureFit(found, float(np.linalg.norm(gaps, axis=1).mean()))
