"""Motions as comma-separated text that a spreadsheet opens.

::

    # armsyn-motion-1
    # source: reach of 0.35 -0.10 -0.15 on port ...
    # frames: 361
    time_s,elbow:angle_rad,hand:x_m,hand:y_m,hand:z_m,elbow:commanded_rad
    0.0,0.12,0.31,-0.1,-0.2,0.12

Lines that start with `#` before the column names are remarks; three of them are read: the schema
(another one is refused), `source` and `frames` (when given, so many rows must follow, which finds
a file that was cut). Then one line of column names, then one line a frame. A column is named
`NAME:QUANTITY`, split at the last colon:

- `time_s` (no name): seconds, strictly increasing; the only column that must be there;
- `NAME:angle_rad`: a joint's (measured) angle, rad, or m for a prismatic joint;
- `NAME:x_m`, `NAME:y_m`, `NAME:z_m`: a landmark's position, all three; the end effector is the
  last landmark. An empty cell or `nan` is a gap;
- `NAME:filled`: 1 where the landmark was not captured but filled in, else 0; may be missing;
- **everything else is ignored**, whatever it holds. A recording adds columns under quantities of
  its own, such as `NAME:commanded_rad`, `NAME:velocity_rad_s`, `NAME:current_a`,
  `NAME:hardware_error`.

Numbers are written so that reading them back gives the same bits. UTF-8, with or without a byte
order mark; the last line must end with a line end.
"""

from __future__ import annotations

import csv
import math
from array import array
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import NamedTuple, TextIO

import numpy as np

from armsyn.errors import FormatError
from armsyn.motion.formats.files import check_size, replacing
from armsyn.motion.motion import BoolArray, FloatArray, Motion

SCHEMA = "armsyn-motion-1"
LARGEST_FILE = 64 * 2**20
MOST_ROWS = 500_000
MOST_COLUMNS = 1_000
AXES = ("x_m", "y_m", "z_m")


class Columns(NamedTuple):
    """Where the parts of a motion stand in a row."""

    width: int
    time: int
    joints: dict[str, int]
    landmarks: dict[str, list[int]]
    filled: dict[str, int]


