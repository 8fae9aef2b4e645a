"""Whether an arm touches itself, a plane or a box: in one posture, and anywhere along a path.

Between two postures of a path nothing moves further against anything else than the joints' steps
times `Solids.reach`. So a step is free where the clearances at its ends sum up to more than that
(the idea of conservative advancement: Mirtich, *Impulse-based dynamic simulation*, 1996, 2.3);
other steps are halved until they are, or until nothing moves by more than `RESOLUTION`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.arm.solids import Solids
from armsyn.errors import CollisionError, InputError

FloatArray = NDArray[np.float64]

MARGIN = 0.005
"""m that a planned path keeps between what must not touch."""

TICK_MARGIN = 0.002
"""m that commands keep: they are interpolated, and may be blended, between checked postures."""

RESOLUTION = 2e-4
"""m of motion between two postures that is not looked into any further."""

LEAVING = 0.001
"""m by which a path may deepen a contact that it starts in."""


class Closest(NamedTuple):
    """The nearest two of what is judged.

    Attributes
    ----------
    first, second : str
        A link by its joint's name; then a link, ``base``, a plane or a box.
    distance : float
        m; below zero the depth of one in the other.
    frame : int
        Row of the path.
    """

    first: str
    second: str
    distance: float
    frame: int


@dataclass(frozen=True)
class Clearances:
    """What every posture must keep.

    Parameters
    ----------
    solids : Solids
    required : array, shape (k,)
        Clearance of each pair, m; below zero for one that may stay in contact.
    margin : float
        What is required of pairs that start free, m.
    """

    solids: Solids
    required: FloatArray
    margin: float

    @classmethod
    def of(
        cls, arm: ArmDescription, margin: float = MARGIN, start: ArrayLike | None = None
    ) -> Self:
        """Clearances of an arm: the margin, or what its rest posture leaves if that is less.

        Parameters
        ----------
        arm : ArmDescription
        margin : float
            m.
        start : array_like, shape (n,) or (m, n), optional
            Where the arm is, rad, by one or several accounts: what is nearer than the margin there
            may stay as near, so that an arm can leave a contact; it must not get more than
            `LEAVING` deeper.

        Returns
        -------
        Clearances

        Raises
        ------
        InputError
            A margin that is not finite, a posture of another arm, or shapes that touch at rest.
        """
        if not np.isfinite(margin):
            raise InputError(f"a margin must be finite, got {margin:g} m")
        solids = arm.solids
        required = np.minimum(margin, solids.at_rest)
        if start is not None:
            postures = _checked_path(np.atleast_2d(np.asarray(start, dtype=np.float64)), arm)
            there = solids.clearances(postures) - LEAVING
            required = np.minimum(required, there.min(axis=0, initial=np.inf))
        return cls(solids, required, margin)

    def broken_by(self, posture: FloatArray) -> CollisionError | None:
        """Whether a posture, shape (n,), rad, is too near to something; NaN is.

        Cheap enough for every tick of a stream.
        """
        found = self.solids.clearances(posture[None])
        slack = found[0] - self.required
        if (slack >= 0.0).all():
            return None
        pair = int(np.argmin(slack))
        return self.error(pair, float(found[0, pair]), 0)

    def error(
        self, pair: int, nearest: float, frame: int, time_s: float | None = None
    ) -> CollisionError:
        """Return the refusal of a path by what is too near.

        Parameters
        ----------
        pair : int
            Of `armsyn.arm.solids.Solids.names`.
        nearest : float
            Least clearance from there on, m.
        frame : int
            At or before which the path gets too near.
        time_s : float, optional
            When, for the message.
        """
        first, second = self.solids.names[pair]
        when = "" if time_s is None else f" from {time_s:.3f} s"
        what = (
            f"would be {-nearest:.4f} m inside {second}"
            if nearest < 0.0
            else f"would come {nearest * 1e3:.1f} mm near to {second}"
        )
        kept = f", {float(self.required[pair]) * 1e3:z.1f} mm must stay" if nearest >= 0.0 else ""
        return CollisionError(
            f"{first} {what}{when}{kept}: choose another way, or mend the shapes of the arm",
            first,
            second,
            frame,
            -nearest,
        )


def check_collision(
    angles: ArrayLike,
    arm: ArmDescription,
    margin: float = MARGIN,
    *,
    time: FloatArray | None = None,
    leaving: bool = False,
) -> CollisionError | None:
    """Whether an arm touches itself or something around it anywhere along a path.

    Between samples every joint is taken to go straight from one to the next.

    Parameters
    ----------
    angles : array_like, shape (frames, n)
        rad or m; one row is a posture.
    arm : ArmDescription
    margin : float
        What counts as touching, m.
    time : array, shape (frames,), optional
        Of the frames, s, for the message.
    leaving : bool
        Whether a contact at the start is allowed as long as it does not get deeper.

    Returns
    -------
    CollisionError or None
        The pair that touches first, where, and how deep it gets.

    Raises
    ------
    InputError
        Not a path of this arm, not finite, or shapes that touch at rest.
    """
    path = _checked_path(angles, arm)
    clearances = Clearances.of(arm, margin, path[0] if leaving and len(path) else None)
    found = clearances.solids.clearances(path)
    frame = _first_contact(path, found, clearances)
    if frame is None:
        return None
    # what lies between two samples is nearest at one of them, by a hair
    row = int(np.ceil(frame))
    before = int(frame)
    here = path[before] + (frame - before) * (path[row] - path[before])
    exact = clearances.solids.clearances(np.ascontiguousarray(here[None]))
    pair = int(np.argmin(exact[0] - clearances.required))
    when = None if time is None else float(np.interp(frame, range(len(path)), time))
    nearest = float(min(found[before:, pair].min(), exact[0, pair]))
    return clearances.error(pair, nearest, before, when)


def closest(angles: ArrayLike, arm: ArmDescription) -> Closest | None:
    """Return the nearest two of all that must not touch, over the samples of a path.

    Parameters
    ----------
    angles : array_like, shape (n,) or (frames, n)
        A posture or a path, rad or m.
    arm : ArmDescription

    Returns
    -------
    Closest or None
        None for an arm of which nothing is judged.

    Raises
    ------
    InputError
        As `check_collision`.
    """
    path = _checked_path(np.atleast_2d(np.asarray(angles, dtype=np.float64)), arm)
    solids = arm.solids
    if not solids.names or not len(path):
        return None
    found = solids.clearances(path)
    frame, pair = divmod(int(np.argmin(found)), found.shape[1])
    first, second = solids.names[pair]
    return Closest(first, second, float(found[frame, pair]), frame)


def _checked_path(angles: ArrayLike, arm: ArmDescription) -> FloatArray:
    path = np.ascontiguousarray(angles, dtype=np.float64)
    if path.ndim != 2 or path.shape[1] != len(arm.joint) or not np.isfinite(path).all():
        raise InputError(f"a path of {arm.name} has {len(arm.joint)} finite columns")
    return path


def _first_contact(path: FloatArray, found: FloatArray, clearances: Clearances) -> float | None:
    """Frame, with a fraction, of the first posture found too near; None when the path is free."""
    slack = found - clearances.required
    broken = np.flatnonzero((slack < 0.0).any(axis=1))
    first = float(broken[0]) if broken.size else None
    last = len(path) if first is None else int(first) + 1
    start, end = path[: last - 1], path[1:last]
    slack_start, slack_end = slack[: last - 1], slack[1:last]
    frame, width = np.arange(len(start), dtype=np.float64), 1.0
    while len(start):
        moved = np.abs(end - start) @ clearances.solids.reach.T
        unsure = ((slack_start + slack_end <= moved) & (moved > RESOLUTION)).any(axis=1)
        start, end, frame = start[unsure], end[unsure], frame[unsure]
        slack_start, slack_end = slack_start[unsure], slack_end[unsure]
        middle = 0.5 * (start + end)
        slack_middle = clearances.solids.clearances(middle) - clearances.required
        width *= 0.5
        if (hit := np.flatnonzero((slack_middle < 0.0).any(axis=1))).size:
            found_at = float(frame[hit].min()) + width
            first = found_at if first is None else min(first, found_at)
        start, end = np.concatenate([start, middle]), np.concatenate([middle, end])
        slack_start = np.concatenate([slack_start, slack_middle])
        slack_end = np.concatenate([slack_middle, slack_end])
        frame = np.concatenate([frame, frame + width])
        if first is not None:
            early = frame < first
            start, end, frame = start[early], end[early], frame[early]
            slack_start, slack_end = slack_start[early], slack_end[early]
    return first
