"""The several movements that one recording holds, such as a reach and its way back."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from armsyn.errors import InputError
from armsyn.motion import Motion
from armsyn.motion.filtering import CUTOFF, hand_speed
from armsyn.motion.movements import spans
from armsyn.motion.segmentation import CUT_FRACTION, movement_times


class Bout(NamedTuple):
    """One movement of a recording and the rests around it."""

    onset: float
    """s, on the recording's clock."""
    offset: float
    begin: float
    """s; half-way into the rest before, or where the recording begins."""
    end: float


def bouts(
    motion: Motion, *, cutoff: float | None = CUTOFF, fraction: float = CUT_FRACTION
) -> list[Bout]:
    """Find the movements of a recording in its hand's filtered speed.

    Parameters
    ----------
    motion : Motion
        With landmarks.
    cutoff : float or None
        Hz, of the low-pass.
    fraction : float
        Of a movement's peak speed, at which it begins and ends.

    Returns
    -------
    list of Bout
        In time's order; one at least.

    Raises
    ------
    FormatError, InputError, CaptureError
        As `armsyn.motion.filtering.hand_speed`.
    """
    profile = hand_speed(motion.time, motion.hand, cutoff=cutoff)
    parts = [slice(first, last + 1) for first, last in spans(profile, fraction)]
    times = [movement_times(profile.time[part], profile.speed[part], fraction) for part in parts]
    return _with_rests(times, motion)


def only_movement(
    motion: Motion,
    number: int,
    *,
    cutoff: float | None = CUTOFF,
    fraction: float = CUT_FRACTION,
) -> Motion:
    """Return one movement of a recording with half of the rests around it.

    Parameters
    ----------
    motion : Motion
        With landmarks.
    number : int
        From 1.
    cutoff, fraction : float
        As in `bouts`.

    Returns
    -------
    Motion
        Its time starts at zero.

    Raises
    ------
    InputError
        When there is no such movement, and as `bouts`.
    """
    found = bouts(motion, cutoff=cutoff, fraction=fraction)
    if not 1 <= number <= len(found):
        held = ", ".join(f"{one.onset:.2f}-{one.offset:.2f} s" for one in found) or "none"
        raise InputError(
            f"{motion.source or 'motion'}: no movement {number}; it holds {len(found)}: {held}"
        )
    chosen = found[number - 1]
    inside = np.flatnonzero((motion.time >= chosen.begin) & (motion.time <= chosen.end))
    return motion.between(int(inside[0]), int(inside[-1]))


def _with_rests(times: list[tuple[float, float]], motion: Motion) -> list[Bout]:
    middles = [(before[1] + after[0]) / 2 for before, after in itertools.pairwise(times)]
    ends = [float(motion.time[0]), *middles, float(motion.time[-1])]
    return [Bout(*pair, *ends[place : place + 2]) for place, pair in enumerate(times)]
