"""Two motions brought to the same landmarks and cut to their movements, for every distance."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armsyn.errors import CaptureError, FormatError
from armsyn.motion import FloatArray, Motion
from armsyn.motion.filtering import CUTOFF, LOWEST_RATE, hand_speed
from armsyn.motion.rebuilding import rebuild_segments, segment_lengths
from armsyn.motion.resample import interpolate, uniform_times
from armsyn.motion.segmentation import CUT_FRACTION, movement_times

ARM = ("shoulder", "elbow", "wrist")
"""Landmarks that, followed by the hand, are a chain of segments by their names."""
SAME_LENGTH = 1e-3
"""m; segments that differ by less are taken for the same arm's, and left as they are."""
RIGID = 1e-2
"""m; standard deviation of a length over the frames, above which what lies there is no bone."""

ANGLES_ALONE = (
    "only joint angles: scores compare landmark positions; add NAME:x_m, NAME:y_m, NAME:z_m by the"
    " arm's forward kinematics"
)


class Track(NamedTuple):
    """Landmarks without gaps, sampled in time."""

    time: FloatArray
    """Shape (frames,), s."""
    landmarks: FloatArray
    """Shape (frames, landmarks, 3), m, the end effector last."""

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return float(self.time[-1] - self.time[0])

    def evenly(self, rate: float) -> FloatArray:
        """Return the landmarks at a rate (Hz), shape (samples, landmarks, 3), m."""
        times = uniform_times(float(self.time[0]), float(self.time[-1]), rate)
        return interpolate(self.time, self.landmarks, times)


@dataclass(frozen=True)
class Pair:
    """A captured motion and the one that is compared with it.

    Parameters
    ----------
    captured, other : Track
        The same landmarks in the same order.
    names : tuple of str
        The landmarks, by the captured motion's names.
    other_names : tuple of str
        The same landmarks, by the other motion's names.
    left_out : tuple of str
        Landmarks that only one of them has.
    rate : float
        The higher of their mean rates, Hz.
    neighbours : tuple of bool
        Of each two landmarks that follow each other here, whether they do in both motions.
    """

    captured: Track
    other: Track
    names: tuple[str, ...]
    other_names: tuple[str, ...]
    left_out: tuple[str, ...]
    rate: float
    neighbours: tuple[bool, ...]


def pair_up(captured: Motion, other: Motion) -> Pair:
    """Match the landmarks of two motions by name; their end effectors match each other.

    Parameters
    ----------
    captured, other : Motion
        With landmarks, in one frame.

    Returns
    -------
    Pair
        With what was left out.

    Raises
    ------
    FormatError
        When one of them has angles only.
    CaptureError
        When a landmark that is compared has gaps.
    """
    first, second = captured.landmark_names, other.landmark_names
    common = [name for name in first[:-1] if name in second[:-1]]
    tracks = _track(captured, common), _track(other, common)
    return Pair(
        *tracks,
        names=(*common, first[-1]),
        other_names=(*common, second[-1]),
        left_out=tuple(name for name in (*first[:-1], *second[:-1]) if name not in common),
        rate=max(captured.rate, other.rate),
        neighbours=neighbours((first, (*common, first[-1])), (second, (*common, second[-1]))),
    )


def neighbours(*motions: tuple[tuple[str, ...], tuple[str, ...]]) -> tuple[bool, ...]:
    """Say of each two landmarks that follow each other whether they do in every motion's list.

    Parameters
    ----------
    *motions : (tuple of str, tuple of str)
        All landmarks of a motion, and those that are compared, as it names them.

    Returns
    -------
    tuple of bool
        One fewer than landmarks that are compared.
    """
    places = np.array([[names.index(name) for name in kept] for names, kept in motions])
    return tuple((np.diff(places, axis=1) == 1).all(axis=0).tolist())


def _track(motion: Motion, names: list[str]) -> Track:
    """Keep some landmarks and the end effector, in this order, and check them for gaps."""
    if motion.landmarks is None:
        raise FormatError(f"{motion.source or 'motion'}: {ANGLES_ALONE}")
    kept = (*names, motion.landmark_names[-1])
    landmarks = motion.landmarks[:, [motion.landmark_names.index(name) for name in kept]]
    gaps = np.argwhere(~np.isfinite(landmarks).all(axis=2))
    if gaps.size:
        frame, place = (int(index) for index in gaps[0])
        raise CaptureError(
            f"{motion.source or 'motion'}: landmark '{kept[place]}' has a gap at frame {frame}:"
            " cut the motion or fill it"
        )
    return Track(motion.time, landmarks)


