"""Tables and the picture of edits by several methods."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from armsyn.editing import EditResult, MotionModel
from armsyn.editing.pictures import View, draw_view
from armsyn.experiments.edits import JOINT_PATH, KEY_FRAME, Likeness, Method
from armsyn.experiments.pictures import figure, save
from armsyn.experiments.tables import Column, Table, Value, centimetres

_METHOD = Column("method", "method")
_COST = (
    _METHOD,
    Column("error_m", "misses, mm", ".4f", 1e3),
    Column("iterations", "steps", ".0f"),
    Column("seconds", "time, ms", ".2f", 1e3),
    Column("time_ratio", "ratio", ".1f"),
    Column("nearest_example", "nearest example"),
)
_LOOKS = (
    _METHOD,
    centimetres("foot_slide", "slide"),
    centimetres("start_drift", "drift"),
    centimetres("outside", "outside"),
    Column("largest_coefficient", "sigma", ".2f"),
    Column("distance_to_nearest", "away", ".2f"),
)
_MEANS = (
    _METHOD,
    Column("clips", "clips", ".0f"),
    Column("error_m", "misses, mm", ".4f", 1e3),
    Column("time_ratio", "ratio", ".1f"),
    centimetres("foot_slide", "slide"),
    centimetres("outside", "outside"),
    Column("largest_coefficient", "sigma", ".2f"),
    Column("distance_to_nearest", "away", ".2f"),
)
_PATTERNS = (
    Column("examples", "examples", ".0f"),
    Column("components", "components", ".0f"),
    Column("variance", "variance", ".4f"),
    centimetres("left_out", "left out"),
)
_LOOKS_NOTE = (
    "slide: the farthest that a standing foot's joint goes; drift: of the constrained bodies at"
    " the first frame; outside: mean distance of all bodies from what the pattern can say of the"
    " edited clip; sigma: its largest whitened coefficient; away: sigma from the nearest example."
)


def pattern_table(models: Sequence[MotionModel], note: str) -> Table:
    """Say what was learned; "left out" is the mean error of examples rebuilt from the others."""
    rows: list[tuple[Value, ...]] = [
        (len(model.names), model.size, model.variance, float(model.left_out_m.mean()))
        for model in models
    ]
    return Table("Patterns", _PATTERNS, rows, [note])


def method_tables(title: str, methods: Sequence[Method], repeats: int) -> list[Table]:
    """Set the methods of one edit side by side.

    Parameters
    ----------
    title : str
    methods : sequence of Method
    repeats : int
        Runs whose median the times are.

    Returns
    -------
    list of Table
        What it cost, and what it looks like beside the clip before.
    """
    ratios = time_ratios(methods)
    cost: list[tuple[Value, ...]] = [
        (
            *(m.name, _error(m.result), m.result.iterations, m.seconds, ratios[m.name]),
            m.after.nearest[0].partition(":")[2],
        )
        for m in methods
    ]
    first = methods[0]
    looks = [_looks("before the edit", slide_of(first.result, 0), 0.0, first.before)]
    looks += [
        _looks(m.name, slide_of(m.result, 1), m.result.start_drift_m, m.after) for m in methods
    ]
    return [
        Table(f"{title}: cost", _COST, cost, [_times(repeats)]),
        Table(f"{title}: looks", _LOOKS, looks, [_LOOKS_NOTE]),
    ]


def _looks(name: str, slide: float | None, drift: float, like: Likeness) -> tuple[Value, ...]:
    return name, slide, drift, like.outside_m, like.largest, like.nearest[1]


def _times(repeats: int) -> str:
    return (
        f"Times are of this machine and run, the median of {repeats}; all methods run on the same"
        " compiled kinematics to the same tolerance. ratio (time_ratio): the joint space's time"
        " over the method's; the paper's for golf is 102 s over 3 s, or 34."
    )


def mean_table(
    title: str, everywhere: Sequence[Sequence[Method]], notes: Sequence[str] = ()
) -> Table:
    """Sum up the edits of many clips.

    Parameters
    ----------
    title : str
    everywhere : sequence of sequence of Method
        Of each clip, in the same order of methods.
    notes : sequence of str
        More to say below it.

    Returns
    -------
    Table
        Worst errors and coefficients, median ratios, means of the rest.
    """
    first = [methods[0] for methods in everywhere]
    likes = [m.before for m in first]
    rows: list[tuple[Value, ...]] = [
        ("before the edit", len(first), None, None, _mean_slide(first, 0), *_means(likes))
    ]
    for place, method in enumerate(everywhere[0]):
        same = [methods[place] for methods in everywhere]
        ratios = [time_ratios(methods)[method.name] for methods in everywhere]
        error, ratio = max(_error(m.result) for m in same), float(np.median(ratios))
        likes = [m.after for m in same]
        rows.append((method.name, len(same), error, ratio, _mean_slide(same, 1), *_means(likes)))
    notes = ["misses and sigma: the worst; ratio: the median; the rest: means.", *notes]
    return Table(title, _MEANS, rows, notes)


def _means(likes: Sequence[Likeness]) -> tuple[float, float, float]:
    return (
        float(np.mean([like.outside_m for like in likes])),
        max(like.largest for like in likes),
        float(np.mean([like.nearest[1] for like in likes])),
    )


def _mean_slide(methods: Sequence[Method], which: int) -> float | None:
    slides = [slide for m in methods if (slide := slide_of(m.result, which)) is not None]
    return float(np.mean(slides)) if slides else None


def slide_verdict(everywhere: Sequence[Sequence[Method]]) -> str:
    """Say whether feet slide less by a key-frame in the pattern than in the joint space."""
    less, count = 0, 0
    for methods in everywhere:
        by_name = {m.name: slide_of(m.result, 1) for m in methods}
        latent, joint = by_name[KEY_FRAME], by_name[JOINT_PATH]
        if latent is not None and joint is not None:
            less, count = less + (latent < joint), count + 1
    return (
        f"Feet slide less by LPIK with a key-frame than by PIK in {less} of {count}; the paper"
        " shows one case of each and reports less by LPIK."
    )


def time_ratios(methods: Sequence[Method]) -> dict[str, float]:
    """Return the joint space's time over each method's."""
    joint = next(method.seconds for method in methods if method.name == JOINT_PATH)
    return {method.name: joint / method.seconds for method in methods}


def slide_of(result: EditResult, which: int) -> float | None:
    """Return the largest slide of any foot before (0) or after (1), m; None where none stands."""
    slides = result.foot_slide_m
    return None if not slides else max(pair[which] for pair in slides.values())


def _error(result: EditResult) -> float:
    return max(result.level_errors.values())


def draw(
    methods: Sequence[Method], view: View, folder: Path, name: str, height: float = 6.0
) -> str:
    """Superpose before and after for each method; height in inches; returns the picture's name."""
    drawn = figure(4.0 * len(methods), height)
    for axes, method in zip(drawn.subplots(1, len(methods), sharey=True), methods, strict=True):
        draw_view(axes, method.result, view)
        axes.set_title(method.name)
    drawn.suptitle(f"{methods[0].result.original.source}: grey before, red after")
    return save(drawn, folder, name)
