"""Points of a motion by a text: a landmark, or the middle of several, such as ``LEL+LEM``."""

from __future__ import annotations

import numpy as np

from armsyn.errors import InputError
from armsyn.motion.motion import FloatArray, Motion

HAND = "hand"


def position_of(motion: Motion, point: str) -> FloatArray:
    """Return the positions of a point.

    Parameters
    ----------
    motion : Motion
    point : str
        Name of a landmark, or names with + between: their mean (epicondyles to an elbow).

    Returns
    -------
    array, shape (frames, 3)
        m; NaN where one of them was not seen.

    Raises
    ------
    InputError
        When there is no such landmark.
    """
    there = motion.landmark_names
    names = (point,) if point in there else tuple(name.strip() for name in point.split("+"))
    for name in names:
        if name not in there or motion.landmarks is None:
            known = ", ".join(there[:40]) or "none, only joint angles"
            more = ", ..." if len(there) > 40 else ""
            source = motion.source or "motion"
            raise InputError(f"{source}: no landmark '{name}'; there are {known}{more}")
    assert motion.landmarks is not None  # noqa: S101 - it has names
    return np.asarray(motion.landmarks[:, [there.index(name) for name in names]].mean(axis=1))


def hand_of(motion: Motion, *, hand_last: bool) -> str:
    """Return the name of the landmark that is the hand.

    Parameters
    ----------
    motion : Motion
    hand_last : bool
        That the last landmark is known to be the end effector; markers and the joints of a
        skeleton stand in any order.

    Returns
    -------
    str
        ``hand``, where there is such a landmark, else the last.

    Raises
    ------
    InputError
        When neither is known, or there are no landmarks.
    """
    source = motion.source or "motion"
    if not motion.landmark_names:
        raise InputError(
            f"{source}: only joint angles: name the arm that they are of, for its hand's positions"
        )
    if HAND in motion.landmark_names:
        return HAND
    if not hand_last:
        names = ", ".join(motion.landmark_names[:60])
        raise InputError(f"{source}: say which of its landmarks is the hand; there are {names}")
    return motion.landmark_names[-1]
