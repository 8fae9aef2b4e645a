"""A picture of an edit: before and after superposed, the speed, and the latent coefficients."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from armsyn.editing.figure import Figure, SkeletonFigure
from armsyn.editing.result import EditResult
from armsyn.motion.formats.files import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

BEFORE, AFTER = "0.55", "C3"
View = tuple[int, int, str, str]
SIDE: View = (0, 2, "x", "z")
FRONT: View = (1, 2, "y", "z")


def draw_edit(result: EditResult, coefficient_bound: float) -> Drawing:
    """Draw an edit.

    Parameters
    ----------
    result : EditResult
    coefficient_bound : float
        Standard deviations, shown as lines.

    Returns
    -------
    matplotlib.figure.Figure
        Two views of three postures (start, where the change is greatest, end) with the paths of
        the constrained bodies; the first one's speed; coefficients.
    """
    from matplotlib.figure import Figure as Drawing  # noqa: PLC0415  heavy, only pictures need it

    drawing = Drawing(figsize=(11, 8), layout="constrained")
    axes = drawing.subplots(2, 2)
    for place, view in zip(axes[0], (SIDE, FRONT), strict=True):
        draw_view(place, result, view)
    if result.constrained:
        axes[0][0].legend(fontsize="small", loc="upper left")
    _draw_speed(axes[1][0], result)
    _draw_coefficients(axes[1][1], result, coefficient_bound)
    drawing.suptitle(f"{result.original.source or 'clip'}: grey before, red after")
    return drawing


def save_picture(path: Path, result: EditResult, coefficient_bound: float) -> None:
    """Draw an edit into a PNG file.

    Raises
    ------
    InputError
        When it cannot be written.
    """
    drawing = draw_edit(result, coefficient_bound)
    with replacing(path) as temporary:
        drawing.savefig(temporary, format="png", dpi=110)


def bones(figure: Figure) -> list[tuple[int, int]]:
    """Return pairs of bodies, parent and child, that lines join."""
    if isinstance(figure, SkeletonFigure):
        return [(above, own) for own, above in enumerate(figure.skeleton.parents) if above >= 0]
    return [(place, place + 1) for place in range(len(figure.tree.bodies) - 1)]


def draw_view(axes: Any, result: EditResult, view: View) -> None:
    """Draw start, greatest change and end of both clips, and the constrained bodies' paths.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    result : EditResult
    view : View
        `FRONT` or `SIDE`.
    """
    across, up, x, y = view
    before, after = result.positions
    middle = int(np.linalg.norm(after - before, axis=-1).max(axis=1).argmax())
    frames = sorted({0, middle, len(before) - 1})
    joined = bones(result.figure)
    for positions, colour, label in ((before, BEFORE, "before"), (after, AFTER, "after")):
        for number, frame in enumerate(frames):
            lines = positions[frame][joined]
            alpha = 0.35 + 0.65 * number / max(1, len(frames) - 1)
            for line in lines:
                axes.plot(line[:, across], line[:, up], color=colour, alpha=alpha, linewidth=1.3)
        for number, name in enumerate(result.constrained):
            path = positions[:, result.figure.tree.body(name)]
            whose = name if len(result.constrained) == 1 else "paths"
            shown = None if number else f"{whose}, {label}"
            style = {"color": colour, "linestyle": "--", "linewidth": 1.5, "label": shown}
            axes.plot(path[:, across], path[:, up], **style)
    axes.set(xlabel=f"{x}, m", ylabel=f"{y}, m", title=f"frames {', '.join(map(str, frames))}")
    axes.set_aspect("equal", adjustable="datalim")


def _draw_speed(axes: Any, result: EditResult) -> None:
    tree = result.figure.tree
    name = result.constrained[0] if result.constrained else tree.bodies[-1]
    time = result.original.time
    for positions, colour, label in zip(
        result.positions, (BEFORE, AFTER), ("before", "after"), strict=True
    ):
        velocity = np.gradient(positions[:, tree.body(name)], time, axis=0)
        axes.plot(time, np.linalg.norm(velocity, axis=1), color=colour, label=label)
    axes.set(xlabel="time, s", ylabel="speed, m/s", title=f"speed of {name}")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")


def _draw_coefficients(axes: Any, result: EditResult, bound: float) -> None:
    own, edited = result.own_coefficients, result.coefficients
    if own is None or edited is None:
        axes.set_axis_off()
        return
    places = np.arange(1, own.size + 1)
    farthest = edited[np.abs(edited).argmax(axis=0), places - 1]
    axes.bar(places - 0.2, own, width=0.4, color=BEFORE, label="before")
    axes.bar(places + 0.2, farthest, width=0.4, color=AFTER, label="after (of any frame)")
    for line in (-bound, bound):
        axes.axhline(line, color="black", linestyle=":", linewidth=1)
    axes.locator_params(axis="x", integer=True)
    axes.set(xlabel="component", ylabel="coefficient, sigma", title="dotted: bound unless forced")
    axes.legend(fontsize="small")
