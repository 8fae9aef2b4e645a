"""A score for people (a table) and for programs (a JSON document)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from armsyn.scoring.comparison import Comparison, PostureErrors
from armsyn.scoring.measures import ProfileMeasures

if TYPE_CHECKING:
    from rich.table import Table

FILTER = "zero-lag second-order Butterworth low-pass on positions"

_PROFILE_ROWS = (
    ("movement_time_s", "movement time, s", "{:.2f}"),
    ("peak_speed_m_s", "peak speed, m/s", "{:.2f}"),
    ("time_to_peak", "time to peak, of movement time", "{:.2f}"),
    ("peak_over_mean", "peak / mean speed", "{:.2f}"),
    ("speed_peaks", "speed peaks", "{:d}"),
    ("min_jerk_r", "minimum jerk, r", "{:.3f}"),
    ("min_jerk_r2", "minimum jerk, R2", "{:.3f}"),
    ("sparc", "SPARC", "{:.3f}"),
    ("ldlj", "LDLJ (T = N / fs)", "{:.3f}"),
    ("path_over_distance", "path / distance", "{:.3f}"),
    ("deviation_over_distance", "largest deviation / distance", "{:.3f}"),
)


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
    profile = comparison.captured_profile
    return {
        "captured": comparison.captured_source,
        "other": comparison.other_source,
        "held_distance_m": comparison.held_distance,
        "paper_distance_m": comparison.paper_distance,
        "paper_coverage": comparison.coverage,
        "paper_refusal": comparison.refusal,
        "normalised_distance_m": comparison.normalised_distance,
        "log_movement_time_ratio": comparison.log_time_ratio,
        "distance_per_arm_length": _defined(comparison.per_arm_length),
        "endpoint_error_m": comparison.endpoint_error,
        "posture": None if comparison.posture is None else _posture(comparison.posture),
        "speed_r": _defined(comparison.speed_r),
        "captured_profile": profile_as_dict(profile),
        "other_profile": profile_as_dict(comparison.other_profile),
        "measured_how": {
            "landmarks": list(comparison.landmarks),
            "landmarks_left_out": list(comparison.left_out),
            "alignment": "none: positions as given",
            "paper_rate_hz": comparison.paper_rate,
            "rate_hz": comparison.rate,
            "filter": None if profile.cutoff is None else FILTER,
            "cutoff_hz": profile.cutoff,
            "cut_fraction_of_peak": profile.cut_fraction,
            "ldlj_duration": "N / fs",
        },
    }


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


def distance_table(comparison: Comparison) -> Table:
    """Return the distances as a table for the terminal, cm and degrees.

    Parameters
    ----------
    comparison : Comparison
        One motion against a captured one.

    Returns
    -------
    rich.table.Table
        The headline first.
    """
    from rich.table import Table  # noqa: PLC0415  # 50 ms that only people pay

    table = Table("distance", "value", "remark", title="Distance to the captured motion")
    for row in _distance_rows(comparison):
        table.add_row(*row)
    return table


def _distance_rows(comparison: Comparison) -> list[tuple[str, str, str]]:
    def cm(metres: float) -> str:
        return f"{100 * metres:.2f} cm"

    times = f"movement takes {math.exp(comparison.log_time_ratio):.2f} x the captured time"
    paper = comparison.refusal or "whole motions, to the end of the shorter"
    remark = f"coverage {comparison.coverage:.2f}; " + (
        f"no verdict: {paper}" if comparison.refusal else paper
    )
    rows = [
        ("held distance", cm(comparison.held_distance), "onset to offset, last posture held"),
        ("paper's distance", cm(comparison.paper_distance), remark),
        ("over normalised time", cm(comparison.normalised_distance), times),
        ("per arm length", _or_dash("{:.3f}", comparison.per_arm_length), "landmarks that move"),
        ("endpoint error", cm(comparison.endpoint_error), "between the last postures' hands"),
    ]
    posture = comparison.posture
    if posture is not None:
        swivel = _or_dash("{:.1f} deg", math.degrees(posture.swivel))
        rows += [
            ("upper arm direction", f"{math.degrees(posture.upper_arm):.1f} deg", "mean"),
            ("forearm direction", f"{math.degrees(posture.forearm):.1f} deg", "mean"),
            ("swivel", swivel, f"mean of the {posture.swivel_samples} of 101 samples with one"),
        ]
    return rows


def profile_table(comparison: Comparison) -> Table:
    """Return both hands' speed measures as a table for the terminal.

    Parameters
    ----------
    comparison : Comparison
        One motion against a captured one.

    Returns
    -------
    rich.table.Table
        With rate, filter and cut in its caption.
    """
    from rich.table import Table  # noqa: PLC0415  # 50 ms that only people pay

    profile = comparison.captured_profile
    low_pass = "no filter" if profile.cutoff is None else f"low-pass {profile.cutoff:g} Hz"
    table = Table(
        "hand speed",
        "captured",
        "other",
        title=f"Hand speed, correlation {_or_dash('{:.3f}', comparison.speed_r)}",
        caption=f"{comparison.rate:g} Hz, {low_pass}, cut at {profile.cut_fraction:.0%} of peak",
    )
    columns = [profile_as_dict(m) for m in (profile, comparison.other_profile)]
    for key, label, form in _PROFILE_ROWS:
        table.add_row(label, *(_or_dash(form, column[key]) for column in columns))
    return table


def _or_dash(form: str, value: float | None) -> str:
    return form.format(value) if value is not None and math.isfinite(value) else "-"
