"""A picture of an arm at rest and at zero."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from armsyn.arm import ArmDescription
from armsyn.arm.checks import TIP
from armsyn.errors import FormatError
from armsyn.motion.formats.files import replacing

_VIEWS = (("from its right", 0, 2, "x", "z"), ("from above", 0, 1, "x", "y"))


def draw_arm(arm: ArmDescription, path: Path) -> None:
    """Draw an arm from the side and from above, at rest and at zero.

    Parameters
    ----------
    arm : ArmDescription
    path : Path
        A PNG file; one of that name is replaced.

    Raises
    ------
    FormatError
        Another suffix.
    InputError
        A folder that cannot be written.
    """
    if path.suffix.lower() != ".png":
        raise FormatError(f"{path}: a picture is written as .png")
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 5), layout="constrained")
    figure.suptitle(f"{arm.name}: {arm.title}")
    for axes, view in zip(figure.subplots(1, 2), _VIEWS, strict=True):
        _draw(axes, arm, *view)
    figure.axes[0].legend()
    with replacing(path) as temporary:
        figure.savefig(temporary, format="png", dpi=120)


def _draw(axes: Any, arm: ArmDescription, title: str, one: int, other: int, *names: str) -> None:
    axes.set_title(f"seen {title}")
    postures = (("rest", arm.rest, "C0"), ("zero", np.zeros(arm.chain.dof), "C1"))
    rows = {frame: row for row, frame in enumerate((*arm.joint_names, TIP))}
    for label, posture, colour in postures:
        points = arm.chain.forward(posture).positions
        line = np.concatenate([np.zeros((1, 3)), points])
        axes.plot(line[:, one], line[:, other], "o-", color=colour, label=f"at {label}")
        for name, frame in arm.anatomy.items():
            place = points[rows[frame]][[one, other]]
            axes.annotate(name, place, xytext=(5, 5), textcoords="offset points", color=colour)
    axes.set_xlabel(f"{names[0]}, m")
    axes.set_ylabel(f"{names[1]}, m")
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(visible=True, alpha=0.3)