def read(path: Path) -> Motion:
    """Read a motion from a CSV file; see the module for its layout.

    Parameters
    ----------
    path : Path
        Of the file.

    Returns
    -------
    Motion
        Its source is the file's, else the file's name.

    Raises
    ------
    FormatError
        One line with the file and the line or column that is wrong.
    """
    check_size(path, LARGEST_FILE)
    _check_last_line(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return parse(file, path)
    except UnicodeDecodeError as error:
        raise FormatError(f"{path}: not UTF-8 text (byte {error.start})") from error
    except csv.Error as error:
        raise FormatError(f"{path}: not comma-separated text: {error}") from error
    except OSError as error:
        raise FormatError(f"{path}: cannot read it: {error.strerror}") from error


def _check_last_line(path: Path) -> None:
    with path.open("rb") as file:
        file.seek(-1, 2)
        if file.read(1) not in b"\r\n":
            raise FormatError(f"{path}: the last line has no end: the file was cut")


def parse(file: TextIO, path: Path) -> Motion:
    """Read a motion from text; `path` is what messages call it. See `read`."""
    remarks, first = _read_remarks(file)
    if remarks.get("schema", SCHEMA) != SCHEMA:
        raise FormatError(f"{path}: schema '{remarks['schema']}', expected '{SCHEMA}'")
    reader = csv.reader(chain([first], file), strict=True)
    columns = find_columns(next(reader, []), path)
    rows = _read_rows(reader, columns, int(remarks["lines"]), path)
    if remarks.get("frames", str(len(rows))) != str(len(rows)):
        raise FormatError(
            f"{path}: {len(rows)} rows, '# frames' says {remarks['frames']}: the file was cut"
        )
    return _assemble(rows, columns, remarks.get("source", path.name), path)


def _read_remarks(file: TextIO) -> tuple[dict[str, str], str]:
    """Return what the '#' lines say, and the first line after them."""
    remarks: dict[str, str] = {}
    lines = 0
    while (line := file.readline()).startswith("#"):
        lines += 1
        key, colon, value = line[1:].strip().partition(":")
        if colon:
            remarks[key] = value.strip()
        elif key.startswith("armsyn-"):
            remarks["schema"] = key
    remarks["lines"] = str(lines)
    return remarks, line


def find_columns(header: list[str], path: Path) -> Columns:
    """Find the parts of a motion among the names of columns; others are ignored.

    Raises
    ------
    FormatError
        When there are too many, two of one name, or none of a motion's parts.
    """
    if len(header) > MOST_COLUMNS:
        raise FormatError(f"{path}: {len(header)} columns, more than {MOST_COLUMNS}")
    places: dict[str, int] = {}
    for place, cell in enumerate(header):
        if cell in places:
            raise FormatError(f"{path}: two columns '{cell}'")
        places[cell] = place
    if "time_s" not in places:
        raise FormatError(f"{path}: no column 'time_s': the first row must name the columns")
    split = [(*cell.rpartition(":")[::2], place) for cell, place in places.items()]
    joints = {name: place for name, quantity, place in split if quantity == "angle_rad"}
    named = dict.fromkeys(name for name, quantity, _ in split if quantity in AXES)
    landmarks = {name: [places.get(f"{name}:{axis}", -1) for axis in AXES] for name in named}
    for name, where in landmarks.items():
        if -1 in where:
            raise FormatError(f"{path}: no column '{name}:{AXES[where.index(-1)]}'")
    if not joints and not landmarks:
        raise FormatError(f"{path}: no column 'NAME:angle_rad' and none 'NAME:x_m'")
    filled = {name: places[f"{name}:filled"] for name in landmarks if f"{name}:filled" in places}
    return Columns(len(header), places["time_s"], joints, landmarks, filled)


def _read_rows(
    reader: Iterator[list[str]], columns: Columns, lines_before: int, path: Path
) -> FloatArray:
    """Return time, angles, marks and coordinates of every row, shape (frames, numbers)."""
    must = [columns.time, *columns.joints.values(), *columns.filled.values()]
    may = [place for where in columns.landmarks.values() for place in where]
    values = array("d")
    count = 0
    for count, row in enumerate(reader, start=1):
        line = lines_before + 1 + count
        if count > MOST_ROWS:
            raise FormatError(f"{path}: more than {MOST_ROWS} rows: cut the motion")
        if len(row) != columns.width:
            raise FormatError(f"{path}: line {line}: {len(row)} cells, expected {columns.width}")
        try:
            values.extend([_number(row[place]) for place in must])
            values.extend([_number_or_gap(row[place]) for place in may])
        except ValueError as error:
            raise FormatError(f"{path}: line {line}: {error}") from None
    if not values:
        raise FormatError(f"{path}: no rows after the column names: the file was cut")
    return np.frombuffer(values, dtype=np.float64).reshape(count, len(must) + len(may))


def _number(cell: str) -> float:
    # float() also takes '1_000' and the digits of other scripts.
    if cell.isascii() and "_" not in cell:
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if math.isfinite(value):
            return value
    raise ValueError(f"'{cell[:40]}' is not a finite number")


def _number_or_gap(cell: str) -> float:
    return math.nan if cell.strip().lower() in {"", "nan"} else _number(cell)


def _assemble(rows: FloatArray, columns: Columns, source: str, path: Path) -> Motion:
    joints, landmarks = tuple(columns.joints), tuple(columns.landmarks)
    end = 1 + len(joints)
    filled = np.zeros((len(rows), len(landmarks)), dtype=np.bool_)
    for place, name in enumerate(columns.filled, start=end):
        filled[:, landmarks.index(name)] = rows[:, place] != 0
    first = end + len(columns.filled)
    try:
        return Motion(
            time=rows[:, 0],
            joint_names=joints,
            angles=rows[:, 1:end] if joints else None,
            landmark_names=landmarks,
            landmarks=rows[:, first:].reshape(len(rows), -1, 3) if landmarks else None,
            source=source,
            filled=filled if columns.filled else None,
        )
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error


def header_of(motion: Motion) -> list[str]:
    """Return the column names of a motion, in the order `rows_of` has.

    Parameters
    ----------
    motion : Motion
        Any; its names are printable text.

    Returns
    -------
    list of str
        `time_s`, the joints' angles, the landmarks' coordinates, marks of what was filled in.

    Raises
    ------
    FormatError
        When a name holds a line break or another character that is not printable.
    """
    names = (*motion.joint_names, *motion.landmark_names)
    for name in names:
        if not name.isprintable():
            raise FormatError(f"cannot write the name {name!r} as a column: rename it")
    angles = [f"{name}:angle_rad" for name in motion.joint_names]
    coordinates = [f"{name}:{axis}" for name in motion.landmark_names for axis in AXES]
    return ["time_s", *angles, *coordinates, *(f"{name}:filled" for name in _filled_in(motion))]


def rows_of(motion: Motion) -> FloatArray:
    """Return a motion as one table.

    Parameters
    ----------
    motion : Motion
        Any.

    Returns
    -------
    array, shape (frames, columns)
        In the order of `header_of`, SI units.
    """
    parts = [motion.time[:, None]]
    if motion.angles is not None:
        parts.append(motion.angles)
    if motion.landmarks is not None:
        parts.append(motion.landmarks.reshape(motion.frames, -1))
    parts.extend(column[:, None].astype(np.float64) for column in _filled_in(motion).values())
    return np.concatenate(parts, axis=1)


def _filled_in(motion: Motion) -> dict[str, BoolArray]:
    if motion.filled is None:
        return {}
    columns = zip(motion.landmark_names, motion.filled.T, strict=True)
    return {name: column for name, column in columns if column.any()}


def write(path: Path, motion: Motion, extra: dict[str, FloatArray] | None = None) -> None:
    """Write a motion as a CSV file; see the module for its layout.

    Parameters
    ----------
    path : Path
        Of the file; it appears whole or not at all.
    motion : Motion
        Any; its names are printable text. Line breaks in its source become spaces.
    extra : dict of str to array, shape (frames,)
        More columns by their full name, `NAME:QUANTITY`, which `read` ignores. With
        them it is a recording, which cannot be made again: it is written whatever its size.

    Raises
    ------
    FormatError
        When a name is not printable, or `read` would refuse so many rows, columns or bytes.
    InputError
        When the file cannot be written.
    """
    limited = extra is None
    extra = extra or {}
    header = [*header_of(motion), *extra]
    for count, most, of in (
        *((len(header), MOST_COLUMNS, "columns"), (motion.frames, MOST_ROWS, "rows")),
    ):
        if limited and count > most:
            raise FormatError(f"{path}: {count} {of}, more than {most}: name an .npz file")
    table = np.column_stack([rows_of(motion), *extra.values()])
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        source = " ".join(motion.source.split())
        file.write(f"# {SCHEMA}\n# source: {source}\n# frames: {motion.frames}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        for row in table.tolist():
            writer.writerow(["" if math.isnan(value) else repr(value) for value in row])
        if limited and file.tell() > LARGEST_FILE:
            raise FormatError(f"{path}: more than {LARGEST_FILE} bytes: name an .npz file")
