"""The one container that every motion travels in: captured, planned or recorded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import FormatError

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

SHORTEST_STEP = 1e-9
"""s; a shorter step between frames is damage: rates and speeds over it would not be numbers."""
LONGEST_STEP = 1e9
"""s; 30 years."""
FARTHEST = 1e6
"""m; no position is farther from the origin."""


@dataclass(frozen=True)
class Motion:
    """A motion sampled in time: joint angles, landmark positions, or both.

    Parameters
    ----------
    time : array, shape (frames,)
        Seconds, finite and strictly increasing, by `SHORTEST_STEP` to `LONGEST_STEP`; at
        least two frames.
    joint_names : tuple of str
        One a column of `angles`; empty when there are none.
    angles : array, shape (frames, joints) or None
        Radians (metres for prismatic joints); never infinite.
    landmark_names : tuple of str
        One a landmark, the end effector last; empty when there are none.
    landmarks : array, shape (frames, landmarks, 3) or None
        Metres, in one fixed frame, within `FARTHEST`. NaN marks a gap.
    source : str
        Where it comes from, for people: file, recording, port.
    filled : array of bool, shape (frames, landmarks) or None
        Where a position was not captured but filled in; None when none was.

    Raises
    ------
    FormatError
        When the parts do not fit each other, time does not increase, or a number is out of range.
    """

    time: FloatArray
    joint_names: tuple[str, ...] = ()
    angles: FloatArray | None = None
    landmark_names: tuple[str, ...] = ()
    landmarks: FloatArray | None = None
    source: str = ""
    filled: BoolArray | None = None

    def __post_init__(self) -> None:
        time = _frozen_array(self.time)
        object.__setattr__(self, "time", time)
        if time.ndim != 1 or time.size < 2 or not np.isfinite(time).all():
            raise FormatError(
                f"{self.source or 'motion'}: time must be at least two finite numbers of seconds"
            )
        self._check_steps(time)
        if self.angles is None and self.landmarks is None:
            raise FormatError(f"{self.source or 'motion'}: neither joint angles nor landmarks")
        self._check_part("angles", self.joint_names, 2)
        self._check_part("landmarks", self.landmark_names, 3)
        self._check_filled()

    def _check_steps(self, time: FloatArray) -> None:
        with np.errstate(over="ignore"):
            steps = np.diff(time)
        if not (steps > 0).all():
            frame = int(np.argmin(steps > 0)) + 1
            raise FormatError(f"{self.source or 'motion'}: time does not increase at frame {frame}")
        within = (steps >= SHORTEST_STEP) & (steps <= LONGEST_STEP)
        if not within.all():
            frame = int(np.argmin(within)) + 1
            raise FormatError(
                f"{self.source or 'motion'}: time increases by {steps[frame - 1]:g} s at frame"
                f" {frame}, expected {SHORTEST_STEP:g} to {LONGEST_STEP:g} s"
            )

    def _check_part(self, part: str, names: tuple[str, ...], dimensions: int) -> None:
        values = getattr(self, part)
        if values is None:
            if names:
                raise FormatError(f"{self.source or 'motion'}: names of {part} without {part}")
            return
        array = _frozen_array(values)
        object.__setattr__(self, part, array)
        expected = (self.time.size, len(names)) + ((3,) if dimensions == 3 else ())
        if array.shape != expected:
            raise FormatError(
                f"{self.source or 'motion'}: {part} have shape {array.shape}, expected {expected}"
            )
        if len(set(names)) != len(names):
            raise FormatError(f"{self.source or 'motion'}: names of {part} are not unique: {names}")
        outside = np.isinf(array) if dimensions == 2 else np.abs(array) > FARTHEST
        if outside.any():
            frame, column = (int(place) for place in np.argwhere(outside)[0, :2])
            limit = "finite ones" if dimensions == 2 else f"{FARTHEST:g} m at most"
            raise FormatError(
                f"{self.source or 'motion'}: {part} of '{names[column][:40]}' at frame {frame} are"
                f" {array[outside][0]:g}, expected {limit}"
            )

    def _check_filled(self) -> None:
        if self.filled is None:
            return
        filled = np.array(self.filled, dtype=np.bool_)
        if self.landmarks is None or filled.shape != self.landmarks.shape[:2]:
            raise FormatError(
                f"{self.source or 'motion'}: marks of what was filled have shape {filled.shape},"
                " expected one a frame and landmark"
            )
        filled.flags.writeable = False
        object.__setattr__(self, "filled", filled if filled.any() else None)

    @property
    def frames(self) -> int:
        """Number of frames."""
        return int(self.time.size)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return float(self.time[-1] - self.time[0])

    @property
    def rate(self) -> float:
        """Mean frame rate, Hz."""
        return (self.frames - 1) / self.duration

    @property
    def hand(self) -> FloatArray:
        """Positions of the end effector, the last landmark, shape (frames, 3), m.

        Raises
        ------
        FormatError
            When the motion has no landmarks.
        """
        if self.landmarks is None:
            raise FormatError(f"{self.source or 'motion'}: no landmark positions, only angles")
        return self.landmarks[:, -1]

    def between(self, first: int, last: int) -> Self:
        """Return the frames `first` to `last`, both included, time starting at zero.

        Raises
        ------
        FormatError
            When fewer than two frames remain.
        """
        kept = slice(first, last + 1)
        time = self.time[kept]
        if time.size < 2:
            raise FormatError(f"{self.source or 'motion'}: no two frames in {first}..{last}")
        return type(self)(
            time=time - time[0],
            joint_names=self.joint_names,
            angles=None if self.angles is None else self.angles[kept],
            landmark_names=self.landmark_names,
            landmarks=None if self.landmarks is None else self.landmarks[kept],
            source=self.source,
            filled=None if self.filled is None else self.filled[kept],
        )


def _frozen_array(values: ArrayLike) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array
