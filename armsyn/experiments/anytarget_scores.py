"""What one predicted reach measures against the captured one, for the experiment `anytarget`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from armsyn.motion import FloatArray, Motion
from armsyn.scoring.comparison import posture_errors
from armsyn.scoring.distance import held_distance, landmark_errors
from armsyn.scoring.measures import measure, normalised_speed
from armsyn.scoring.pairing import pair_up, trim, uncut
from armsyn.scoring.profile import correlation

ARRIVED_M = 1e-3
"""A reach that ends farther from its target has missed it."""


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
    profile_r: float
    """Correlation with the person's mean speed profile."""
    sparc: float
    log_time: float
    """ln(predicted / captured movement time)."""
    success: float
    """1 when the hand ends within `ARRIVED_M` and no joint leaves its range, else 0."""


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
    InputError, CaptureError
        When a motion has gaps, does not move, or is too short to be filtered.
    """
    pair = pair_up(captured, predicted)
    whole, trimmed = uncut(pair), trim(pair)
    posture = posture_errors(pair, trimmed)
    endpoint = float(np.linalg.norm(predicted.hand[-1] - target))
    elbow = captured.landmark_names.index("elbow")
    apart = landmark_errors(whole.captured.normalised, whole.other.normalised)
    hand = measure(predicted, rate=trimmed.rate)
    speed = normalised_speed(predicted.time, predicted.hand, rate=trimmed.rate)
    nowhere = float("nan")
    return Score(
        held=held_distance(whole),
        held_trimmed=held_distance(trimmed),
        held_given=held_distance(uncut(pair_up(captured, given))),
        endpoint=endpoint,
        elbow=float(apart[:, elbow].mean()),
        swivel=posture.swivel if posture else nowhere,
        direction=(posture.upper_arm + posture.forearm) / 2 if posture else nowhere,
        time_to_peak=hand.time_to_peak,
        peak_over_mean=hand.peak_over_mean,
        speed_peaks=float(hand.speed_peaks),
        profile_r=correlation(speed, profile),
        sparc=hand.sparc,
        log_time=float(np.log(predicted.duration / captured.duration)),
        success=float(endpoint <= ARRIVED_M and in_range),
    )
