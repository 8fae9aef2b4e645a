"""The plot of `armsyn motion info`: landmarks' speeds over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from armsyn.errors import InputError

if TYPE_CHECKING:
    from armsyn.motion import FloatArray, Motion

MOST = 6
"""Landmarks that are shown when none is named: the fastest."""


def plot_speeds(path: Path, motion: Motion, wanted: tuple[str, ...]) -> None:
    """Plot the speeds of landmarks, or of the joints where there are none.

    Speeds are unfiltered differences; a gap breaks its line, and what was filled in is dotted.

    Parameters
    ----------
    path : Path
        Its suffix says the picture's format.
    motion : Motion
    wanted : tuple of str
        Names of landmarks (or joints); the `MOST` fastest when empty.

    Raises
    ------
    InputError
        When there is no such landmark, or the picture cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    names, speeds, unit = _speeds(motion)
    columns = _chosen(names, speeds, wanted, motion.source)
    figure = Figure(figsize=(9, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for column in columns:
        (line,) = axes.plot(motion.time, speeds[:, column], linewidth=1.2, label=names[column])
        if motion.filled is not None and motion.landmarks is not None:
            inside = np.where(motion.filled[:, column], speeds[:, column], np.nan)
            axes.plot(motion.time, inside, ".", color=line.get_color(), markersize=4)
    axes.set(xlabel="time, s", ylabel=f"speed, {unit}", title=motion.source)
    axes.set_ylim(bottom=0)
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small", title="" if wanted else f"the {len(columns)} fastest")
    try:
        figure.savefig(path, dpi=120)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot write the plot: {error}") from error


def _speeds(motion: Motion) -> tuple[tuple[str, ...], FloatArray, str]:
    """Names, speeds of shape (frames, names) and their unit."""
    if motion.landmarks is not None:
        velocity = np.gradient(motion.landmarks, motion.time, axis=0)
        return motion.landmark_names, np.linalg.norm(velocity, axis=2), "m/s"
    assert motion.angles is not None  # noqa: S101 - a motion has one or the other
    return motion.joint_names, np.abs(np.gradient(motion.angles, motion.time, axis=0)), "rad/s"


def _chosen(
    names: tuple[str, ...], speeds: FloatArray, wanted: tuple[str, ...], source: str
) -> list[int]:
    for name in wanted:
        if name not in names:
            raise InputError(f"{source}: no '{name}' to plot; there are {', '.join(names)}")
    if wanted:
        return [names.index(name) for name in wanted]
    fastest = np.nan_to_num(speeds).max(axis=0)
    return sorted(np.argsort(-fastest)[:MOST].tolist())
