"""Delimited text: our own CSV, any table with a declared map of columns, logs of a robot's joints.

A map is a TOML file; a column is named by its heading, or by its number from 1::

    delimiter = ","          # one character, "tab" or "space" (any run of blanks); "," by default
    skip_lines = 0           # lines before the headings
    headings = true          # whether a line of headings follows them
    time = "Time (s)"        # column of time stamps ...
    time_unit = "s"          # s, ms, us or ns
    rate = 100.0             # ... or frames a second, instead of a column
    length_unit = "mm"       # m, cm, mm, in, ft
    angle_unit = "deg"       # rad, deg
    up = "z"                 # x, y, z
    [landmarks]              # the end effector last
    wrist = ["wx", "wy", "wz"]
    hand = ["hx", "hy", "hz"]
    [joints]
    elbow = "elbow angle"

An empty cell or ``nan`` of a landmark is a gap. Other columns are ignored.

A log of joints needs no map when it is read with a URDF or an arm: columns that are headed by its
joints' names are their angles (rad unless told otherwise; m for prismatic joints), one headed
time, time_s, t or timestamp holds seconds. When all joints of the chain are there, the positions
of the joints and the tip are its landmarks, in the frame of the base.
"""

from __future__ import annotations

import csv
from array import array
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np

from armsyn.errors import FormatError
from armsyn.motion.formats import csv_format, csv_reaches
from armsyn.motion.formats.columns import Column, ColumnMap, read_columns
from armsyn.motion.formats.joint_logs import JointLog, read_joint_log
from armsyn.motion.formats.options import RADIANS, Reading, ReadOptions, fact, metres, z_up
from armsyn.motion.formats.text import Lines
from armsyn.motion.motion import FloatArray, Motion

MOST_COLUMNS = 10_000
MOST_NUMBERS = 30_000_000
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_STAMPS = ("time", "time_s", "t", "timestamp")
_DELIMITERS = {"tab": "\t", "space": " "}


def read(path: Path, options: ReadOptions) -> Reading:
    """Read delimited text: by a map, by a robot's joints, else as our own CSV.

    Parameters
    ----------
    path : Path
    options : ReadOptions
        `columns`, or `joints`; with either `rate` and `unit` (of joints: of the angles) and with
        a map `up`.

    Returns
    -------
    Reading

    Raises
    ------
    FormatError
        One line with the file and the line, or the key of the map, that is wrong.
    """
    if options.columns and options.joints:
        raise FormatError(f"{path}: read it by a map of columns or by joints, not by both")
    if options.take is not None and (options.columns or options.joints):
        raise FormatError(f"{path}: a map of columns or joints finds one motion, without a name")
    if options.columns:
        return _read_mapped(path, read_columns(options.columns), options)
    if options.joints and options.up:
        raise FormatError(f"{path}: a log of joints has no axis up: leave out option 'up'")
    if options.joints:
        return _read_log(path, read_joint_log(options.joints), options)
    if path.suffix.lower() != ".csv":
        raise FormatError(f"{path}: say what its columns are, by a map or a robot's joints")
    if not options.given() - {"take"} and csv_reaches.is_reaches(path):
        return csv_reaches.read(path, options)
    if options.take is not None:
        raise FormatError(
            f"{path}: holds one motion without a name: leave out #{options.take[:60]}"
        )
    unheard = sorted(options.given())
    if unheard:
        raise FormatError(
            f"{path}: option '{unheard[0]}' needs a map of columns or a robot's joints beside it"
        )
    return Reading(csv_format.read(path), {})


def _read_mapped(path: Path, columns: ColumnMap, options: ReadOptions) -> Reading:
    rate = options.rate or columns.rate
    if (columns.time is None and not rate) or (columns.time is not None and columns.rate):
        raise FormatError(f"{options.columns}: 'time' or 'rate': one of them, not both")
    timed = [] if rate or columns.time is None else [columns.time]
    marks = [place for places in columns.landmarks.values() for place in places]
    wanted = [*timed, *columns.joints.values()]
    numbers = _read_columns(path, columns, wanted, marks)
    time = np.arange(len(numbers)) / rate if rate else numbers[:, 0] * _SECONDS[columns.time_unit]
    first = len(wanted)
    said_unit, said_up = options.unit or columns.length_unit, options.up or columns.up
    unit, up, angle_unit = said_unit or "m", said_up or "z", columns.angle_unit or "rad"
    positions = numbers[:, first:].reshape(len(numbers), len(columns.landmarks), 3)
    landmarks = z_up(positions * metres(unit), up)
    angles = numbers[:, len(timed) : first] * RADIANS[angle_unit]
    motion = _motion(path, time, tuple(columns.joints), angles, tuple(columns.landmarks), landmarks)
    facts = {"columns": str(options.columns)}
    if columns.landmarks:
        facts |= {"unit": fact(unit, said_unit), "up": fact(up, said_up)}
    if columns.joints:
        facts["angle unit"] = fact(angle_unit, columns.angle_unit)
    return Reading(motion, facts)


