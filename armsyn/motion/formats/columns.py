"""The declared map of a table's columns: see `armsyn.motion.formats.delimited` for its keys."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from armsyn.errors import FormatError
from armsyn.motion.formats.files import check_size

LARGEST_FILE = 2**20
Column = str | Annotated[int, msgspec.Meta(ge=1, le=10_000)]
_Unit = Literal["m", "cm", "mm", "in", "ft"]


class ColumnMap(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Which column is what.

    Parameters
    ----------
    delimiter : str
        One character, ``tab`` or ``space``.
    skip_lines : int
        Lines before the headings.
    headings : bool
        Whether there is a line of headings.
    time : str, int or None
        Column of the time stamps.
    time_unit : {"s", "ms", "us", "ns"}
    rate : float or None
        Frames a second, instead of `time`.
    length_unit : {"m", "cm", "mm", "in", "ft"} or None
        m is assumed, and said.
    angle_unit : {"rad", "deg"} or None
        rad is assumed, and said.
    up : {"x", "y", "z"} or None
        z is assumed, and said.
    landmarks : dict of str to three columns
        The end effector last.
    joints : dict of str to column
    """

    delimiter: Annotated[str, msgspec.Meta(pattern="^(.|tab|space)$")] = ","
    skip_lines: Annotated[int, msgspec.Meta(ge=0, le=10_000)] = 0
    headings: bool = True
    time: Column | None = None
    time_unit: Literal["s", "ms", "us", "ns"] = "s"
    rate: Annotated[float, msgspec.Meta(gt=0, le=1e6)] | None = None
    length_unit: _Unit | None = None
    angle_unit: Literal["rad", "deg"] | None = None
    up: Literal["x", "y", "z"] | None = None
    landmarks: dict[str, tuple[Column, Column, Column]] = {}
    joints: dict[str, Column] = {}


def read_columns(path: Path) -> ColumnMap:
    """Read a map of columns.

    Parameters
    ----------
    path : Path
        A TOML file.

    Returns
    -------
    ColumnMap

    Raises
    ------
    FormatError
        When it cannot be read, a key is unknown or a value of the wrong kind, or it maps nothing.
    """
    check_size(path, LARGEST_FILE)
    try:
        found = msgspec.convert(tomllib.loads(path.read_text("utf-8")), ColumnMap)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise FormatError(f"{path}: not a TOML file: {' '.join(str(error).split())}") from error
    except msgspec.ValidationError as error:
        raise FormatError(f"{path}: {error}") from error
    if not found.landmarks and not found.joints:
        raise FormatError(f"{path}: neither [landmarks] nor [joints]: it maps no column")
    named = [*found.joints.values(), *(c for three in found.landmarks.values() for c in three)]
    if not found.headings and any(isinstance(column, str) for column in (*named, found.time)):
        raise FormatError(f"{path}: without headings, columns are told by their numbers from 1")
    if found.delimiter in ('"', "\r", "\n"):
        raise FormatError(f"{path}: this delimiter cannot separate cells")
    return found
