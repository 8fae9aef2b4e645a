"""Joint angles of a whole motion fitted to its landmarks at once.

Fitted frame by frame, an arm that passes near a singularity (an upper arm near the axis of the
shoulder's first joint) swings two joints against each other in a few frames. The whole motion's
landmarks allow as well that these joints turn early and slowly, as no capture says when.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.ik import fit_posture
from armsyn.kinematics import SerialChain
from armsyn.motion.resample import interpolate

FloatArray = NDArray[np.float64]

SMOOTHNESS_M = 2.0
"""Metres of misfit that one radian of second difference over phases weighs: a reach of a radian
has 6e-4 there (1.2 mm), a swing of half a radian in five phases a hundred times as much."""
_LIMIT_M = 3.0
"""The same of one radian beyond a limit."""
REST_M = 0.003
"""The same of one radian away from rest: it settles only what the landmarks leave open, for all
captures alike."""
_STEPS = 30
_STEP_RAD = 0.3
_SETTLED_RAD = 1e-4
_DIFFERENCE = 1e-6


_EVERY = 10


def continuous_postures(
    chain: SerialChain, rows: tuple[int, ...], landmarks: FloatArray, rest: FloatArray
) -> FloatArray:
    """Fit a motion in which no joint swings from one frame to the next.

    Parameters
    ----------
    chain : SerialChain
    rows : tuple of int
        For each landmark its row in ``chain.positions``.
    landmarks : array, shape (P, landmarks, 3)
        Wanted positions, evenly spaced in time, base frame, m.
    rest : array, shape (n,)
        What the first posture is near, where the landmarks leave a choice.

    Returns
    -------
    array, shape (P, n)
        Within the limits, rad or m.
    """
    frames = len(landmarks)
    some = np.array([*range(0, frames - 1, _EVERY), frames - 1], dtype=np.float64)
    fitted = np.empty((some.size, chain.dof))
    posture = np.asarray(rest)
    for place, frame in enumerate(some):
        posture = fit_posture(chain, rows, landmarks[int(frame)], posture).posture
        fitted[place] = posture
    begun = interpolate(some, fitted, np.arange(float(frames)))
    return smoothly_fitted(chain, rows, landmarks, begun, rest)


def smoothly_fitted(
    chain: SerialChain,
    rows: tuple[int, ...],
    landmarks: FloatArray,
    first: FloatArray,
    rest: FloatArray,
) -> FloatArray:
    """Fit all postures of a motion by Gauss-Newton steps on one banded system.

    Parameters
    ----------
    chain : SerialChain
    rows : tuple of int
        For each landmark its row in ``chain.positions``.
    landmarks : array, shape (P, landmarks, 3)
        Wanted positions, base frame, m.
    first : array, shape (P, n)
        Postures to start from, rad or m.
    rest : array, shape (n,)

    Returns
    -------
    array, shape (P, n)
        Within the limits.
    """
    from scipy.linalg import solveh_banded  # noqa: PLC0415  heavy, only learning needs it

    q = np.array(first)
    for _ in range(_STEPS):
        A, b = _normal_equations(chain, rows, landmarks, q, rest)
        dq = solveh_banded(A, b, lower=True).reshape(q.shape)
        largest = float(np.abs(dq).max())
        q += dq * min(1.0, _STEP_RAD / max(largest, 1e-12))
        if largest < _SETTLED_RAD:
            break
    return np.clip(q, chain.lower, chain.upper)


def _normal_equations(
    chain: SerialChain,
    rows: tuple[int, ...],
    landmarks: FloatArray,
    q: FloatArray,
    rest: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the lower bands, shape (2 n + 1, P n), and the right-hand side, shape (P n,)."""
    frames, n = q.shape
    J, gap = _linearised(chain, rows, landmarks, q)
    blocks = np.einsum("fki,fkj->fij", J, J)
    b = np.einsum("fki,fk->fi", J, gap)
    over = np.maximum(q - chain.upper, 0.0) - np.maximum(chain.lower - q, 0.0)
    diagonal = np.arange(n)
    blocks[:, diagonal, diagonal] += np.where(over != 0.0, _LIMIT_M**2, 0.0) + REST_M**2
    b -= _LIMIT_M**2 * over + REST_M**2 * (q - rest)
    bend = np.diff(np.eye(frames), n=2, axis=0) * SMOOTHNESS_M
    S = bend.T @ bend
    b -= S @ q
    A = np.zeros((2 * n + 1, frames * n))
    for i in range(n):
        for j in range(i + 1):
            A[i - j, j::n] += blocks[:, i, j]
    for apart in range(3):
        band = np.repeat(np.diagonal(S, -apart), n)
        A[apart * n, : band.size] += band
    return A, b.ravel()


def _linearised(
    chain: SerialChain, rows: tuple[int, ...], landmarks: FloatArray, q: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return derivatives, (P, 3 landmarks, n), and what is wanted beyond, (P, 3 landmarks)."""
    frames, n = q.shape
    steps = np.concatenate([np.zeros((1, n)), _DIFFERENCE * np.eye(n)])
    places = chain.positions((q + steps[:, None]).reshape(-1, n))[:, list(rows)]
    places = places.reshape(n + 1, frames, -1)
    J = (places[1:] - places[0]) / _DIFFERENCE
    return np.moveaxis(J, 0, 2), landmarks.reshape(frames, -1) - places[0]