def _motion(
    path: Path,
    time: FloatArray,
    joints: tuple[str, ...],
    angles: FloatArray,
    names: tuple[str, ...],
    landmarks: FloatArray,
) -> Motion:
    try:
        return Motion(
            time=time,
            joint_names=joints,
            angles=angles if joints else None,
            landmark_names=names,
            landmarks=landmarks if names else None,
            source=path.name,
        )
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error


def _read_columns(
    path: Path, columns: ColumnMap, must: Sequence[Column], may: Sequence[Column]
) -> FloatArray:
    """Return the wanted columns of every row; cells of `may` may be gaps."""
    with closing(Lines(path)) as lines:
        for _ in range(columns.skip_lines):
            lines.next("line of those to skip")
        rows = _rows(lines, _DELIMITERS.get(columns.delimiter, columns.delimiter))
        headings = next(rows, []) if columns.headings else []
        if len(headings) > MOST_COLUMNS:
            lines.fail(f"{len(headings)} columns, more than {MOST_COLUMNS}")
        places = [_place(lines, column, headings) for column in (*must, *may)]
        return _numbers(lines, rows, places, len(must))


def _rows(lines: Lines, delimiter: str) -> Iterator[list[str]]:
    """Split each line into cells; blank lines are left out."""
    if delimiter == " ":
        yield from (cells for line in lines if (cells := line.split()))
        return
    for line in lines:
        if not line.strip(" \r\n"):
            continue  # tabs alone are a row in which everything is missing
        try:
            (cells,) = csv.reader([line.rstrip("\r\n")], strict=True, delimiter=delimiter)
        except csv.Error as error:
            lines.fail(f"not delimited text: {error}")
        yield [cell.strip() for cell in cells]


def _place(lines: Lines, column: Column, headings: list[str]) -> int:
    if isinstance(column, int):
        return column - 1
    if headings.count(column) != 1:
        there = ", ".join(headings)[:120]
        how = "two columns" if column in headings else "no column"
        lines.fail(f"{how} '{column[:40]}' among the headings: {there}")
    return headings.index(column)


def _numbers(lines: Lines, rows: Iterator[list[str]], places: list[int], must: int) -> FloatArray:
    values = array("d")
    width, most = max(places) + 1, MOST_NUMBERS // len(places)
    for count, cells in enumerate(rows, start=1):
        if count > most:
            lines.fail(f"more than {most} rows of {len(places)} wanted numbers: cut the motion")
        if len(cells) < width:
            lines.fail(f"{len(cells)} cells, but column {width} is wanted")
        wanted = [cells[place] for place in places]
        values.extend(lines.numbers(wanted[:must]))
        values.extend(lines.numbers_or_gaps(wanted[must:]))
    return lines.table(values, len(places))


def _read_log(path: Path, log: JointLog, options: ReadOptions) -> Reading:
    stamps, joints = _log_columns(path, log, options)
    unit = options.unit or "rad"
    if unit not in RADIANS:
        raise FormatError(f"{path}: joints are told in rad or deg, not in '{unit[:40]}'")
    columns = ColumnMap(delimiter=_delimiter_of(path))
    numbers = _read_columns(path, columns, [*stamps, *joints], [])
    angles = numbers[:, len(stamps) :].copy()
    turning = [name not in log.prismatic for name in joints]
    angles[:, turning] *= RADIANS[unit]
    time = np.arange(len(numbers)) / options.rate if options.rate else numbers[:, 0]
    names, landmarks = log.landmarks(joints, angles)
    motion = _motion(path, time, tuple(joints), angles, names, landmarks)
    missing = [name for name in log.names if name not in joints]
    facts = {"joints": str(options.joints), "unit": fact(unit, options.unit)}
    if missing:
        facts["not in it"] = ", ".join(missing)
    return Reading(motion, facts)


def _log_columns(path: Path, log: JointLog, options: ReadOptions) -> tuple[list[str], list[str]]:
    """Return the headings of the time, when no rate is told, and of the robot's joints."""
    headings = _headings(path)
    joints = [name for name in log.names if name in headings]
    if not joints:
        raise FormatError(
            f"{path}: no column is headed by a joint of {options.joints}: {', '.join(log.names)}"
        )
    if options.rate:
        return [], joints
    stamps = [name for name in headings if name.lower() in _STAMPS]
    if len(stamps) != 1:
        raise FormatError(f"{path}: {len(stamps)} columns of time (time, time_s, t): say the rate")
    return stamps, joints


def _delimiter_of(path: Path) -> str:
    return {".csv": ",", ".tsv": "tab"}.get(path.suffix.lower(), "space")


def _headings(path: Path) -> list[str]:
    name = _delimiter_of(path)
    with closing(Lines(path)) as lines:
        return next(_rows(lines, _DELIMITERS.get(name, name)), [])
