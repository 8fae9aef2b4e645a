"""What one predicted reach measures against the captured one, for the experiment `anytarget`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from armsyn.errors import CaptureError
from armsyn.motion import FloatArray, Motion
from armsyn.motion.filtering import LOWEST_RATE, hand_speed
from armsyn.motion.peaks import count_peaks
from armsyn.planning.prediction import REACHED_M
from armsyn.scoring.comparison import posture_errors
from armsyn.scoring.distance import held_distance, landmark_errors
from armsyn.scoring.measures import measure, normalised_speed
from armsyn.scoring.pairing import pair_up, trim, uncut
from armsyn.scoring.profile import correlation


class Score(NamedTuple):
    """One predicted reach, m, s and rad; NaN where a measure cannot be taken."""

    held: float
    """Held distance on the segments as they were cut, as the published floors are."""
    held_trimmed: float
    """The same, both from onset to offset."""
    held_given: float
    """As `held`, with the captured movement time given."""
    endpoint: float
    """From the hand's end to the target."""
    elbow: float
    """Mean distance of the elbows over normalised time, as cut."""
    swivel: float
    direction: float
    """Mean angle of upper arm and forearm to the captured ones."""
    time_to_peak: float
    peak_over_mean: float
    speed_peaks: float
    """Of the whole reach, low-passed: a second bell behind a near-stop counts, too."""
    profile_r: float
    """Correlation with the person's mean speed profile."""
    sparc: float
    log_time: float
    """ln(predicted / captured movement time)."""
    success: float
    """1 when the hand ends within 1 mm, no joint leaves its range and the motion can be measured,
    else 0."""


MEASURES = Score._fields


def score(
    captured: Motion,
    predicted: Motion,
    given: Motion,
    target: FloatArray,
    profile: FloatArray,
    *,
    in_range: bool,
) -> Score:
    """Score a predicted reach against the captured one.

    Parameters
    ----------
    captured : Motion
        As cut.
    predicted, given : Motion
        In the predicted and in the captured movement time.
    target : array, shape (3,)
        Where the hand was to end, m.
    profile : array, shape (101,)
        The person's mean speed profile.
    in_range : bool
        Whether no joint leaves its range.

    Returns
    -------
    Score

    Raises
    ------
    InputError
        Motions that do not fit each other.
    """
    whole = uncut(pair_up(captured, predicted))
    elbow = captured.landmark_names.index("elbow")
    apart = landmark_errors(whole.captured.normalised, whole.other.normalised)
    endpoint = float(np.linalg.norm(predicted.hand[-1] - target))
    try:
        looks, is_measured = _looks(captured, predicted, profile), True
    except CaptureError:
        looks, is_measured = dict.fromkeys(_LOOKS, float("nan")), False
    return Score(
        held=held_distance(whole),
        held_given=held_distance(uncut(pair_up(captured, given))),
        endpoint=endpoint,
        elbow=float(apart[:, elbow].mean()),
        speed_peaks=float(_whole_peaks(predicted, whole.rate)),
        log_time=float(np.log(predicted.duration / captured.duration)),
        success=float(endpoint <= REACHED_M and in_range and is_measured),
        **looks,
    )


_LOOKS = (
    *("held_trimmed", "swivel", "direction"),
    *("time_to_peak", "peak_over_mean", "profile_r", "sparc"),
)


def _whole_peaks(motion: Motion, rate: float) -> int:
    """Count from the first frame to the last: from onset to offset a second bell may be cut off."""
    profile = hand_speed(motion.time, motion.hand, rate=max(rate, LOWEST_RATE))
    return count_peaks(profile.speed, profile.rate)


def _looks(captured: Motion, predicted: Motion, profile: FloatArray) -> dict[str, float]:
    """Measure from onset to offset; a CaptureError where the hand hardly moves."""
    pair = pair_up(captured, predicted)
    trimmed = trim(pair)
    posture = posture_errors(pair, trimmed)
    assert posture is not None  # noqa: S101 - every arm here has a shoulder and an elbow
    hand = measure(predicted, rate=trimmed.rate)
    speed = normalised_speed(predicted.time, predicted.hand, rate=trimmed.rate)
    found = (
        *(held_distance(trimmed), posture.swivel, (posture.upper_arm + posture.forearm) / 2),
        *(hand.time_to_peak, hand.peak_over_mean),
        *(correlation(speed, profile), hand.sparc),
    )
    return dict(zip(_LOOKS, found, strict=True))
