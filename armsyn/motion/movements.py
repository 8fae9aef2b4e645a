"""The movements that a recording holds: where each begins and ends, and what it measures.

Two movements are parted by a rest, or by a turning back: the hand slows down for a moment only,
and goes on the opposite way.
"""

from __future__ import annotations

import dataclasses
import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armsyn.errors import CaptureError
from armsyn.motion.filtering import CUTOFF, SpeedProfile, hand_speed
from armsyn.motion.motion import FloatArray, Motion
from armsyn.motion.peaks import count_peaks, count_prominent_peaks
from armsyn.motion.segmentation import (
    CUT_FRACTION,
    movement_times,
    moving_runs,
    shortest_rest,
)

LEAST_PATH = 0.1
"""Of the recording's longest movement, that the path of another must have: what a hand trembles or
settles is none."""
TURNING = 0.2
"""Of the lower of two opposite peaks: below it between them, the hand turns back. Captured people
who reach out and back without a rest slow down to 0.01-0.15 of it."""
FEWEST_FRAMES = 5
"""That a hand must be seen on end for its speed to be measured."""


class Movement(NamedTuple):
    """One movement of a recording.

    Attributes
    ----------
    onset, offset : float
        s, on the recording's clock: when the speed crosses the fraction of the movement's own
        peak, or the hand turns, or where the recording (or a gap) cuts it.
    first, last : int
        Frames: the last at or before the onset, the first at or after the offset.
    peak_time, peak_speed : float
        s on the recording's clock, and m/s.
    onset_fraction, offset_fraction : float
        Speeds at both ends over the peak: more than the cut where it begins or ends while moving.
    peaks : int
        By `armsyn.motion.peaks.count_peaks`.
    prominent_peaks : int
        By `armsyn.motion.peaks.count_prominent_peaks`.
    displacement, path : float
        m, of the hand, from onset to offset: straight, and along its way.
    """

    onset: float
    offset: float
    first: int
    last: int
    peak_time: float
    peak_speed: float
    onset_fraction: float
    offset_fraction: float
    peaks: int
    prominent_peaks: int
    displacement: float
    path: float

    @property
    def duration(self) -> float:
        """Seconds from onset to offset."""
        return self.offset - self.onset

    @property
    def time_to_peak(self) -> float:
        """Time from onset to peak as a share of the duration."""
        return (self.peak_time - self.onset) / self.duration


@dataclass(frozen=True)
class ReachRule:
    """What a movement must be to count as a reach.

    Parameters
    ----------
    displacement : float
        m, at least.
    peaks : int
        Prominent ones, at most.
    onset_fraction, offset_fraction : float
        Of the peak speed, at most: a reach begins and ends at rest.
    """

    displacement: float = 0.25
    peaks: int = 2
    onset_fraction: float = 0.25
    offset_fraction: float = 0.15

    def fault(self, movement: Movement, motion: Motion) -> str:
        """Return why a movement is no usable reach; empty when it is one.

        Parameters
        ----------
        movement : Movement
        motion : Motion
            The one that it is of: its other landmarks must be seen, too.

        Returns
        -------
        str
        """
        if movement.displacement < self.displacement:
            return (
                f"{movement.displacement:.3f} m from onset to offset, under {self.displacement:g}"
            )
        if movement.prominent_peaks > self.peaks:
            return f"{movement.prominent_peaks} speed peaks, more than {self.peaks}"
        for what, share, most in (
            ("begins", movement.onset_fraction, self.onset_fraction),
            ("ends", movement.offset_fraction, self.offset_fraction),
        ):
            if share > most:
                return f"{what} while moving, at {share:.2f} of its peak speed, over {most:g}"
        return _gap(movement, motion)


def _gap(movement: Movement, motion: Motion) -> str:
    if motion.landmarks is None:
        return ""
    within = motion.landmarks[movement.first : movement.last + 1]
    unseen = np.argwhere(np.isnan(within).any(axis=2))
    if not unseen.size:
        return ""
    frame, column = unseen[0].tolist()
    return f"{motion.landmark_names[column]} has a gap at frame {movement.first + frame}"


