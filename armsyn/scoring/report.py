"""A score for programs: a JSON document."""

from __future__ import annotations

import itertools
import math
from typing import Any

from armsyn.scoring.comparison import Comparison, PostureErrors
from armsyn.scoring.floor import HumanFloor
from armsyn.scoring.measures import ProfileMeasures

FILTER = "zero-lag second-order Butterworth low-pass on positions"


def profile_as_dict(measures: ProfileMeasures) -> dict[str, float | int | None]:
    """Return a profile's measures by names that say their unit.

    Parameters
    ----------
    measures : ProfileMeasures
        Of one hand.

    Returns
    -------
    dict
        For JSON: what is not defined is None.
    """
    return {
        "onset_s": measures.onset,
        "offset_s": measures.offset,
        "movement_time_s": measures.movement_time,
        "path_m": measures.path,
        "distance_m": measures.distance,
        "peak_speed_m_s": measures.peak_speed,
        "time_to_peak": measures.time_to_peak,
        "peak_over_mean": measures.peak_over_mean,
        "speed_peaks": measures.speed_peaks,
        "min_jerk_r": _defined(measures.min_jerk_r),
        "min_jerk_r2": _defined(measures.min_jerk_r2),
        "sparc": measures.sparc,
        "ldlj": measures.ldlj,
        "path_over_distance": _defined(measures.path_over_distance),
        "deviation_over_distance": _defined(measures.deviation_over_distance),
    }


def as_dict(comparison: Comparison) -> dict[str, Any]:
    """Return a score as a JSON document: SI units, angles in degrees, names say which.

    Parameters
    ----------
    comparison : Comparison
        One motion against a captured one.

    Returns
    -------
    dict
        For JSON: what is not defined is None.
    """
    return {
        "captured": comparison.captured_source,
        "other": comparison.other_source,
        "held_distance_m": comparison.held_distance,
        "paper_distance_m": comparison.paper_distance,
        "paper_coverage": comparison.coverage,
        "paper_refusal": comparison.refusal,
        "paper_distance_of": comparison.cut_out or "whole motions",
        "normalised_distance_m": comparison.normalised_distance,
        "log_movement_time_ratio": comparison.log_time_ratio,
        "distance_per_arm_length": _defined(comparison.per_arm_length),
        "over_human_floor": _defined(comparison.over_floor),
        "human_floor": None if comparison.floor is None else floor_as_dict(comparison.floor),
        "endpoint_error_m": comparison.endpoint_error,
        "posture": None if comparison.posture is None else _posture(comparison.posture),
        "speed_r": _defined(comparison.speed_r),
        "captured_profile": profile_as_dict(comparison.captured_profile),
        "other_profile": profile_as_dict(comparison.other_profile),
        "measured_how": _measured_how(comparison),
    }


def floor_as_dict(floor: HumanFloor) -> dict[str, float | int]:
    """Return a human floor for JSON, metres."""
    return {
        "distance_m": floor.distance,
        "repeat_distance_m": floor.repeat_distance,
        "repeats": floor.repeats,
    }


def _measured_how(comparison: Comparison) -> dict[str, Any]:
    profile = comparison.captured_profile
    return {
        "landmarks": list(comparison.landmarks),
        "landmarks_left_out": list(comparison.left_out),
        "joint_map": dict(zip(comparison.landmarks, comparison.other_landmarks, strict=True)),
        "alignment": alignment(comparison),
        "segments": segments(comparison),
        "captured_segments_m": list(comparison.segments),
        "other_segments_m": list(comparison.other_segments),
        "paper_rate_hz": comparison.paper_rate,
        "rate_hz": comparison.rate,
        "filter": None if profile.cutoff is None else FILTER,
        "cutoff_hz": profile.cutoff,
        "cut_fraction_of_peak": profile.cut_fraction,
        "ldlj_duration": "N / fs",
    }


def alignment(comparison: Comparison) -> str:
    """Say how the other's frame was brought to the captured one."""
    fitted = comparison.transform
    if fitted is None:
        return "none: positions as given"
    return (
        f"one rigid transform for the session, from {fitted.poses} calibration poses"
        f" ({fitted.source}), residual {100 * fitted.residual:.2f} cm rms"
    )


def segments(comparison: Comparison) -> str:
    """Say which of the other's segments were rebuilt."""
    named = list(map("-".join, itertools.pairwise(comparison.landmarks)))
    given = ", ".join(itertools.compress(named, comparison.no_bones))
    text = "as given"
    if comparison.rebuilt:
        which = ", ".join(itertools.compress(named, comparison.rebuilt_segments))
        which = "" if all(comparison.rebuilt_segments) else f" {which}"
        text = f"the other's{which} rebuilt on the captured lengths along their directions"
        given = given and f"as given: {given}"
    return f"{text}; {given}, no single bone in both" if given else text


def _posture(errors: PostureErrors) -> dict[str, float | int | None]:
    return {
        "upper_arm_direction_deg": math.degrees(errors.upper_arm),
        "forearm_direction_deg": math.degrees(errors.forearm),
        "swivel_deg": _defined(math.degrees(errors.swivel)),
        "swivel_end_deg": _defined(math.degrees(errors.swivel_end)),
        "swivel_samples_of_101": errors.swivel_samples,
    }


def _defined(value: float) -> float | None:
    return value if math.isfinite(value) else None
