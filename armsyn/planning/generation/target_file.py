"""Files of targets: a line each, with what the hand and the arm are to do there.

::

    x, y, z, px, py, pz
    0.35, -0.1, -0.15, 0, 0, -1   # the hand points down

Numbers are parted by commas or blanks; empty lines and what follows a ``#`` count for nothing. A
first line may name the columns, in any order: x, y, z (m); px, py, pz, where the hand points (a
direction of any length), or roll, pitch, yaw, how it is turned (degrees, as URDF's rpy); and all
joints of the arm (rad or m), to start elsewhere than the others.
"""

from __future__ import annotations

import array
import math
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import FormatError
from armsyn.kinematics.rotation import from_rpy
from armsyn.planning.checking import FARTHEST
from armsyn.planning.generation.targets import ListedTargets
from armsyn.planning.posing import DEFAULT_TOLERANCE, Pointing, Turned

FloatArray = NDArray[np.float64]

LONGEST_LINE = 10_000
FARTHEST_M = 20.0
"""No arm is as long: when every target is beyond, other units than metres are meant."""

PLACE, POINTING, TURNED = ("x", "y", "z"), ("px", "py", "pz"), ("roll", "pitch", "yaw")
"""Names of columns."""


def read_targets(
    path: Path, joints: tuple[str, ...], tolerance: float = DEFAULT_TOLERANCE
) -> ListedTargets:
    """Read a file of targets; see the module for its layout.

    Parameters
    ----------
    path : Path
    joints : tuple of str
        Of the arm.
    tolerance : float
        Of the hands' orientations, rad.

    Returns
    -------
    ListedTargets

    Raises
    ------
    FormatError
        When it cannot be read, or a line is not as above: the message has its number.
    """
    names: list[str] | None = None
    numbers = array.array("d")
    for number, fields in _lines(path):
        where = f"{path}, line {number}"
        if names is None:
            names, is_header = _names(where, fields, joints)
            if is_header:
                continue
        if len(fields) != len(names):
            raise FormatError(f"{where}: {len(fields)} numbers, expected {len(names)}")
        values = [_number(where, field) for field in fields]
        if POINTING[0] in names and not any(values[names.index(name)] for name in POINTING):
            raise FormatError(f"{where}: px, py, pz are all 0, which is no direction")
        numbers.extend(values)
    if not numbers or names is None:
        raise FormatError(f"{path}: no targets in it")
    table = np.frombuffer(numbers, dtype=np.float64).reshape(-1, len(names))
    return _listed(path, {name: table[:, row] for row, name in enumerate(names)}, joints, tolerance)


def turned_by_degrees(angles: FloatArray, tolerance: float = DEFAULT_TOLERANCE) -> Turned:
    """Orientation by roll, pitch and yaw in degrees, shape (3,), as URDF's rpy."""
    return Turned(from_rpy(np.radians(angles)), tolerance)


def _listed(
    path: Path, columns: dict[str, FloatArray], joints: tuple[str, ...], tolerance: float
) -> ListedTargets:
    def together(names: Sequence[str]) -> FloatArray | None:
        return np.stack([columns[name] for name in names], axis=1) if names[0] in columns else None

    targets = together(PLACE)
    assert targets is not None  # noqa: S101  the columns are checked
    if (nearest := float(np.abs(targets).max(axis=1).min())) > FARTHEST_M:
        raise FormatError(
            f"{path}: the nearest target is {nearest:g} m away: targets are metres, these look like"
            " millimetres or centimetres"
        )
    starts, pointing = together(joints), together(POINTING)
    if pointing is not None:
        return ListedTargets(targets, starts, pointing, partial(Pointing, tolerance=tolerance))
    by = partial(turned_by_degrees, tolerance=tolerance)
    return ListedTargets(targets, starts, together(TURNED), by)


def _lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Number and fields of every line that says something."""
    try:
        with path.open(encoding="utf-8-sig") as file:
            for number, line in enumerate(iter(lambda: file.readline(LONGEST_LINE), ""), 1):
                if len(line) == LONGEST_LINE and not line.endswith("\n"):
                    raise FormatError(f"{path}, line {number}: longer than any line of targets")
                said = line.partition("#")[0].strip()
                if said:
                    parts = said.split("," if "," in said else None)
                    yield number, [part.strip() for part in parts]
    except OSError as error:
        raise FormatError(f"{path}: cannot read it: {error.strerror}") from error
    except UnicodeDecodeError:
        raise FormatError(f"{path}: not a text file of targets") from None


def _names(where: str, fields: list[str], joints: tuple[str, ...]) -> tuple[list[str], bool]:
    """Name of every column, and whether this line has them."""
    if any(";" in field for field in fields):
        raise FormatError(
            f"{where}: separate numbers by commas or blanks, not by ';', and write decimals with a"
            " point (0.35)"
        )
    if not all(field and not field[0].isdigit() and field[0] not in "+-." for field in fields):
        if len(fields) == len(PLACE):
            return [*PLACE], False
        raise FormatError(
            f"{where}: {len(fields)} numbers, expected x y z in metres, with decimal points;"
            " further columns need a first line that names them"
        )
    if any(field.lower() in ("nan", "inf", "infinity") for field in fields):
        raise FormatError(f"{where}: a target is 3 finite numbers of metres")
    turns = [group for group in (POINTING, TURNED) if not {*group} & {*joints}]
    known = {*PLACE, *(name for group in turns for name in group)}
    names = [field.lower() if field.lower() in known else field for field in fields]
    further = [group for group in (*turns, joints) if {*group} & {*names}]
    wanted = [*PLACE, *(name for group in further for name in group)]
    if misfit := _misfit(names, wanted):
        raise FormatError(
            f"{where}: {misfit}; columns are x, y, z, with or without px, py, pz or roll, pitch,"
            f" yaw, with or without all joints of the arm ({', '.join(joints)})"
        )
    if POINTING in further and TURNED in further:
        raise FormatError(f"{where}: a hand points (px, py, pz) or is turned (roll, pitch, yaw)")
    return names, True


def _misfit(names: list[str], wanted: list[str]) -> str:
    """What of the names of columns is missing, unknown or there twice."""
    found = {
        "is missing": [name for name in wanted if name not in names],
        "is unknown": [name for name in dict.fromkeys(names) if name not in wanted],
        "is there twice": sorted({name for name in names if names.count(name) > 1}),
    }
    return "; ".join(f"{', '.join(odd)[:100]} {what}" for what, odd in found.items() if odd)


def _number(where: str, text: str) -> float:
    value = math.nan
    if text.isascii() and "_" not in text:  # float() also takes '1_000' and digits of other scripts
        try:
            value = float(text)
        except ValueError:
            raise FormatError(f"{where}: '{text[:40]}' is not a number") from None
    if not math.isfinite(value):
        raise FormatError(f"{where}: '{text[:40]}' is not a finite number")
    if abs(value) > FARTHEST:
        raise FormatError(f"{where}: '{text[:40]}' is beyond {FARTHEST:g}")
    return value
