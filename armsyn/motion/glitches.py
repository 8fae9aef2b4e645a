"""Glitches: single steps in which a landmark moves as nothing around them does.

A capture that loses a marker or a bone for a frame or two shows it elsewhere and then back. Its
step is out of all proportion to the steps before and after it, which a fast but smooth movement's
never is. Glitches are reported; nothing is taken out.
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np

from armsyn.motion.motion import FloatArray, Motion

TIMES = 5.0
"""A step is a glitch when it is so many times the median of the steps around it ..."""
FLOOR = 1.0
"""... and this much faster still, m/s: noise of a marker at rest is none."""
_EITHER_SIDE = 5  # steps before and after


class Glitch(NamedTuple):
    """A step that stands out.

    Attributes
    ----------
    landmark : str
    frame : int
        The step ends there.
    speed : float
        Over the step, m/s.
    """

    landmark: str
    frame: int
    speed: float


def find_glitches(motion: Motion) -> list[Glitch]:
    """Return the steps of landmarks that stand out from those around them.

    Parameters
    ----------
    motion : Motion
        Gaps hide what is beside them.

    Returns
    -------
    list of Glitch
        By frame; empty when there are none, no landmarks, or fewer than two steps.
    """
    if motion.landmarks is None or motion.frames < 3:
        return []
    steps = np.linalg.norm(np.diff(motion.landmarks, axis=0), axis=2)
    speed = steps / np.diff(motion.time)[:, None]
    found = np.argwhere(speed > TIMES * _usual(speed) + FLOOR).tolist()
    return [
        Glitch(motion.landmark_names[column], row + 1, float(speed[row, column]))
        for row, column in found
    ]


def _usual(speed: FloatArray) -> FloatArray:
    """Median of the speeds around each, itself included, shape as `speed`."""
    edge = np.full((_EITHER_SIDE, speed.shape[1]), np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(
        np.concatenate([edge, speed, edge]), 2 * _EITHER_SIDE + 1, axis=0
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # all of them may be gaps
        return np.asarray(np.nanmedian(windows, axis=-1))
