"""Clips of bodies at other instants: so many frames, or evenly spaced ones."""

from __future__ import annotations

import numpy as np

from armsyn.editing.figure import SkeletonFigure
from armsyn.editing.pattern.timing import normalised_poses
from armsyn.motion.body import BodyMotion

_EVEN = 1e-3
"""Of a step: what steps may differ by and still be even."""


def at_frames(clip: BodyMotion, figure: SkeletonFigure, frames: int) -> BodyMotion:
    """Return a clip normalised in time to so many frames, as the pattern has it.

    Parameters
    ----------
    clip : BodyMotion
    figure : SkeletonFigure
        Whose skeleton and translations it gets.
    frames : int
        At least 2.

    Returns
    -------
    BodyMotion
        From time 0.
    """
    poses = normalised_poses(clip.time, figure.poses(clip), figure.turns, frames)
    count, moved = figure.skeleton.joints, None
    if figure.moving:
        moved = np.zeros((frames, count, 3))
        moved[:, figure.moving] = poses[:, 3 + 3 * count :].reshape(frames, -1, 3)
    return BodyMotion(
        np.linspace(0.0, clip.time[-1] - clip.time[0], frames),
        figure.skeleton,
        poses[:, 3 : 3 + 3 * count].reshape(frames, count, 3),
        poses[:, :3],
        moved,
        clip.source,
    )


def evenly_sampled(clip: BodyMotion, figure: SkeletonFigure) -> BodyMotion:
    """Return a clip at its own most usual step of time throughout; itself where it is so already.

    Parameters
    ----------
    clip : BodyMotion
    figure : SkeletonFigure

    Returns
    -------
    BodyMotion
    """
    steps = np.diff(clip.time)
    step = float(np.median(steps))
    if np.abs(steps - step).max() <= _EVEN * step:
        return clip
    return at_frames(clip, figure, round(float(clip.time[-1] - clip.time[0]) / step) + 1)