def is_arm(pair: Pair) -> bool:
    """Say whether the landmarks are by their names an arm, each at its segment's end.

    Markers, or the joints of a whole skeleton, are none: what lies between two of them that follow
    each other is no segment.
    """
    return pair.names[:-1] == tuple(name for name in ARM if name in pair.names[:-1])


def bones(pair: Pair) -> tuple[bool, ...]:
    """Say which segments are one bone in both: landmarks that follow each other, rigidly.

    Where one motion lacks a landmark in between, two bones and the joint between them lie there.

    Parameters
    ----------
    pair : Pair
        Landmarks in the order of the chain.

    Returns
    -------
    tuple of bool
        One for each segment.
    """

    def varies(track: Track) -> FloatArray:
        lengths = np.linalg.norm(np.diff(track.landmarks, axis=1), axis=2)
        return np.asarray(lengths.std(axis=0))

    rigid = (varies(pair.captured) < RIGID) & (varies(pair.other) < RIGID)
    return tuple((rigid & np.array(pair.neighbours, dtype=np.bool_)).tolist())


def different_segments(pair: Pair) -> tuple[bool, ...]:
    """Say which segments differ in length by more than `SAME_LENGTH`."""
    lengths, others = (segment_lengths(one.landmarks) for one in (pair.captured, pair.other))
    return tuple((np.abs(others - lengths) > SAME_LENGTH).tolist())


def other_rebuilt(pair: Pair, segments: tuple[bool, ...]) -> Pair:
    """Return the pair with segments of the other rebuilt on the captured lengths.

    Parameters
    ----------
    pair : Pair
        Landmarks in the order of the chain.
    segments : tuple of bool
        Which; the others stay as they are, moved with what carries them.

    Returns
    -------
    Pair
        The same one where there is none.

    Raises
    ------
    CaptureError
        When two landmarks of the other coincide.
    """
    if not any(segments):
        return pair
    lengths = np.where(segments, segment_lengths(pair.captured.landmarks), np.nan)
    rebuilt = rebuild_segments(pair.other.landmarks, lengths)
    return dataclasses.replace(pair, other=pair.other._replace(landmarks=rebuilt))


class Movement(NamedTuple):
    """One motion from onset to offset."""

    landmarks: FloatArray
    """Shape (frames, landmarks, 3), m, evenly spaced at the rate of `Trimmed`."""
    normalised: FloatArray
    """Shape (101, landmarks, 3), m, evenly spaced from onset to offset."""
    duration: float
    """Movement time, s."""


@dataclass(frozen=True)
class Trimmed:
    """Both motions of a pair from onset to offset.

    Parameters
    ----------
    captured, other : Movement
        Their numbers of frames differ.
    rate : float
        Hz.
    """

    captured: Movement
    other: Movement
    rate: float


def trim(pair: Pair, *, cutoff: float | None = CUTOFF, fraction: float = CUT_FRACTION) -> Trimmed:
    """Cut both motions to onset and offset, found in the filtered speed of their hands.

    Both ends are found between samples, so that the grid does not move them; the positions
    themselves are not filtered.

    Parameters
    ----------
    pair : Pair
        The two motions.
    cutoff : float or None
        Hz, of the low-pass before speeds are taken.
    fraction : float
        Of the peak speed.

    Returns
    -------
    Trimmed
        At the pair's rate, 100 Hz at least.

    Raises
    ------
    InputError, CaptureError
        As `armsyn.motion.filtering.hand_speed` and `movement_times`.
    """
    rate = max(pair.rate, LOWEST_RATE)

    def moving(track: Track) -> Movement:
        profile = hand_speed(track.time, track.landmarks[:, -1], cutoff=cutoff, rate=rate)
        onset, offset = movement_times(profile.time, profile.speed, fraction)
        even, moments = uniform_times(onset, offset, rate), np.linspace(onset, offset, 101)
        return Movement(
            interpolate(track.time, track.landmarks, even),
            interpolate(track.time, track.landmarks, moments),
            offset - onset,
        )

    return Trimmed(moving(pair.captured), moving(pair.other), rate)


def uncut(pair: Pair) -> Trimmed:
    """Return both motions whole, at the pair's rate: for segments that were cut by others.

    Parameters
    ----------
    pair : Pair
        The two motions.

    Returns
    -------
    Trimmed
        From the first frame to the last.
    """

    def whole(track: Track) -> Movement:
        moments = np.linspace(track.time[0], track.time[-1], 101)
        normalised = interpolate(track.time, track.landmarks, moments)
        return Movement(track.evenly(pair.rate), normalised, track.duration)

    return Trimmed(whole(pair.captured), whole(pair.other), pair.rate)
