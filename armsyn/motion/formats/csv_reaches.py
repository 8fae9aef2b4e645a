"""Reaches in a chunk of `armsyn generate` as comma-separated text: one is read as ``FILE#INDEX``.

::

    # planned, not measured: no arm or person moved so
    # arm: human7
    # task: reach to the target
    reach,time_s,shoulder:angle_rad,elbow:angle_rad,target_x_m,target_y_m,target_z_m
    0,0,0.12,1.3,0.35,-0.1,-0.1

A row a frame, the rows of a reach together; ``reach`` is its index, angles are rad or m, and its
target, which all its rows tell, is where it was to end, m in the base frame. Arm, task and target
may be missing.
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
from armsyn.motion.formats.reaches import Target, episode_of, reading_of, source_of

LARGEST_FILE = 2**32
FIRST_COLUMNS = "reach,time_s,"
TARGET_COLUMNS = ("target_x_m", "target_y_m", "target_z_m")
_AT_ONCE = 1000
"""Characters: a line of another file may be endless."""


def is_reaches(path: Path) -> bool:
    """Return whether a file is a chunk of reaches."""
    if not path.is_file():
        return False  # a pipe would wait for ever; what reads it says why
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            while (line := file.readline(_AT_ONCE)).startswith("#"):
                while line and not line.endswith("\n"):
                    line = file.readline(_AT_ONCE)
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
    head: list[str] = []
    for name, rows in _reaches(path, head):
        wanted = name == options.take or (options.take is None and not there)
        text = "".join(rows) if wanted else ""
        there[name] = there.get(name, "") + text
    take = chosen(options.take, tuple(there), path)
    try:
        motion = csv_format.parse(io.StringIO(head[-1] + there[take]), path)
    except csv.Error as error:
        raise FormatError(f"{path}: reach {take}: not comma-separated text: {error}") from error
    said = dict(line[1:].strip().partition(": ")[::2] for line in head[:-1])
    arm, task = said.get("arm", ""), said.get("task", "")
    source = source_of(take, arm) if arm else f"{path.name}#{take}"
    motion = dataclasses.replace(motion, source=source)
    try:
        target = _target(head[-1] + there[take])
        return reading_of(episode_of(motion, take, arm=arm, task=task, target=target))
    except (FormatError, ValueError) as error:
        raise FormatError(f"{path}: reach {take}: {error}") from error


def _target(text: str) -> Target | None:
    """Return the target in the first row after the column names; None where there is none."""
    row = next(csv.DictReader(io.StringIO(text)))
    if not {*TARGET_COLUMNS} <= row.keys():
        return None
    x, y, z = (float(row[column]) for column in TARGET_COLUMNS)
    return x, y, z


def _reaches(path: Path, head: list[str]) -> Iterator[tuple[str, Iterator[str]]]:
    """Index and rows of every reach; remarks and the line of column names go to `head`."""
    check_size(path, LARGEST_FILE)
    try:
        with path.open(encoding="utf-8-sig", newline="\n") as file:
            for line in file:
                head.append(line)
                if not line.startswith("#"):
                    break
            lines = (line for line in file if not line.startswith("#"))
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
