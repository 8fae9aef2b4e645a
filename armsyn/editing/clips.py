"""Whole movements of captured people by name, cut by the table of segments.

================================ ==========================================================
``garza``, ``garza:NAME``        the 35 reaches, or one, from rest to a target
``garza:return``, ``garza:all``  the ways back; both
``jump``, ``jump:NAME``          the 24 standing jumps, or one; the apex at 60 % of the time
``golf``, ``golf:3``             the 12 whole swings, or one; the ball is hit at 94/131 of the time
================================ ==========================================================

Several are joined by commas. Frames that the captures' notes call glitches are left out of the
swings, which leaves a longer step of time there; swing 11 has no whole follow-through (its left
arm flips from frame 321) and is not in the set.
"""

from __future__ import annotations

import csv
import dataclasses
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from armsyn.errors import CaptureError, FormatError
from armsyn.motion.body import BodyMotion
from armsyn.motion.captures import captures_folder
from armsyn.motion.formats import read_body

JUMP_APEX = 15 / 25
"""Of the time: frame 15 of 26 (second paper, section 7), counted from 0."""
GOLF_HIT = 94 / 131
"""Of the time: frame 94 of 132 (second paper, section 7), counted from 0."""
_GLITCHES = {"3": (104, 105, 106), "7": (45, 46, 47), "10": (88, 89, 90)}
_NO_FOLLOW_THROUGH = "11"
Row = dict[str, str]


def load_clips(selection: str) -> list[BodyMotion]:
    """Load the movements of a selection.

    Parameters
    ----------
    selection : str
        See the module's table.

    Returns
    -------
    list of BodyMotion
        In the order of the segments table; `source` is the selection that finds each alone.

    Raises
    ------
    CaptureError
        Unknown set or part, nothing selected, or captures that are not there.
    """
    found: list[BodyMotion] = []
    for text in selection.split(","):
        name, _, part = text.strip().partition(":")
        if name not in _SETS:
            raise CaptureError(f"{text!r}: no such set of motions; known: {', '.join(_SETS)}")
        clips = _SETS[name](part)
        if not clips:
            known = [clip.source.split(":")[1] for clip in _SETS[name]("")]
            raise CaptureError(
                f"{text!r} selects no motion of {name}; there are {name}:{', '.join(known)}"
            )
        found.extend(clips)
    return found


def is_clip_selection(text: str) -> bool:
    """Say whether a text names a known set of movements, whatever it selects of it."""
    return text.split(":", maxsplit=1)[0] in _SETS


def _garza(part: str) -> list[BodyMotion]:
    wanted, _, way = part.partition(":")
    if wanted in ("return", "all"):
        wanted, way = "", wanted
    found = []
    for row in _rows("garza.csv"):
        back = row["frm"] != "rest"
        place = row["frm" if back else "to"].removesuffix("01")
        if wanted in ("", place) and way in ("all", "return" if back else ""):
            name = f"garza:{place}" + (":return" if back else "")
            take = row["file"].removesuffix(".skm")
            found.append(_cut("reach/garza/reach.npz", take, name, *_ends(row)))
    return found


def _ends(row: Row) -> tuple[int, int]:
    return _number(row, "start_frame"), _number(row, "end_frame")


def _jump(part: str) -> list[BodyMotion]:
    found = []
    for row in _rows("jumps.csv"):
        if not row["file"].startswith("ChrGarza"):
            continue
        take = row["file"].removesuffix(".skm")
        name = take.rpartition("_")[2].removesuffix("01")
        if part in ("", name):
            apex, first = _number(row, "apex_frame"), _number(row, "window_start")
            last = round(first + (apex - first) / JUMP_APEX)
            found.append(_cut("jump/garza/jump.npz", take, f"jump:{name}", first, last))
    return found


def _golf(part: str) -> list[BodyMotion]:
    if part == _NO_FOLLOW_THROUGH:
        raise CaptureError(f"golf:{part}: its left arm flips after frame 320: no whole swing")
    found = []
    for row in _rows("golf.csv"):
        number = row["file"]
        if number != _NO_FOLLOW_THROUGH and row["dataset"] == "gears" and part in ("", number):
            hit, first = _number(row, "club_peak_frame"), _number(row, "takeaway_frame")
            last = round(first + (hit - first) / GOLF_HIT)
            body = _cut("golf/gears.npz", f"swing{int(number):02d}", f"golf:{number}", first, last)
            found.append(_without(body, [frame - first for frame in _GLITCHES.get(number, ())]))
    return found


def _number(row: Row, column: str) -> int:
    try:
        return round(float(row[column]))
    except (KeyError, ValueError) as error:
        raise FormatError(f"table of segments: no frame in '{column}': {row}") from error


def _without(body: BodyMotion, frames: list[int]) -> BodyMotion:
    kept = np.delete(np.arange(body.frames), frames)
    moved = body.translations
    return dataclasses.replace(
        body,
        time=body.time[kept],
        root=body.root[kept],
        rotations=body.rotations[kept],
        translations=None if moved is None else moved[kept],
    )


@cache
def _whole(path: Path, take: str) -> BodyMotion:
    return read_body(f"{path}#{take}")


def _cut(file: str, take: str, name: str, first: int, last: int) -> BodyMotion:
    body = _whole(captures_folder() / file, take)
    if not 0 <= first < last < body.frames:
        raise CaptureError(f"{name}: the segments table names frames {first}-{last}, not captured")
    return dataclasses.replace(body.between(first, last), source=name)


def _rows(name: str) -> list[Row]:
    path = captures_folder() / "segments" / name
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file, strict=True))
    except (OSError, csv.Error, UnicodeDecodeError) as error:
        raise FormatError(f"{path}: no table of segments: {error}") from error


_SETS: dict[str, Callable[[str], list[BodyMotion]]] = {
    "garza": _garza,
    "jump": _jump,
    "golf": _golf,
}
