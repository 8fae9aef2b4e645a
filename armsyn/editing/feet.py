"""How far feet slide where they stood."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
_FOOT = re.compile(r"toe|ball|foot|ankle|heel", re.IGNORECASE)
LOW_M = 0.05
"""A foot's joint stands no higher than this above its own lowest place."""
STILL_M_S = 0.2
"""Nor is it faster than this, m/s."""


def foot_slide(
    bodies: tuple[str, ...], time: FloatArray, before: FloatArray, after: FloatArray
) -> dict[str, tuple[float, float]]:
    """Greatest horizontal departure of feet from where each stance of the original began.

    Parameters
    ----------
    bodies : tuple of str
        Feet are the joints named toe, ball, foot, ankle or heel.
    time : array, shape (frames,)
        s.
    before, after : array, shape (frames, bodies, 3)
        z up, m.

    Returns
    -------
    dict of str to (float, float)
        Of each foot that ever stands in the original: slide before and after, m.
    """
    found = {}
    for place, name in enumerate(bodies):
        if not _FOOT.search(name):
            continue
        stances = _stances(time, before[:, place])
        if stances:
            found[name] = (_slide(before[:, place], stances), _slide(after[:, place], stances))
    return found


def _stances(time: FloatArray, path: FloatArray) -> list[slice]:
    """Return the stretches of at least two frames in which a joint stands."""
    speed = np.linalg.norm(np.gradient(path, time, axis=0), axis=-1)
    stands = (path[:, 2] < path[:, 2].min() + LOW_M) & (speed < STILL_M_S)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], stands, [False]]).astype(int)))
    return [slice(a, b) for a, b in edges.reshape(-1, 2) if b - a > 1]


def _slide(path: FloatArray, stances: list[slice]) -> float:
    return max(
        float(np.linalg.norm(path[s, :2] - path[s.start, :2], axis=-1).max()) for s in stances
    )
