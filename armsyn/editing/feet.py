"""How far feet slide and lift where they stood."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
_FOOT = re.compile(r"toe|ball|foot|ankle|heel", re.IGNORECASE)
LOW_M = 0.05
"""A foot's joint stands no higher than this above its own lowest place."""
STILL_M_S = 0.2
"""Nor is it faster than this, m/s."""


class FootMotion(NamedTuple):
    """What a foot does while it stands in the original clip, m.

    Attributes
    ----------
    slide_before, slide_after : float
        Greatest horizontal departure from where a stance began.
    lift : float
        Greatest height gained or lost by the edit.
    """

    slide_before: float
    slide_after: float
    lift: float


def standing_feet(
    bodies: tuple[str, ...], time: FloatArray, before: FloatArray, after: FloatArray
) -> dict[str, FootMotion]:
    """Follow the feet of an edited clip through the stances of the original.

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
    dict of str to FootMotion
        Of each foot that ever stands in the original.
    """
    found = {}
    for place, name in enumerate(bodies):
        stances = _stances(time, before[:, place]) if _FOOT.search(name) else []
        if stances:
            lifted = np.abs(after[:, place, 2] - before[:, place, 2])
            found[name] = FootMotion(
                _slide(before[:, place], stances),
                _slide(after[:, place], stances),
                max(float(lifted[stance].max()) for stance in stances),
            )
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
