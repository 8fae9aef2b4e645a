"""Motion files: one module a format, one table by suffix."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from armsyn.errors import FormatError
from armsyn.motion.formats import csv_format, npz_format
from armsyn.motion.motion import Motion


class Format(NamedTuple):
    """How files of one suffix are read and written."""

    read: Callable[[Path], Motion]
    write: Callable[[Path, Motion], None]


FORMATS: dict[str, Format] = {
    ".csv": Format(csv_format.read, csv_format.write),
    ".npz": Format(npz_format.read, npz_format.write),
}
"""By suffix, lower case."""


def read_motion(path: Path | str) -> Motion:
    """Read a motion or a recording; its suffix says the format.

    Parameters
    ----------
    path : Path or str
        A `.csv` or `.npz` file.

    Returns
    -------
    Motion
        A recording's angles are the measured ones.

    Raises
    ------
    FormatError
        When the suffix is unknown, or the file is missing, unreadable, damaged or too large; one
        line with the file and the place in it.
    """
    return _format_of(Path(path)).read(Path(path))


def write_motion(path: Path | str, motion: Motion) -> None:
    """Write a motion; the file appears whole or not at all.

    Parameters
    ----------
    path : Path or str
        A `.csv` or `.npz` file; an existing one is replaced.
    motion : Motion
        Any.

    Raises
    ------
    FormatError
        When the suffix is unknown, or the motion cannot be said in the format.
    InputError
        When the file cannot be written.
    """
    _format_of(Path(path)).write(Path(path), motion)


def _format_of(path: Path) -> Format:
    try:
        return FORMATS[path.suffix.lower()]
    except KeyError:
        known = ", ".join(FORMATS)
        raise FormatError(
            f"{path}: no motion format has the suffix '{path.suffix}': use one of {known}"
        ) from None
