"""The plot of `armsyn motion segment`: the hand's speed, with the movements found in it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from armsyn.errors import InputError
from armsyn.motion.filtering import hand_speed
from armsyn.motion.movements import FEWEST_FRAMES
from armsyn.motion.segmentation import moving_runs

if TYPE_CHECKING:
    from armsyn.motion import FloatArray
    from armsyn.motion.movements import Movement


def plot_movements(
    path: Path,
    title: str,
    time: FloatArray,
    positions: FloatArray,
    movements: list[tuple[Movement, str]],
    options: dict[str, Any],
) -> None:
    """Plot a hand's filtered speed, each movement shaded from onset to offset.

    Parameters
    ----------
    path : Path
        Its suffix says the picture's format.
    title : str
    time : array, shape (frames,)
        s.
    positions : array, shape (frames, 3)
        Of the hand, m; NaN is a gap.
    movements : list of (Movement, str)
        Each with why it is no usable reach, or an empty text.
    options : dict
        With `cutoff` (Hz or None).

    Raises
    ------
    InputError
        When the picture cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for first, last in moving_runs(np.asarray(np.isfinite(positions).all(axis=1))):
        if last - first + 1 >= FEWEST_FRAMES:
            seen = slice(first, last + 1)
            profile = hand_speed(time[seen], positions[seen], cutoff=options["cutoff"], rest=0.0)
            axes.plot(profile.time, profile.speed, color="black", linewidth=1)
    for number, (movement, fault) in enumerate(movements, 1):
        colour = "tab:red" if fault else "tab:green"
        axes.axvspan(movement.onset, movement.offset, color=colour, alpha=0.2, linewidth=0)
        axes.plot(movement.peak_time, movement.peak_speed, "v", color=colour, markersize=5)
        text = str(number) + (f": {fault}" if fault else "")
        axes.annotate(
            *(text, (movement.peak_time, movement.peak_speed)),
            xytext=(0, 5),
            textcoords="offset points",
            ha="center",
            fontsize="x-small",
        )
    axes.set(xlabel="time, s", ylabel="speed of the hand, m/s", title=title)
    axes.set_ylim(bottom=0)
    axes.margins(x=0, y=0.12)
    try:
        figure.savefig(path, dpi=120)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot write the plot: {error}") from error
