"""TRC, the marker files of Motion Analysis and OpenSim: tab-separated text.

::

    PathFileType  4  (X/Y/Z)  reach.trc
    DataRate  CameraRate  NumFrames  NumMarkers  Units  OrigDataRate  OrigDataStartFrame  ...
    100       100         2          1           mm     100           1                   2
    Frame#    Time        hand
                          X1         Y1          Z1

    1         0.0         120.5      830.0       -33.1
    2         0.01

An empty cell or ``nan`` is a gap. The format states no axis up: y, OpenSim's, is assumed and said
unless told otherwise. Written files have millimetres, y up, and the motion's own times; landmarks
only, and no angles.
"""

from __future__ import annotations

import math
from array import array
from contextlib import closing
from pathlib import Path

import numpy as np

from armsyn.errors import FormatError
from armsyn.motion.formats.files import replacing
from armsyn.motion.formats.options import (
    METRES,
    Reading,
    ReadOptions,
    fact,
    from_z_up,
    metres,
    z_up,
)
from armsyn.motion.formats.text import Lines
from armsyn.motion.motion import FloatArray, Motion

MOST_MARKERS = 1_000
MOST_POSITIONS = 10_000_000
"""Frames times markers."""


def read(path: Path, options: ReadOptions) -> Reading:
    """Read a TRC file.

    Parameters
    ----------
    path : Path
    options : ReadOptions
        `unit`, `up` and `rate` (instead of the file's times) are heard.

    Returns
    -------
    Reading

    Raises
    ------
    FormatError
        One line with the file and the line that is wrong.
    """
    with closing(Lines(path)) as lines:
        head = _read_head(lines)
        names = _read_names(lines, int(head["NumMarkers"]))
        rows = _read_rows(lines, int(head["NumFrames"]), len(names))
    unit, up = options.unit or head["Units"], options.up or "y"
    positions = rows[:, 1:].reshape(len(rows), -1, 3) * metres(unit)
    time = rows[:, 0] if options.rate is None else np.arange(len(rows)) / options.rate
    try:
        motion = Motion(
            time=time, landmark_names=names, landmarks=z_up(positions, up), source=path.name
        )
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error
    return Reading(motion, {"unit": unit, "up": fact(up, options.up)})


def _read_head(lines: Lines) -> dict[str, str]:
    if not lines.next("PathFileType").startswith("PathFileType"):
        lines.fail("a TRC file begins with PathFileType")
    keys, values = lines.next("DataRate ...").split(), lines.next("rates and counts").split()
    head = dict(zip(keys, values, strict=False))
    for key in ("NumFrames", "NumMarkers", "Units"):
        if key not in head:
            lines.fail(f"no {key} in the heading")
    markers = lines.whole(head["NumMarkers"], MOST_MARKERS)
    if markers == 0:
        lines.fail("NumMarkers is 0")
    lines.whole(head["NumFrames"], MOST_POSITIONS // markers)
    if head["Units"] not in METRES:
        lines.fail(f"unit '{head['Units'][:40]}': known: {', '.join(METRES)}")
    return head


def _read_names(lines: Lines, count: int) -> tuple[str, ...]:
    cells = _cells(lines.next("names of markers"))
    names = tuple(cell for cell in cells[2:] if cell)
    if cells[:2] != ["Frame#", "Time"] or len(names) != count or len(set(names)) != count:
        lines.fail(f"'Frame#', 'Time' and {count} different names of markers expected")
    if lines.next("X1 Y1 Z1").split()[:3] != ["X1", "Y1", "Z1"]:
        lines.fail("'X1 Y1 Z1 ...' expected")
    return names


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.rstrip("\r\n").split("\t")]


def _read_rows(lines: Lines, frames: int, markers: int) -> FloatArray:
    """Return the time and coordinates of every frame, shape (frames, 1 + 3 markers)."""
    width = 2 + 3 * markers
    values = array("d")
    count = 0
    for line in lines:
        cells = _cells(line)
        if not any(cells):
            continue
        count += 1
        if count > frames:
            lines.fail(f"more than the {frames} frames that NumFrames says")
        if len(cells) < width or any(cells[width:]):
            lines.fail(f"{len(cells)} cells, expected {width}, separated by tabs")
        values.extend(lines.numbers(cells[1:2]))
        values.extend(lines.numbers_or_gaps(cells[2:width]))
    if count != frames:
        raise FormatError(
            f"{lines.path}: line {lines.number + 1}: the file was cut: {count} of {frames} frames"
        )
    return lines.table(values, width - 1)


def write(path: Path, motion: Motion) -> None:
    """Write the landmarks of a motion as TRC: millimetres, y up.

    Parameters
    ----------
    path : Path
        The file appears whole or not at all.
    motion : Motion
        Its angles are not written: the format has no place for them.

    Raises
    ------
    FormatError
        When it has no landmarks, or a name would not read back.
    InputError
        When the file cannot be written.
    """
    if motion.landmarks is None:
        raise FormatError(f"{path}: TRC holds landmark positions, and the motion has only angles")
    for name in motion.landmark_names:
        if name.strip() != name or not name or not name.isprintable():
            raise FormatError(f"{path}: a marker of TRC cannot be named {name!r}: rename it")
    count = len(motion.landmark_names)
    coordinates = from_z_up(motion.landmarks, "y").reshape(motion.frames, -1) * 1000
    axes = [f"{axis}{number}" for number in range(1, count + 1) for axis in "XYZ"]
    rate = f"{motion.rate:.9g}"
    head = (
        f"PathFileType\t4\t(X/Y/Z)\t{path.name}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame"
        "\tOrigNumFrames",
        f"{rate}\t{rate}\t{motion.frames}\t{count}\tmm\t{rate}\t1\t{motion.frames}",
        "Frame#\tTime\t" + "\t\t\t".join(motion.landmark_names) + "\t\t",
        "\t\t" + "\t".join(axes),
        "",
    )
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        file.writelines(f"{line}\n" for line in head)
        for frame, (time, row) in enumerate(
            zip(motion.time.tolist(), coordinates.tolist(), strict=True), start=1
        ):
            cells = ("" if math.isnan(value) else repr(value) for value in row)
            file.write(f"{frame}\t{time!r}\t" + "\t".join(cells) + "\n")
