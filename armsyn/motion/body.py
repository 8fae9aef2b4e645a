"""The motion of a whole skeleton: a root that moves and turns, and joints that turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armsyn.errors import FormatError, InputError
from armsyn.kinematics.skeleton import Skeleton
from armsyn.motion.motion import FloatArray, Motion


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """A skeleton's motion sampled in time.

    Parameters
    ----------
    time : array, shape (frames,)
        Seconds, finite and strictly increasing; at least two frames.
    skeleton : Skeleton
        z is up in the frame that its root stands in.
    rotations : array, shape (frames, joints, 3)
        Exponential maps, rad; the root's is its orientation.
    root : array, shape (frames, 3)
        Position of the root, m.
    translations : array, shape (frames, joints, 3) or None
        What joints are moved by beyond their offsets, in their parent's frame, m.
    source : str
        Where it comes from, for people.

    Raises
    ------
    FormatError
        When the parts do not fit each other, are not finite, or time does not increase.
    """

    time: FloatArray
    skeleton: Skeleton
    rotations: FloatArray
    root: FloatArray
    translations: FloatArray | None = None
    source: str = ""

    def __post_init__(self) -> None:
        frames = np.shape(self.time)[0] if np.ndim(self.time) == 1 else 0
        joints = (frames, self.skeleton.joints, 3)
        for part, shape in (
            *(("rotations", joints), ("root", (frames, 3)), ("translations", joints)),
        ):
            values = getattr(self, part)
            if values is None:
                continue
            array = np.array(values, dtype=np.float64)
            if array.shape != shape or not np.isfinite(array).all():
                raise FormatError(
                    f"{self.source or 'body motion'}: {part} of shape {array.shape}, expected"
                    f" finite ones of shape {shape}"
                )
            array.flags.writeable = False
            object.__setattr__(self, part, array)
        # A motion's own checks of time, once
        checked = Motion(self.time, ("",), np.zeros((frames, 1)), source=self.source)
        object.__setattr__(self, "time", checked.time)

    @property
    def frames(self) -> int:
        """Number of frames."""
        return int(self.time.size)

    def positions(self) -> FloatArray:
        """Global positions of every joint, shape (frames, joints, 3), m."""
        return self.skeleton.positions(self.root, self.rotations, self.translations)

    def as_motion(self, names: Sequence[str] | None = None) -> Motion:
        """Return the joints' positions as the landmarks of a motion.

        Parameters
        ----------
        names : sequence of str, optional
            Joints to keep, in this order: the end effector last. All by default.

        Returns
        -------
        Motion

        Raises
        ------
        InputError
            When the skeleton has no such joint.
        """
        kept = list(self.skeleton.names if names is None else names)
        if not kept:
            raise InputError(f"{self.source or 'body motion'}: no joint is named to keep")
        columns = [self.skeleton.index(name) for name in kept]
        return Motion(
            time=self.time,
            landmark_names=tuple(kept),
            landmarks=self.positions()[:, columns],
            source=self.source,
        )

    def between(self, first: int, last: int) -> BodyMotion:
        """Return the frames `first` to `last`, both included, time starting at zero.

        Raises
        ------
        FormatError
            When fewer than two frames remain.
        """
        kept = slice(first, last + 1)
        time = self.time[kept]
        if time.size < 2:
            raise FormatError(f"{self.source or 'body motion'}: no two frames in {first}..{last}")
        moved = None if self.translations is None else self.translations[kept]
        return BodyMotion(
            time - time[0], self.skeleton, self.rotations[kept], self.root[kept], moved, self.source
        )
