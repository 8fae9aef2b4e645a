"""What the experiments' pictures share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from armsyn.motion.formats.files import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAPTURED, RAW, SYNERGY = "0.55", "black", "C0"
"""Colours: the captured motion, S_A and S_C."""


def figure(width: float, height: float) -> Figure:
    """Return an empty picture of a size in inches; matplotlib is imported only here."""
    from matplotlib.figure import Figure  # noqa: PLC0415  heavy, only pictures need it

    return Figure(figsize=(width, height), layout="constrained")


def save(drawn: Figure, folder: Path, name: str) -> str:
    """Write a picture as PNG and return its file's name.

    Raises
    ------
    InputError
        When it cannot be written.
    """
    with replacing(folder / name) as temporary:
        # Without the date and version that matplotlib adds, the same results are the same bytes
        drawn.savefig(temporary, format="png", dpi=110, metadata={"Software": None})
    return name


def spans(axes: Any, place: float, values: Any, colour: str, label: str | None = None) -> None:
    """Draw mean, least and greatest of distances (m) as the paper's figures 3 and 4 do, in cm."""
    in_cm = values * 100
    mean = in_cm.mean()
    axes.bar(place, mean, width=0.35, color=colour, edgecolor="black", label=label)
    reach = [[mean - in_cm.min()], [in_cm.max() - mean]]
    axes.errorbar(place, mean, yerr=reach, color="black", capsize=4)
