"""Where the reaches go: listed targets, a grid's, or random ones, each known by its index."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.planning.checking import FARTHEST
from armsyn.planning.generation.chance import uniform
from armsyn.planning.hull import Hull
from armsyn.planning.posing import HandOrientation

FloatArray = NDArray[np.float64]

TRIES = 16
"""Places that are drawn for a random target; the first inside the captured workspace is taken."""


class Asked(NamedTuple):
    """What is asked of some reaches.

    Attributes
    ----------
    targets : array, shape (m, 3)
        Base frame, m.
    starts : array, shape (m, n), or None
        The postures to start from, rad or m; None for one that all share.
    orientations : sequence of m HandOrientation, or None
        How the hands are to be turned at the end; None for what is asked of all, if anything.
    """

    targets: FloatArray
    starts: FloatArray | None = None
    orientations: Sequence[HandOrientation] | None = None


class Targets(Protocol):
    """Targets by index."""

    @property
    def size(self) -> int:
        """How many."""

    def some(self, first: int, last: int) -> Asked:
        """Return targets `first` to `last`, which is not included."""


@dataclass(frozen=True)
class ListedTargets:
    """Targets as they stand in a file.

    Parameters
    ----------
    targets : array, shape (N, 3)
        m.
    starts : array, shape (N, n), or None
        rad or m.
    turns : array, shape (N, 3), or None
        Of each a direction or angles, as `turned_by` takes them.
    turned_by : callable or None
        From a row of `turns` to what is asked of the hand.
    """

    targets: FloatArray
    starts: FloatArray | None = None
    turns: FloatArray | None = None
    turned_by: Callable[[FloatArray], HandOrientation] | None = None

    @property
    def size(self) -> int:
        """How many."""
        return len(self.targets)

    def some(self, first: int, last: int) -> Asked:
        """See `Targets.some`."""
        turned = None
        if self.turns is not None and self.turned_by is not None:
            turned = [self.turned_by(turn) for turn in self.turns[first:last]]
        starts = None if self.starts is None else self.starts[first:last]
        return Asked(self.targets[first:last], starts, turned)


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

    def some(self, first: int, last: int) -> Asked:
        """See `Targets.some`."""
        places = np.unravel_index(np.arange(first, last), [count for _, _, count in self.axes])
        # not by linspace, which makes a whole line for the few places of it that are asked for
        parts = [
            np.where(
                at == count - 1, high if count > 1 else low, low + at * _step(low, high, count)
            )
            for (low, high, count), at in zip(self.axes, places, strict=True)
        ]
        return Asked(np.stack(parts, axis=1))


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

    def some(self, first: int, last: int) -> Asked:
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
        return Asked(places[np.arange(last - first), chosen])


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
    if not (abs(low) <= FARTHEST and abs(high) <= FARTHEST) or count < 1:
        raise InputError(f"'{text[:40]}' must be places within {FARTHEST:g} m, and one at least")
    return low, high, count