def find_movements(
    time: FloatArray,
    positions: FloatArray,
    *,
    fraction: float = CUT_FRACTION,
    cutoff: float | None = CUTOFF,
) -> list[Movement]:
    """Find the movements of a hand, each with onset and offset.

    Parameters
    ----------
    time : array, shape (frames,)
        Seconds, strictly increasing.
    positions : array, shape (frames, 3)
        m; NaN where the hand was not seen. What is between two gaps is searched by itself.
    fraction : float
        Of a movement's own peak speed, at which it begins and ends.
    cutoff : float or None
        Hz, of the zero-lag Butterworth low-pass on positions.

    Returns
    -------
    list of Movement
        In time's order; one at least.

    Raises
    ------
    InputError, CaptureError
        As `armsyn.motion.filtering.hand_speed` and `onset_and_offset`; CaptureError, too, when the
        hand is never seen for `FEWEST_FRAMES` on end.
    """
    seen = moving_runs(np.asarray(np.isfinite(positions).all(axis=1)))
    found: list[Movement] = []
    for first, last in seen:
        if last - first + 1 >= FEWEST_FRAMES:
            part = slice(first, last + 1)
            profile = hand_speed(time[part], positions[part], cutoff=cutoff, rest=0.0)
            found += [_measured(profile, span, fraction, time) for span in spans(profile, fraction)]
    if not found:
        raise CaptureError("the hand does not move where it is seen: there is no movement to find")
    longest = max(movement.path for movement in found)
    return [movement for movement in found if movement.path >= LEAST_PATH * longest]


def spans(profile: SpeedProfile, fraction: float = CUT_FRACTION) -> list[tuple[int, int]]:
    """Return the stretches of a profile that hold one movement each, with the rests around it.

    Parameters
    ----------
    profile : SpeedProfile
    fraction : float
        Of the profile's peak speed, below which the hand rests.

    Returns
    -------
    list of (int, int)
        First and last sample: where the hand is slowest between two movements.
    """
    level = max(fraction * float(profile.speed.max()), float(np.finfo(np.float64).tiny))
    runs = moving_runs(profile.speed >= level, shortest_rest(profile.time))
    paths = [float(profile.speed[first : last + 1].sum()) for first, last in runs]
    least = LEAST_PATH * max(paths, default=0.0)
    kept = [run for run, path in zip(runs, paths, strict=True) if path >= least]
    cuts = [
        before[1] + int(np.argmin(profile.speed[before[1] : after[0] + 1]))
        for before, after in itertools.pairwise(kept)
    ]
    edges = sorted({0, *cuts, *_turns(profile, kept, least), profile.speed.size - 1})
    return list(itertools.pairwise(edges)) if kept else []


def _turns(profile: SpeedProfile, runs: list[tuple[int, int]], least: float) -> list[int]:
    """Samples at which the hand turns back within a run; the paths on both sides count."""
    velocity = np.gradient(profile.positions, 1 / profile.rate, axis=0)
    found, waiting = [], list(runs)
    while waiting:
        first, last = waiting.pop()
        part = slice(first, last + 1)
        cut = _deepest_turn(profile.speed[part], velocity[part], least)
        if cut is not None:
            found.append(first + cut)
            waiting += [(first, first + cut), (first + cut, last)]
    return found


def _deepest_turn(speed: FloatArray, velocity: FloatArray, least: float) -> int | None:
    """Slowest sample of a dip that the hand enters one way and leaves the opposite way."""
    lower = np.minimum(np.maximum.accumulate(speed), np.maximum.accumulate(speed[::-1])[::-1])
    path = np.cumsum(speed)
    dips = [
        first + int(np.argmin(speed[first : last + 1]))
        for first, last in moving_runs(speed < TURNING * lower)
        if velocity[first - 1] @ velocity[last + 1] < 0
    ]
    turns = [dip for dip in dips if least <= path[dip] <= path[-1] - least]
    return min(turns, key=lambda dip: float(speed[dip]), default=None)


def _measured(
    profile: SpeedProfile, span: tuple[int, int], fraction: float, time: FloatArray
) -> Movement:
    part = slice(span[0], span[1] + 1)
    own = dataclasses.replace(
        profile,
        time=profile.time[part],
        speed=profile.speed[part],
        positions=profile.positions[part],
    )
    onset, offset = movement_times(own.time, own.speed, fraction)
    peak = int(np.argmax(own.speed))
    inside = slice(
        int(np.searchsorted(own.time, onset, side="left")),
        int(np.searchsorted(own.time, offset, side="right")),
    )
    ends = [
        np.array([np.interp(at, own.time, axis) for axis in own.positions.T])
        for at in (onset, offset)
    ]
    way = np.vstack([ends[0], own.positions[inside], ends[1]])
    speed_at = np.interp([onset, offset], own.time, own.speed) / own.speed[peak]
    return Movement(
        onset=onset,
        offset=offset,
        first=max(0, int(np.searchsorted(time, onset + 1e-9, side="right")) - 1),
        last=min(time.size - 1, int(np.searchsorted(time, offset - 1e-9, side="left"))),
        peak_time=float(own.time[peak]),
        peak_speed=float(own.speed[peak]),
        onset_fraction=float(speed_at[0]),
        offset_fraction=float(speed_at[1]),
        peaks=count_peaks(own.speed[inside], own.rate),
        prominent_peaks=count_prominent_peaks(own.speed[inside]),
        displacement=float(np.linalg.norm(ends[1] - ends[0])),
        path=float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum()),
    )
