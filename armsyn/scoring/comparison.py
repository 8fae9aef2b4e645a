"""Everything that a score says about one motion against a captured one."""

from __future__ import annotations

import dataclasses
import math
import operator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armsyn.motion import FloatArray, Motion
from armsyn.motion.base_transform import BaseTransform
from armsyn.motion.filtering import CUTOFF
from armsyn.motion.rebuilding import segment_lengths
from armsyn.motion.segmentation import CUT_FRACTION
from armsyn.scoring.distance import (
    coverage,
    distance_per_arm_length,
    held_distance,
    mean_distance,
    normalised_distance,
)
from armsyn.scoring.floor import HumanFloor
from armsyn.scoring.measures import ProfileMeasures, measure, normalised_speed
from armsyn.scoring.pairing import (
    Pair,
    Trimmed,
    bones,
    different_segments,
    is_arm,
    other_rebuilt,
    pair_up,
    trim,
)
from armsyn.scoring.posture import angles_between, swivel_angles, swivel_differences
from armsyn.scoring.profile import correlation

LEAST_COVERAGE = 0.95
TARGET_MISSED = 0.05
"""m. On HuG-MP repeats of one target end 2-3 cm apart (median; 95 % below 5.5 cm for S01), the
nearest two targets 7.4 and 11.3 cm."""


@dataclass(frozen=True)
class PostureErrors:
    """How differently two arms are held over normalised time; NaN where it cannot be said.

    Parameters
    ----------
    upper_arm, forearm : float
        Mean angle between the segments' directions, rad.
    swivel : float
        Mean absolute difference of the swivel angles, rad.
    swivel_end : float
        The other's minus the captured one's at the last moment both have one, rad.
    swivel_samples : int
        Of 101, how many have a swivel in both: a straight arm has none.
    """

    upper_arm: float
    forearm: float
    swivel: float
    swivel_end: float
    swivel_samples: int


@dataclass(frozen=True)
class Comparison:
    """The score of one motion against a captured one, metres and seconds.

    Parameters
    ----------
    captured_source, other_source : str
        Where they come from.
    landmarks, other_landmarks, left_out : tuple of str
        Compared, by the names of the one and the other; found in only one of them.
    segments, other_segments : tuple of float
        m, the lengths between landmarks, before anything was rebuilt.
    transform : BaseTransform or None
        Of the session, by which the other's landmarks were brought to the captured base.
    rebuilt_segments : tuple of bool
        Which of the other's segments were rebuilt on the captured lengths: distances and
        directions are then of the rebuilt arm. Speeds and the endpoint error never are.
    no_bones : tuple of bool
        Which have another length and were not rebuilt, being no single bone in both.
    paper_rate, rate : float
        Hz at which the paper's distance, and everything else, was taken.
    paper_distance, coverage : float
        Of the motions as given, to the end of the shorter; shorter over longer duration.
    refusal : str or None
        Why the paper's distance is no verdict here; None when it is.
    held_distance : float
        The headline.
    normalised_distance, log_time_ratio : float
        Over normalised time; ln(other's movement time / captured one's).
    per_arm_length : float
        Held distance over the landmarks that move, in arm lengths; NaN for a hand alone.
    posture : PostureErrors or None
        None without landmarks named shoulder and elbow.
    floor : HumanFloor or None
        Of the captured reach; None where its person has no repeats of it.
    endpoint_error : float
        Between the hands' positions in the last frames, unscaled.
    captured_profile, other_profile : ProfileMeasures
        Of the hands, with filter and cut.
    speed_r : float
        Correlation of the hands' speeds over normalised time.
    cut_out : str
        Which movement of which recording the motions are; empty where they are whole ones.
    """

    captured_source: str
    other_source: str
    landmarks: tuple[str, ...]
    other_landmarks: tuple[str, ...]
    left_out: tuple[str, ...]
    segments: tuple[float, ...]
    other_segments: tuple[float, ...]
    transform: BaseTransform | None
    rebuilt_segments: tuple[bool, ...]
    no_bones: tuple[bool, ...]
    paper_rate: float
    rate: float
    paper_distance: float
    coverage: float
    refusal: str | None
    held_distance: float
    normalised_distance: float
    log_time_ratio: float
    per_arm_length: float
    posture: PostureErrors | None
    floor: HumanFloor | None
    endpoint_error: float
    captured_profile: ProfileMeasures
    other_profile: ProfileMeasures
    speed_r: float
    cut_out: str = ""

    @property
    def rebuilt(self) -> bool:
        """Whether any of the other's segments was rebuilt."""
        return any(self.rebuilt_segments)

    @property
    def over_floor(self) -> float:
        """Held distance over the human floor; NaN without one."""
        return self.held_distance / self.floor.distance if self.floor else math.nan


