"""A picture of bands: the speed's shape, and every measure's spread about its median."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from armsyn.motion.formats.files import replacing
from armsyn.scoring.bands import Bands
from armsyn.scoring.human_likeness import MEASURES
from armsyn.scoring.profile import minimum_jerk_speed


def draw_bands(path: Path, bands: Bands) -> None:
    """Draw bands.

    Parameters
    ----------
    path : Path
        PNG to write.
    bands : Bands

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 5), layout="constrained")
    figure.suptitle(f"{bands.captures}: {bands.reaches} reaches, median and 5-95 %")
    speed, table = figure.subplots(1, 2, width_ratios=(1, 1))
    _draw_speed(speed, bands)
    _draw_measures(table, bands)
    with replacing(path) as temporary:
        figure.savefig(temporary, format="png", dpi=120)


def _draw_speed(axes: Any, bands: Bands) -> None:
    phase = np.linspace(0.0, 1.0, 101)
    low, median, high = bands.speed
    axes.fill_between(phase, low, high, color="0.85", label="5-95 %")
    axes.plot(phase, median, color="tab:blue", label="median")
    axes.plot(phase, minimum_jerk_speed(phase), "k:", label="minimum jerk")
    axes.set(xlabel="time, of movement time", ylabel="hand speed / mean speed", xlim=(0, 1))
    axes.set_ylim(bottom=0)
    axes.legend()
    axes.grid(visible=True, alpha=0.3)


def _draw_measures(axes: Any, bands: Bands) -> None:
    """Draw each band in units of its own half width, so that they share an axis."""
    keys = [key for key in MEASURES if key in bands.measures]
    for row, key in enumerate(reversed(keys)):
        band = bands.measures[key]
        half = (band.high - band.low) / 2 or 1.0
        ends = [(value - band.median) / half for value in (band.low, band.high)]
        axes.plot(ends, [row, row], color="0.7", linewidth=7, solid_capstyle="butt")
        axes.plot([0], [row], "|", color="tab:blue", markersize=12)
        for end, value, side in zip(ends, (band.low, band.high), ("right", "left"), strict=True):
            shift = (-5 if side == "right" else 5, 0)
            axes.annotate(
                f"{value:.3g}",
                (end, row),
                xytext=shift,
                textcoords="offset points",
                ha=side,
                va="center",
                fontsize=8,
            )
    axes.set_yticks(range(len(keys)))
    axes.set_yticklabels(
        [f"{MEASURES[key]}: {bands.measures[key].median:.3g}" for key in reversed(keys)],
        fontsize=8,
    )
    axes.set(xticks=[], xlim=(-2.6, 2.6), title="each scaled to its own width")
