"""Captured reaches by name: where they are, how they are cut, and how they are selected.

A selection is ``SET[:PART[:PART]]``:

================================ ==========================================================
``garza``                        the 35 reaches from rest, one a target
``garza:return``                 the 35 ways back to rest
``garza:all``                    both
``garza:ForwardHigh``            one reach (``garza:ForwardHigh:return`` its way back)
``hug_mp:S01``                   the first two usable repetitions of each target from rest
``hug_mp:S01:all``               every usable reach from rest
``hug_mp:S01:2:R-9``             the reaches of repetition 2 from rest to target 9
``hug_mp:S01:2.4.5:R-9``         the one that is motion 5 of task 4
================================ ==========================================================

Several selections are joined by commas. Frames are those of the table in ``segments/``.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TypeVar

from armsyn.errors import CaptureError, FormatError
from armsyn.motion.formats.garza import read_garza
from armsyn.motion.formats.hug_mp import read_hug_mp
from armsyn.motion.motion import Motion

ENVIRONMENT_VARIABLE = "ARMSYN_CAPTURES"
REST = "rest"
_FRAMES = {"frm", "to", "start_frame", "end_frame"}
_WHOLE_NUMBERS = {"rep", "task", "motion", "start_frame", "end_frame"}
_GARZA_KINDS = {"return": {"return"}, "all": {"reach", "return"}}
Row = dict[str, str]
Key = TypeVar("Key")


@dataclass(frozen=True)
class Capture:
    """One captured reach, cut from rest to target (or back).

    Parameters
    ----------
    name : str
        Such as ``garza:ForwardHigh`` or ``hug_mp:S01:2.4.5:R-9``: the selection that finds it.
    kind : {"reach", "return"}
    motion : Motion
        Landmarks in the arm's base frame: shoulder at the origin, x forward, y left, z up.
    source : str
        Set, file and frames.
    """

    name: str
    kind: str
    motion: Motion
    source: str


def captures_folder() -> Path:
    """Folder of the captured motions: ``$ARMSYN_CAPTURES``, else beside the checkout.

    Raises
    ------
    CaptureError
        When it is not there.
    """
    beside = Path(__file__).resolve().parents[3] / "shared" / "captures"
    folder = Path(os.environ.get(ENVIRONMENT_VARIABLE) or beside)
    if not (folder / "segments").is_dir():
        raise CaptureError(
            f"no captured motion in {folder}: set {ENVIRONMENT_VARIABLE} to the captures' folder"
        )
    return folder


def load_captures(selection: str) -> list[Capture]:
    """Load the captures of a selection.

    Parameters
    ----------
    selection : str
        See the module's table.

    Returns
    -------
    list of Capture
        In the order of the segments table; what is named twice, once.

    Raises
    ------
    CaptureError
        Unknown set or part, nothing selected, or captures that are not there.
    FormatError
        A capture file that cannot be read.
    """
    found: dict[str, Capture] = {}
    for text in selection.split(","):
        name, *parts = text.strip().split(":")
        if name not in _SETS:
            raise CaptureError(f"{text!r}: no such set of captures; known: {', '.join(_SETS)}")
        captures = _SETS[name](parts)
        if not captures:
            raise CaptureError(f"{text!r} selects no capture of {name}")
        found.update((capture.name, capture) for capture in captures)
    return list(found.values())


def is_selection(text: str) -> bool:
    """Say whether a text names a known set of captures, whatever it selects of it."""
    return text.split(":", maxsplit=1)[0] in _SETS


def _garza(parts: list[str]) -> list[Capture]:
    target = parts[0] if parts and parts[0] not in _GARZA_KINDS else None
    which = parts if target is None else parts[1:]
    if len(which) > 1 or not _GARZA_KINDS.keys() >= set(which):
        raise CaptureError(f"garza:{':'.join(parts)}: at most a target, then 'return' or 'all'")
    kinds = _GARZA_KINDS[which[0]] if which else {"reach"}
    motions = _motions(read_garza, "reach/garza/reach.npz")
    found = []
    for row in _segments("garza.csv", _FRAMES | {"file"}):
        kind = "reach" if row["frm"] == REST else "return"
        place = row["to" if kind == "reach" else "frm"].removesuffix("01")
        if kind in kinds and target in (None, place):
            name = f"garza:{place}" + (":return" if kind == "return" else "")
            motion = motions.get(row["file"].removesuffix(".skm"))
            found.append(_capture(name, kind, motion, row))
    return found


def _hug_mp(parts: list[str]) -> list[Capture]:
    if not parts or len(parts) > 3:
        raise CaptureError("hug_mp: say whose reaches, such as hug_mp:S01")
    subject, *rest = parts
    rows = [
        row
        for row in _segments("hug_mp.csv", _FRAMES | {"subject", "rep", "task", "motion", "usable"})
        if row["subject"] == subject and row["usable"] == "True" and row["frm"] == "R"
    ]
    if len(rest) == 2:
        rows = [row for row in rows if rest[0] in (row["rep"], _key(row)) and rest[1] == _way(row)]
    elif not rest:
        rows = _first_two_of_each(rows)
    elif rest != ["all"]:
        raise CaptureError(f"hug_mp:{':'.join(parts)}: 'all', or a repetition and R-TARGET")
    if not rows:
        return []
    motions = _motions(read_hug_mp, f"reach/hug_mp/{subject}_trajs.mat")
    return [
        _capture(
            f"hug_mp:{subject}:{_key(row)}:{_way(row)}",
            "reach",
            motions.get((int(row["rep"]), int(row["task"]), int(row["motion"]))),
            row,
        )
        for row in rows
    ]


def _key(row: Row) -> str:
    return f"{row['rep']}.{row['task']}.{row['motion']}"


def _way(row: Row) -> str:
    return f"{row['frm']}-{row['to']}"


def _first_two_of_each(rows: Iterable[Row]) -> list[Row]:
    """Keep the paper's experiment: 14 motions are two repetitions of the 7 targets from rest."""
    kept: list[Row] = []
    for row in rows:
        if sum(other["to"] == row["to"] for other in kept) < 2:
            kept.append(row)
    return kept


def _capture(name: str, kind: str, motion: Motion | None, row: Row) -> Capture:
    first, last = int(row["start_frame"]), int(row["end_frame"])
    if motion is None or not 0 <= first < last < motion.frames:
        raise CaptureError(f"{name}: the segments table names frames {first}-{last}, not captured")
    source = f"{motion.source}, frames {first}-{last} at {float(row['rate_hz']):g} Hz"
    return Capture(name, kind, motion.between(first, last), source)


@cache
def _cached(read: Callable[[Path], dict[Key, Motion]], path: Path) -> dict[Key, Motion]:
    return read(path)


def _motions(read: Callable[[Path], dict[Key, Motion]], name: str) -> dict[Key, Motion]:
    path = captures_folder() / name
    try:
        return _cached(read, path)
    except FileNotFoundError as error:
        raise CaptureError(f"{path} is missing from the captures") from error


def _segments(name: str, columns: set[str]) -> list[Row]:
    path = captures_folder() / "segments" / name
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file, strict=True))
        for row in rows:
            _ = [int(row[column]) for column in _WHOLE_NUMBERS & row.keys()]
            _ = [row[column].strip() for column in columns], float(row["rate_hz"])
    except (OSError, csv.Error, KeyError, TypeError, ValueError) as error:
        raise FormatError(f"{path}: no table of segments: {error}") from error
    return rows


_SETS: dict[str, Callable[[list[str]], list[Capture]]] = {"garza": _garza, "hug_mp": _hug_mp}
