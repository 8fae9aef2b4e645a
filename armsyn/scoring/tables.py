"""A score for people: tables for the terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from armsyn.scoring.comparison import Comparison
from armsyn.scoring.report import profile_as_dict

if TYPE_CHECKING:
    from rich.table import Table

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
        ("over the human floor", _or_dash("{:.2f} x", comparison.over_floor), _floor(comparison)),
        (
            "endpoint error",
            cm(comparison.endpoint_error),
            "of the last postures' hands, unscaled",
        ),
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


def _floor(comparison: Comparison) -> str:
    floor = comparison.floor
    if floor is None:
        return "n/a: no repeats of this reach by the same person"
    return (
        f"floor {100 * floor.distance:.2f} cm, the mean of {floor.repeats} other repeats;"
        f" two repeats are {100 * floor.repeat_distance:.2f} cm apart"
    )


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
