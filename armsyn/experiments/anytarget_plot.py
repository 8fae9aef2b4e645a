"""Picture of the experiment `anytarget`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armsyn.experiments.anytarget_rows import Row
from armsyn.experiments.anytarget_run import TITLES, Outcome
from armsyn.experiments.anytarget_verdict import best_of, differences, over_floor
from armsyn.experiments.pictures import figure, save

_COLOURS = {
    "reference": "0.35",
    "baseline": "0.65",
    "synergy": "C0",
    "latent": "C2",
    "joined": "C1",
    "bound": "white",
}


def draw(groups: Sequence[Mapping[str, Outcome]], seed: int, folder: Path) -> str:
    """Draw held distances, and by how much the best row is ahead.

    Parameters
    ----------
    groups : sequence of mapping of str to Outcome
        One a protocol and group of people.
    seed : int
        Of the bootstrap.
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
    longest = max(len(outcomes) for outcomes in groups)
    drawn = figure(13.0, (1.2 + 0.27 * longest) * len(groups))
    every = drawn.subplots(len(groups), 2, squeeze=False, width_ratios=[3, 2])
    for outcomes, (left, right) in zip(groups, every, strict=True):
        _draw_distances(left, outcomes)
        _draw_differences(right, outcomes, seed)
    return save(drawn, folder, "anytarget.png")


def _draw_distances(axes: Any, outcomes: Mapping[str, Outcome]) -> None:
    """Bars, best on top; dots are persons."""
    floors = outcomes["floor"].by_subject("held") if "floor" in outcomes else None
    first = next(iter(outcomes.values()))
    ordered = sorted(outcomes.values(), key=lambda one: _height(one, outcomes), reverse=True)
    for place, outcome in enumerate(ordered):
        colour = _COLOURS[outcome.row.kind]
        hatch = "//" if outcome.row.tuned else None
        length = _height(outcome, outcomes)
        axes.barh(place, length, color=colour, edgecolor="black", height=0.7, hatch=hatch)
        for subject, held in outcome.by_subject("held").items():
            shown = held * 100 if floors is None else held / floors[subject]
            axes.plot(shown, place, ".", color="black", markersize=4)
    axes.set_yticks(range(len(ordered)), [_label(one.row) for one in ordered], fontsize=8)
    axes.set_xlabel("held distance, cm" if floors is None else "held distance / human floor")
    if floors is not None:
        axes.axvline(1.0, color="black", linestyle=":")
    title = f"{first.people.title}: {TITLES[first.protocol]}"
    if any(one.row.tuned for one in ordered):
        title += "\n* hatched: constants set with reaches of HuG-MP in view"
    axes.set_title(title, fontsize=10)


def _label(row: Row) -> str:
    return f"{row.title} *" if row.tuned else row.title


def _height(outcome: Outcome, outcomes: Mapping[str, Outcome]) -> float:
    floors = over_floor(outcome, outcomes)
    return outcome.mean("held") * 100 if math.isnan(floors) else floors


def _draw_differences(axes: Any, outcomes: Mapping[str, Outcome], seed: int) -> None:
    best = best_of(outcomes)
    found = sorted(differences(outcomes, best, seed).items(), key=lambda pair: -pair[1].mean)
    for place, (key, gap) in enumerate(found):
        mean, low, high = np.array(gap) * 100
        colour = _COLOURS[outcomes[key].row.kind]
        span = [[mean - low], [high - mean]]
        axes.errorbar(mean, place, xerr=span, fmt="o", color="black", mfc=colour, capsize=3)
    axes.axvline(0.0, color="black", linestyle=":")
    axes.set_yticks(range(len(found)), [_label(outcomes[key].row) for key, _ in found], fontsize=8)
    axes.set_xlabel("cm farther from the captured reach (95 %)")
    axes.set_title(f"than: {best.row.title}", fontsize=10)
