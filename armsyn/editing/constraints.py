"""What an edit asks for: places, paths, orientations and pins, each on a priority level.

Level 1 is met first; the next levels do what they can without disturbing it. Frames are the
clip's own, from 0; a negative one counts from the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.editing.figure import Effector
from armsyn.errors import ConstraintError
from armsyn.kinematics.rotation import checked_rotation

FloatArray = NDArray[np.float64]
Triple = tuple[float, float, float]


FARTHEST_M = 1e4
"""A goal farther than this from the origin is a mistake, m."""


def _check(effector: Effector, level: int, axes: str = "xyz") -> None:
    if not isinstance(effector, Effector):
        raise ConstraintError(f"{effector!r} is not an Effector: name a body and a point on it")
    if not isinstance(level, int) or level < 1:
        raise ConstraintError(f"{effector}: level {level}: the first priority is 1")
    if not axes or set(axes) - set("xyz") or len(set(axes)) != len(axes):
        raise ConstraintError(f"{effector}: axes '{axes}': some of x, y and z")


def _check_triple(effector: Effector, value: Triple | None, what: str) -> None:
    if value is None:
        return
    # Not within: NaN is not, either
    if np.shape(value) != (3,) or not (np.abs(value) <= FARTHEST_M).all():
        raise ConstraintError(
            f"{effector}: {what} is three finite numbers within {FARTHEST_M:g}, not {value}"
        )


@dataclass(frozen=True)
class KeyFrame:
    """A point of a body at one frame.

    Parameters
    ----------
    effector : Effector
    frame : int
    position : 3-tuple of float, optional
        Where it shall be, m.
    by : 3-tuple of float, optional
        What it shall be moved by instead, from where the clip has it, m.
    level : int
    axes : str
        The global axes that count, such as ``z`` for a height.
    """

    effector: Effector
    frame: int
    position: Triple | None = None
    by: Triple | None = None
    level: int = 1
    axes: str = "xyz"

    def __post_init__(self) -> None:
        _check(self.effector, self.level, self.axes)
        _check_triple(self.effector, self.position, "a position")
        _check_triple(self.effector, self.by, "a displacement")
        if (self.position is None) == (self.by is None):
            raise ConstraintError(f"{self.effector}: give a key-frame either position (to) or by")


@dataclass(frozen=True, eq=False)
class Orientation:
    """How a body is turned at one frame.

    Parameters
    ----------
    effector : Effector
        Its point does not matter.
    frame : int
    rotation : array, shape (3, 3), optional
        Global.
    by : 3-tuple of float, optional
        Exponential map of what it shall be turned by instead, global axes, rad.
    level : int
    """

    effector: Effector
    frame: int
    rotation: FloatArray | None = None
    by: Triple | None = None
    level: int = 1

    def __post_init__(self) -> None:
        _check(self.effector, self.level)
        _check_triple(self.effector, self.by, "a turn")
        if (self.rotation is None) == (self.by is None):
            raise ConstraintError(
                f"{self.effector}: give an orientation either rotation (to_deg) or by (by_deg)"
            )
        if self.rotation is not None:
            object.__setattr__(self, "rotation", checked_rotation(self.rotation))


@dataclass(frozen=True)
class Pin:
    """A point that stays where the clip has it.

    Parameters
    ----------
    effector : Effector
    frames : sequence of int, or None
        At which; all by default.
    level : int
    axes : str
    turned : bool
        Whether its body's orientation stays, too.
    """

    effector: Effector
    frames: Sequence[int] | None = None
    level: int = 1
    axes: str = "xyz"
    turned: bool = False

    def __post_init__(self) -> None:
        _check(self.effector, self.level, self.axes)
        if self.frames is not None and not len(self.frames):
            raise ConstraintError(f"{self.effector}: a pin needs frames")


class Key(NamedTuple):
    """One key of a trajectory: a frame, and a position or displacement, m."""

    frame: int
    value: Triple


@dataclass(frozen=True)
class KeyTrajectory:
    """A path of a point: a Kochanek-Bartels spline through keys, eased in before and out after.

    Parameters
    ----------
    effector : Effector
    keys : tuple of Key
        In order of their frames.
    relative : bool
        Whether keys are displacements from where the clip has the point.
    ease_in, ease_out : int
        Frames before the first and after the last key over which 3 u^2 - 2 u^3 leads there and
        back to the clip.
    tension, continuity, bias : float
        In [-1, 1].
    level : int
    axes : str
    """

    effector: Effector
    keys: tuple[Key, ...]
    relative: bool = False
    ease_in: int = 0
    ease_out: int = 0
    tension: float = 0.0
    continuity: float = 0.0
    bias: float = 0.0
    level: int = 1
    axes: str = "xyz"

    def __post_init__(self) -> None:
        _check(self.effector, self.level, self.axes)
        object.__setattr__(self, "keys", tuple(Key(*key) for key in self.keys))
        if not self.keys:
            raise ConstraintError(f"{self.effector}: a trajectory needs keys")
        for key in self.keys:
            _check_triple(self.effector, key.value, "a key")
        if self.ease_in < 0 or self.ease_out < 0:
            raise ConstraintError(f"{self.effector}: ease windows are frames, not negative")


Constraint = KeyFrame | KeyTrajectory | Orientation | Pin


@dataclass(frozen=True, eq=False)
class Task:
    """One goal at one frame, in numbers.

    Parameters
    ----------
    constraint : int
        Which of the constraints it is of.
    label : str
        Of that constraint, for people.
    level : int
    frame : int
    body : int
    point : array, shape (3,)
        In the body's frame, m.
    goal : array, shape (3,) or (3, 3)
        Position, m, or orientation; both global.
    rows : array of int
        Of the position's three that count; an orientation's all do.
    """

    constraint: int
    label: str
    level: int
    frame: int
    body: int
    point: FloatArray
    goal: FloatArray
    rows: NDArray[np.int64] = field(default_factory=lambda: np.arange(3))

    @property
    def turning(self) -> bool:
        """Whether it is an orientation."""
        return self.goal.ndim == 2
