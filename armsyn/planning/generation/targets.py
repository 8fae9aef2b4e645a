"""Where the reaches go: a file's targets, a grid's, or random ones, each known by its index."""

from __future__ import annotations

import array
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import FormatError, InputError
from armsyn.planning.generation.chance import uniform
from armsyn.planning.hull import Hull

FloatArray = NDArray[np.float64]

LONGEST_LINE = 10_000
FARTHEST_M = 20.0
"""No arm is as long: when every target is beyond, other units than metres are meant."""
TRIES = 16
"""Places that are drawn for a random target; the first inside the captured workspace is taken."""


class Targets(Protocol):
    """Targets by index."""

    @property
    def size(self) -> int:
        """How many."""

    def some(self, first: int, last: int) -> tuple[FloatArray, FloatArray | None]:
        """Return targets `first` to `last`, which is not included.

        Returns
        -------
        targets : array, shape (m, 3)
            Base frame, m.
        starts : array, shape (m, n), or None
            The postures to start from, rad or m; None for the arm's own.
        """


@dataclass(frozen=True)
class ListedTargets:
    """Targets as they stand in a file.

    Parameters
    ----------
    targets : array, shape (N, 3)
        m.
    starts : array, shape (N, n), or None
        rad or m.
    """

    targets: FloatArray
    starts: FloatArray | None = None

    @property
    def size(self) -> int:
        """How many."""
        return len(self.targets)

    def some(self, first: int, last: int) -> tuple[FloatArray, FloatArray | None]:
        """See `Targets.some`."""
        return self.targets[first:last], None if self.starts is None else self.starts[first:last]


@dataclass(frozen=True)
class GridTargets:
    """Every combination of places along x, y and z; z changes fastest.

    Parameters
    ----------
    axes : 3-tuple of (float, float, int)
        First and last place, m, and how many.
    """

    axes: tuple[tuple[float, float, int], ...]

    @property
    def size(self) -> int:
        """How many."""
        return math.prod(count for _, _, count in self.axes)

    def some(self, first: int, last: int) -> tuple[FloatArray, None]:
        """See `Targets.some`."""
        places = np.unravel_index(np.arange(first, last), [count for _, _, count in self.axes])
        # not by linspace, which makes a whole line for the few places of it that are asked for
        parts = [
            np.where(
                at == count - 1, high if count > 1 else low, low + at * _step(low, high, count)
            )
            for (low, high, count), at in zip(self.axes, places, strict=True)
        ]
        return np.stack(parts, axis=1), None


def _step(first: float, last: float, count: int) -> float:
    return (last - first) / max(count - 1, 1)


@dataclass(frozen=True)
class RandomTargets:
    """Places drawn evenly from a box, or from a hull inside it.

    Parameters
    ----------
    size : int
    seed : int
    lower, upper : array_like, shape (3,)
        m.
    hull : Hull or None
        The captured workspace. Where `TRIES` places miss it, the last of them is taken.
    """

    size: int
    seed: int
    lower: ArrayLike
    upper: ArrayLike
    hull: Hull | None = None

    def some(self, first: int, last: int) -> tuple[FloatArray, None]:
        """See `Targets.some`; a target depends on seed and index only."""
        tries = TRIES if self.hull is not None else 1
        drawn = uniform(self.seed, "targets", first, last, 3 * tries).reshape(-1, tries, 3)
        lower, upper = np.asarray(self.lower), np.asarray(self.upper)
        places = lower + drawn * (upper - lower)
        chosen = np.full(last - first, tries - 1)
        if self.hull is not None:
            left = np.arange(last - first)
            for row in range(tries - 1):
                inside = _within(self.hull, places[left, row])
                chosen[left[inside]] = row
                left = left[~inside]
        return places[np.arange(last - first), chosen], None


def _within(hull: Hull, points: FloatArray) -> NDArray[np.bool_]:
    """Which points, shape (m, 3), lie behind all faces of a hull: cheaper than how far outside."""
    behind: NDArray[np.bool_] = points @ hull.planes[:, :3].T <= -hull.planes[:, 3]
    return np.asarray(behind.all(axis=1))


def random_within(size: int, seed: int, hull: Hull) -> RandomTargets:
    """Draw places from a hull; see `RandomTargets`."""
    corners = hull.triangles.reshape(-1, 3)
    return RandomTargets(size, seed, corners.min(axis=0), corners.max(axis=0), hull)


def checked_box(texts: Sequence[str]) -> tuple[list[float], list[float]]:
    """Read FIRST:LAST (m) for x, y and z; return the box's corners.

    Raises
    ------
    InputError
        Anything else.
    """
    ends = []
    for text in texts:
        low, high, _ = checked_axis(f"{text}:1" if text.count(":") == 1 else text)
        ends.append((low, high))
        if text.count(":") > 1 or not low <= high:
            raise InputError(f"'{text[:40]}' is no FIRST:LAST of metres, such as -0.1:0.3")
    return [low for low, _ in ends], [high for _, high in ends]


