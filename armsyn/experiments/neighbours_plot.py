"""Picture of the experiment `neighbours`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armsyn.experiments.pictures import figure, save
from armsyn.experiments.serving import Served


def draw(people: Sequence[Sequence[Served]], folder: Path) -> str:
    """Draw distance against how far the target is, and which of the fewest sets serves which.

    Parameters
    ----------
    people : sequence of sequence of Served
        Each person with several bounds.
    folder : Path

    Returns
    -------
    str
        The file's name.

    Raises
    ------
    InputError
        When it cannot be written.
    """
    lines = len(people[0]) + 1
    drawn = figure(4.0 * len(people), 3.4 * lines)
    every = drawn.subplots(lines, len(people), squeeze=False)
    for person, column in zip(people, every.T, strict=True):
        for served, axes in zip(person, column, strict=False):
            _draw_distances(axes, served)
        _draw_map(column[-1], person[-1])
    every[0, 0].legend()
    every[-1, 0].legend()
    return save(drawn, folder, "neighbours.png")


def _draw_distances(axes: Any, served: Served) -> None:
    known = np.isfinite(served.means)
    held = np.minimum(served.means[known] * 100, 30)  # a set that flies off is drawn at the rim
    axes.plot(
        served.apart[known] * 100, held, ".", color="C0", alpha=0.4, label="a set at a target"
    )
    if served.floors is not None:
        floor = float(served.floors.mean()) * 100
        axes.axhline(floor, color="black", label="human floor")
    usual = served.usual_tolerance * (100 if served.floors is None else floor)
    axes.axhline(usual, color="black", linestyle=":", label="serves up to")
    axes.set_title(f"{served.title}, {served.bounds} bounds", fontsize=10)
    axes.set_xlabel("from the set's target to this one, cm")
    axes.set_ylabel("held distance, cm (30: or more)")
    axes.set_ylim(0, 31)


def _draw_map(axes: Any, served: Served) -> None:
    """Targets as the person sees them, in the colours of the chosen set that serves them best."""
    chosen = served.fewest(served.usual_tolerance)
    serves = served.serves(served.usual_tolerance)
    y, z = served.positions[:, 1] * 100, served.positions[:, 2] * 100
    axes.plot(y, z, "o", color="0.6", fillstyle="none", markersize=9, label="not served")
    for column in range(len(served.targets)):
        able = [row for row in chosen if serves[row, column]]
        if able:
            best = min(able, key=lambda row: served.judged[row, column])
            colour, ends = f"C{chosen.index(best)}", [served.own[best], column]
            axes.plot(y[ends], z[ends], "-", color=colour, linewidth=1)
            axes.plot(y[column], z[column], "o", color=colour, markersize=9)
    own = [served.own[row] for row in chosen]
    axes.plot(
        y[own],
        z[own],
        "*",
        color="white",
        markersize=6,
        markeredgecolor="black",
        label="learned at",
    )
    axes.invert_xaxis()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(
        f"{len(chosen)} sets serve {int(serves.any(axis=0).sum())} of {len(y)} targets", fontsize=10
    )
    axes.set_xlabel("to the left, cm")
    axes.set_ylabel("up, cm")
