"""The plot of `armsyn learn`: how fast learning converged."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from armsyn.errors import FormatError, InputError
from armsyn.motion.formats.files import replacing

if TYPE_CHECKING:
    from armsyn.synergy.fitting import Fitted
    from armsyn.synergy.learning import Key


class Convergence:
    """Collects what learners found; draws the best distance over the roll-outs made."""

    def __init__(self) -> None:
        self._fitted: dict[tuple[str, str], list[Fitted]] = defaultdict(list)

    def add(self, key: Key, fitted: Fitted) -> None:
        """Take what was found for a reach, an optimiser and a model."""
        _, ik, model = key
        self._fitted[model, ik].append(fitted)

    def check(self, path: Path) -> None:
        """Raise InputError when nothing was learned."""
        if not self._fitted:
            raise InputError(f"{path}: nothing was left to learn, so there is nothing to plot")

    def plot(self, path: Path) -> None:
        """Draw a thin line a reach and a thick one for the mean of each optimiser and model.

        Raises
        ------
        InputError
            When nothing was learned, or the file cannot be written.
        """
        from matplotlib.figure import Figure

        self.check(path)
        figure = Figure(figsize=(7, 4.5), layout="constrained")
        axes = figure.subplots()
        for number, ((model, ik), found) in enumerate(sorted(self._fitted.items())):
            colour = f"C{number}"
            for fitted in found:
                reached = _over(fitted.evaluations)
                best = [100 * fitted.best_after(made) for made in reached]
                axes.step(reached, best, where="post", color=colour, alpha=0.25, linewidth=0.7)
            reached = _over(max(fitted.evaluations for fitted in found))
            mean = [100 * np.mean([f.best_after(made) for f in found]) for made in reached]
            axes.step(
                reached,
                mean,
                where="post",
                color=colour,
                linewidth=2,
                label=f"S_{model} {ik}, mean",
            )
        axes.set(xscale="log", yscale="log")
        axes.set(xlabel="roll-outs of a reach", ylabel="best distance (training error), cm")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.grid(visible=True, which="both", alpha=0.2)
        axes.legend()
        with replacing(path) as temporary:
            figure.savefig(temporary, format="png", dpi=150)


def _over(most: int) -> list[int]:
    counts: list[int] = np.unique(np.geomspace(1, most, 300).round().astype(int)).tolist()
    return counts


def checked_plot(path: Path) -> Path:
    """Refuse to plot to anything but a PNG file, before minutes of learning.

    Raises
    ------
    FormatError
    """
    if path.suffix.lower() != ".png":
        raise FormatError(f"{path}: a plot is written as .png")
    return path