def checked_axis(text: str) -> tuple[float, float, int]:
    """Read FIRST:LAST:COUNT (m), or one place.

    Raises
    ------
    InputError
        Anything else.
    """
    parts = text.split(":")
    try:
        first, last, number = parts if len(parts) > 1 else (text, text, "1")
        low, high, count = float(first), float(last), int(number)
    except ValueError:
        raise InputError(
            f"'{text[:40]}' is no FIRST:LAST:COUNT of metres, such as 0.2:0.5:7, nor one place"
        ) from None
    if not (math.isfinite(low) and math.isfinite(high)) or count < 1:
        raise InputError(f"'{text[:40]}' must be finite places, and one at least")
    return low, high, count


def read_targets(path: Path, joints: tuple[str, ...]) -> ListedTargets:
    """Read a file of targets: x, y, z in metres in every line, by commas or blanks.

    Empty lines and what follows a ``#`` count for nothing. A first line may name the columns: x, y
    and z, and, to start elsewhere than the arm's rest posture, all of its joints (rad or m).

    Parameters
    ----------
    path : Path
    joints : tuple of str
        Of the arm.

    Returns
    -------
    ListedTargets

    Raises
    ------
    FormatError
        When it cannot be read, or a line is not as above: the message has its number.
    """
    columns: list[int] | None = None
    numbers = array.array("d")
    for number, fields in _lines(path):
        where = f"{path}, line {number}"
        if columns is None:
            columns, is_header = _columns(where, fields, joints)
            if is_header:
                continue
        if len(fields) != len(columns):
            raise FormatError(f"{where}: {len(fields)} numbers, expected {len(columns)}")
        numbers.extend(_number(where, fields[column]) for column in columns)
    if not numbers or columns is None:
        raise FormatError(f"{path}: no targets in it")
    table = np.frombuffer(numbers, dtype=np.float64).reshape(-1, len(columns))
    if (nearest := float(np.abs(table[:, :3]).max(axis=1).min())) > FARTHEST_M:
        raise FormatError(
            f"{path}: the nearest target is {nearest:g} m away: targets are metres, these look like"
            " millimetres or centimetres"
        )
    return ListedTargets(table[:, :3], table[:, 3:] if len(columns) > 3 else None)


def _lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Number and fields of every line that says something."""
    try:
        with path.open(encoding="utf-8-sig") as file:
            for number, line in enumerate(iter(lambda: file.readline(LONGEST_LINE), ""), 1):
                if len(line) == LONGEST_LINE and not line.endswith("\n"):
                    raise FormatError(f"{path}, line {number}: longer than any line of targets")
                said = line.partition("#")[0].strip()
                if said:
                    yield (
                        number,
                        said.replace(",", " ").split()
                        if "," not in said
                        else [field.strip() for field in said.split(",")],
                    )
    except OSError as error:
        raise FormatError(f"{path}: cannot read it: {error.strerror}") from error
    except UnicodeDecodeError:
        raise FormatError(f"{path}: not a text file of targets") from None


def _columns(where: str, fields: list[str], joints: tuple[str, ...]) -> tuple[list[int], bool]:
    """Column of x, y, z and of every joint, and whether this line names them."""
    if any(";" in field for field in fields):
        raise FormatError(
            f"{where}: separate numbers by commas or blanks, not by ';', and write decimals with a"
            " point (0.35)"
        )
    if not all(field and not field[0].isdigit() and field[0] not in "+-." for field in fields):
        if len(fields) == 3:
            return [0, 1, 2], False
        raise FormatError(
            f"{where}: {len(fields)} numbers, expected x y z in metres, with decimal points;"
            " further columns need a first line that names them"
        )
    if any(field.lower() in ("nan", "inf", "infinity") for field in fields):
        raise FormatError(f"{where}: a target is 3 finite numbers of metres")
    names = [field.lower() if field.lower() in ("x", "y", "z") else field for field in fields]
    wanted = ["x", "y", "z", *joints] if len(names) > 3 else ["x", "y", "z"]
    if sorted(names) != sorted(wanted):
        raise FormatError(
            f"{where}: {_misfit(names, wanted)}; columns are x, y, z, or those and all joints of"
            f" the arm ({', '.join(joints)})"
        )
    return [names.index(name) for name in wanted], True


def _misfit(names: list[str], wanted: list[str]) -> str:
    """What of the names of columns is missing, unknown or there twice."""
    found = {
        "is missing": [name for name in wanted if name not in names],
        "is unknown": [name for name in dict.fromkeys(names) if name not in wanted],
        "is there twice": sorted({name for name in names if names.count(name) > 1}),
    }
    return "; ".join(f"{', '.join(odd)[:100]} {what}" for what, odd in found.items() if odd)


def _number(where: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise FormatError(f"{where}: '{text[:40]}' is not a number") from None
    if not math.isfinite(value):
        raise FormatError(f"{where}: '{text[:40]}' is not a finite number")
    return value