def compare(
    captured: Motion,
    other: Motion,
    *,
    floor: HumanFloor | None = None,
    transform: BaseTransform | None = None,
    rebuild: bool | None = None,
    neighbours: tuple[bool, ...] | None = None,
    cutoff: float | None = CUTOFF,
    fraction: float = CUT_FRACTION,
) -> Comparison:
    """Score a motion against a captured one.

    Parameters
    ----------
    captured, other : Motion
        With landmarks, in one frame; each one movement.
    floor : HumanFloor or None
        Of the captured reach, taken with the same filter and cut.
    transform : BaseTransform or None
        By which the other was brought to the captured frame, to be published; it is not applied.
    rebuild : bool or None
        Whether segments of other lengths are rebuilt on the captured ones; None where the
        landmarks' names say that they are an arm's. Only what is one bone in both ever is.
    neighbours : tuple of bool or None
        Of each two landmarks, whether they follow each other in both motions, where these have
        been picked of more; None as they are.
    cutoff : float or None
        Hz, of the low-pass before speeds are taken, the same for both.
    fraction : float
        Of the peak speed, at onset and offset.

    Returns
    -------
    Comparison
        With rate, filter, cut and landmarks stated.

    Raises
    ------
    FormatError
        When one of them has angles only.
    InputError, CaptureError
        When one of them has gaps, does not move, or is too short or too slow for the filter.
    """
    given = pair_up(captured, other)
    if neighbours is not None:
        given = dataclasses.replace(given, neighbours=neighbours)
    wanted = rebuild or (rebuild is None and is_arm(given))
    rigid = bones(given)
    different = different_segments(given) if wanted else (False,) * len(rigid)
    # Where one bone has another length, all are rebuilt: none then changes from frame to frame
    any_bone = any(map(operator.and_, different, rigid))
    rebuilt = tuple(any_bone and bone for bone in rigid)
    no_bones = tuple(map(operator.gt, different, rigid))
    pair = other_rebuilt(given, rebuilt)
    trimmed = trim(pair, cutoff=cutoff, fraction=fraction)
    how = _How(cutoff, fraction, trimmed.rate)
    endpoint_error = float(np.linalg.norm(other.hand[-1] - captured.hand[-1]))
    return Comparison(
        captured_source=captured.source,
        other_source=other.source,
        landmarks=pair.names,
        other_landmarks=pair.other_names,
        left_out=pair.left_out,
        segments=tuple(segment_lengths(given.captured.landmarks).tolist()),
        other_segments=tuple(segment_lengths(given.other.landmarks).tolist()),
        transform=transform,
        rebuilt_segments=rebuilt,
        no_bones=no_bones,
        paper_rate=pair.rate,
        rate=trimmed.rate,
        paper_distance=mean_distance(pair.captured.evenly(pair.rate), pair.other.evenly(pair.rate)),
        coverage=coverage(pair),
        refusal=refusal_of_paper_distance(coverage(pair), endpoint_error),
        held_distance=held_distance(trimmed),
        normalised_distance=normalised_distance(trimmed),
        log_time_ratio=math.log(trimmed.other.duration / trimmed.captured.duration),
        per_arm_length=distance_per_arm_length(trimmed),
        posture=posture_errors(pair, trimmed),
        floor=floor,
        endpoint_error=endpoint_error,
        captured_profile=how.measures(captured),
        other_profile=how.measures(other),
        speed_r=correlation(how.speed(captured), how.speed(other)),
    )


class _How(NamedTuple):
    """One way of measuring, for both hands."""

    cutoff: float | None
    fraction: float
    rate: float

    def measures(self, motion: Motion) -> ProfileMeasures:
        return measure(motion, **self._asdict())

    def speed(self, motion: Motion) -> FloatArray:
        return normalised_speed(motion.time, motion.hand, **self._asdict())


def refusal_of_paper_distance(covered: float, endpoint_error: float) -> str | None:
    """Say why the paper's distance is no verdict: it can be had by stopping early.

    Parameters
    ----------
    covered : float
        Shorter over longer duration.
    endpoint_error : float
        m.

    Returns
    -------
    str or None
        One line, or None when nothing speaks against it.
    """
    if covered < LEAST_COVERAGE:
        return f"only {covered:.0%} of the longer motion is compared"
    if endpoint_error > TARGET_MISSED:
        return f"the target is missed by {100 * endpoint_error:.1f} cm"
    return None


def posture_errors(pair: Pair, trimmed: Trimmed) -> PostureErrors | None:
    """Compare directions of upper arm and forearm, and the swivel, over normalised time.

    Parameters
    ----------
    pair : Pair
        For the landmarks' names: shoulder, elbow, and wrist (else the end effector stands for it).
    trimmed : Trimmed
        Both motions from onset to offset.

    Returns
    -------
    PostureErrors or None
        None without landmarks named shoulder and elbow.
    """
    if not {"shoulder", "elbow"} <= set(pair.names[:-1]):
        return None
    last = pair.names.index("wrist") if "wrist" in pair.names else -1
    places = [pair.names.index("shoulder"), pair.names.index("elbow"), last]
    first, second = (
        part.normalised[:, places].swapaxes(0, 1) for part in (trimmed.captured, trimmed.other)
    )
    difference = swivel_differences(swivel_angles(*first), swivel_angles(*second))
    known = difference[np.isfinite(difference)]
    return PostureErrors(
        upper_arm=_direction_error(first[1] - first[0], second[1] - second[0]),
        forearm=_direction_error(first[2] - first[1], second[2] - second[1]),
        swivel=float(np.abs(known).mean()) if known.size else float("nan"),
        swivel_end=float(known[-1]) if known.size else float("nan"),
        swivel_samples=int(known.size),
    )


def _direction_error(first: FloatArray, second: FloatArray) -> float:
    return float(angles_between(first, second).mean())
