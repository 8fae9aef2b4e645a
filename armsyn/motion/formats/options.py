"""What a reader may be told about a file, and what it found out: units, rates, the axis up.

Inside, z is up, x forward and y left. Files whose y (or x) is up are turned at the edge by a
cyclic exchange of the axes: y up, (x, y, z) becomes (z, x, y), which takes the usual y-up person
who faces z to one who faces x; x up, it becomes (y, z, x).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from armsyn.errors import FormatError
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats.episodes import Episode
from armsyn.motion.motion import FloatArray, Motion

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
RADIANS = {"rad": 1.0, "deg": math.pi / 180}
_CYCLE = {"z": (0, 1, 2), "y": (2, 0, 1), "x": (1, 2, 0)}
UPS = tuple(_CYCLE)


@dataclass(frozen=True)
class ReadOptions:
    """What the file itself does not say, or says wrongly.

    Parameters
    ----------
    take : str or None
        One of the motions of a file that holds several.
    unit : str or None
        Of lengths (m, cm, mm, in, ft, or a number of metres), or of the angles of a joint log
        (rad, deg).
    rate : float or None
        Frames a second.
    up : {"x", "y", "z"} or None
        Axis of the file that points up.
    columns : Path or None
        TOML file that says which column of a delimited text is what.
    joints : Path or None
        URDF file whose joints are the columns of a delimited text.
    skeleton : Path or None
        ASF file of an AMC file.

    Raises
    ------
    FormatError
        When a value is none of those allowed.
    """

    take: str | None = None
    unit: str | None = None
    rate: float | None = None
    up: str | None = None
    columns: Path | None = None
    joints: Path | None = None
    skeleton: Path | None = None

    def __post_init__(self) -> None:
        if self.rate is not None and not 0 < self.rate < 1e6:
            raise FormatError(f"rate {self.rate:g}: give frames a second, more than 0")
        if self.up is not None and self.up not in UPS:
            raise FormatError(f"up '{self.up}': give one of {', '.join(UPS)}")
        if self.unit is not None and self.unit not in RADIANS:
            metres(self.unit)

    def given(self) -> set[str]:
        """Names of the options that are set."""
        return {field.name for field in fields(self) if getattr(self, field.name) is not None}


@dataclass(frozen=True, eq=False)
class Reading:
    """A file as it was read.

    Parameters
    ----------
    motion : Motion
        SI units, z up.
    facts : dict of str to str
        What was found or assumed on the way: unit, rate, axis up, labels left out.
    body : BodyMotion or None
        For formats with a skeleton.
    episode : Episode or None
        The motion with what stands beside it, for formats that hold motions of an arm so.
    """

    motion: Motion
    facts: dict[str, str]
    body: BodyMotion | None = None
    episode: Episode | None = None


def metres(unit: str) -> float:
    """Return the metres of a unit of length: its name, or a positive number.

    Raises
    ------
    FormatError
        When it is neither.
    """
    try:
        value = METRES.get(unit) or float(unit)
    except ValueError:
        value = math.nan
    if not 0 < value < 1e6:
        known = ", ".join(METRES)
        raise FormatError(f"unit '{unit[:40]}': give one of {known}, or a number of metres")
    return value


def fact(value: str, told: object) -> str:
    """Return a value as a `Reading` states it: assumed, unless something told it."""
    return value if told else f"{value} (assumed)"


def z_up(vectors: ArrayLike, up: str) -> FloatArray:
    """Turn vectors of a file into ours.

    Parameters
    ----------
    vectors : array_like, shape (..., 3)
        Positions, directions or exponential maps.
    up : {"x", "y", "z"}
        Axis of the file that points up.

    Returns
    -------
    array, shape (..., 3)
        With z up.
    """
    return np.asarray(vectors, dtype=np.float64)[..., _CYCLE[up]]


def from_z_up(vectors: ArrayLike, up: str) -> FloatArray:
    """Turn our vectors into those of a file: the inverse of `z_up`."""
    back = np.argsort(_CYCLE[up])
    return np.asarray(vectors, dtype=np.float64)[..., back]
