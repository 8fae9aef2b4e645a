"""Reaches in a chunk of `armsyn generate` as comma-separated text: one is read as ``FILE#INDEX``.

::

    # planned, not measured: no arm or person moved so
    reach,time_s,shoulder:angle_rad,elbow:angle_rad
    0,0,0.12,1.3

A row a frame, the rows of a reach together; ``reach`` is its index, angles are rad or m.
"""

from __future__ import annotations

import csv
import dataclasses
import io
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

from armsyn.errors import FormatError
from armsyn.motion.formats import csv_format
from armsyn.motion.formats.files import check_size
from armsyn.motion.formats.npz_bodies import chosen
from armsyn.motion.formats.options import Reading, ReadOptions

LARGEST_FILE = 2**32
FIRST_COLUMNS = "reach,time_s,"
_LONGEST_REMARK = 1000


def is_reaches(path: Path) -> bool:
    """Return whether a file is a chunk of reaches."""
    if not path.is_file():
        return False  # a pipe would wait for ever; what reads it says why
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            while (line := file.readline(_LONGEST_REMARK)).startswith("#"):
                pass
            return line.startswith(FIRST_COLUMNS)
    except OSError:
        return False  # what reads it says why


def takes(path: Path) -> tuple[str, ...]:
    """Return the indices of the reaches in it, as texts; none of another file.

    Raises
    ------
    FormatError
        When it cannot be read.
    """
    if not is_reaches(path):
        return ()
    return tuple(dict.fromkeys(name for name, _ in _reaches(path, [])))


def read(path: Path, options: ReadOptions) -> Reading:
    """Read one reach.

    Parameters
    ----------
    path : Path
    options : ReadOptions
        `take` is heard.

    Returns
    -------
    Reading

    Raises
    ------
    FormatError
        When it is damaged, or the reach is not in it; the message names some that are.
    """
    there: dict[str, str] = {}
    header: list[str] = []
    for name, rows in _reaches(path, header):
        wanted = name == options.take or (options.take is None and not there)
        text = "".join(rows) if wanted else ""
        there[name] = there.get(name, "") + text
    take = chosen(options.take, tuple(there), path)
    try:
        motion = csv_format.parse(io.StringIO(header[0] + there[take]), path)
    except csv.Error as error:
        raise FormatError(f"{path}: reach {take}: not comma-separated text: {error}") from error
    motion = dataclasses.replace(motion, source=f"{path.name}#{take}")
    return Reading(motion, {"reach": take, "kind": "planned"})


def _reaches(path: Path, header: list[str]) -> Iterator[tuple[str, Iterator[str]]]:
    """Index and rows of every reach; the line of column names goes to `header`."""
    check_size(path, LARGEST_FILE)
    try:
        with path.open(encoding="utf-8-sig", newline="\n") as file:
            lines = (line for line in file if not line.startswith("#"))
            header.append(next(lines))
            for name, rows in groupby(lines, lambda line: line.partition(",")[0]):
                yield name, _whole(path, rows)
    except UnicodeDecodeError as error:
        raise FormatError(f"{path}: not UTF-8 text (byte {error.start})") from error
    except OSError as error:
        raise FormatError(f"{path}: cannot read it: {error.strerror}") from error


def _whole(path: Path, rows: Iterator[str]) -> Iterator[str]:
    for row in rows:
        if not row.endswith("\n"):
            raise FormatError(f"{path}: the last line has no end: the file was cut")
        yield row
