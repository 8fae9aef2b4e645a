"""A score for people: tables for the terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from armsyn.scoring.bands import Bands, Place
from armsyn.scoring.comparison import Comparison
from armsyn.scoring.human_likeness import MEASURES, How
from armsyn.scoring.score import Score

if TYPE_CHECKING:
    from rich.table import Table

_FORMS = {
    "speed_peaks": "{:.0f}",
    "movement_time_s": "{:.2f}",
    "swivel_change_deg": "{:.1f}",
    "swivel_end_deg": "{:.1f}",
}
_COLOURS = {"within": "green", "below": "yellow", "above": "yellow", None: ""}


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
    for row in distance_rows(comparison):
        table.add_row(*row)
    return table


def distance_rows(comparison: Comparison) -> list[tuple[str, str, str]]:
    """Write out every distance: what, how much, and a remark."""

    def cm(metres: float) -> str:
        return f"{100 * metres:.2f} cm"

    times = f"movement takes {math.exp(comparison.log_time_ratio):.2f} x the captured time"
    of = f"{comparison.cut_out or 'whole motions'}, to the end of the shorter"
    if comparison.refusal:
        of = "; ".join(filter(None, (f"no verdict: {comparison.refusal}", comparison.cut_out)))
    remark = f"coverage {comparison.coverage:.2f}; {of}"
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


def likeness_table(score: Score) -> Table:
    """Return both motions' measures, and their bands, as a table for the terminal.

    Parameters
    ----------
    score : Score

    Returns
    -------
    rich.table.Table
        With rate, filter and cut in its caption.
    """
    from rich.table import Table  # noqa: PLC0415  # 50 ms that only people pay

    caption = _taken(score.how)
    if score.bands is not None:
        caption += f"; bands: median (5-95 %) of {score.bands.reaches} of {score.bands.captures}"
    table = Table(
        *("measure", "captured", "other"),
        *(("band", "other's place") if score.bands else ()),
        title=f"Speed and shape; speeds correlate {_or_dash('{:.3f}', score.comparison.speed_r)}",
        caption=caption,
    )
    for row in likeness_rows(score):
        place = [] if score.bands is None else [row.band, _coloured(row.place)]
        table.add_row(row.label, row.captured, row.other, *place)
    return table


class LikenessRow(NamedTuple):
    """One measure, written out."""

    key: str
    label: str
    captured: str
    other: str
    band: str
    place: Place | None


def likeness_rows(score: Score) -> list[LikenessRow]:
    """Write out every measure that one of the motions, or the bands, have."""
    rows = []
    for key, label in MEASURES.items():
        form = _FORMS.get(key, "{:.3f}")
        values = score.captured_likeness[key], score.other_likeness[key]
        band = score.bands.measures.get(key) if score.bands else None
        if band is None and not any(map(math.isfinite, values)):
            continue
        written = "-" if band is None else f"{form} ({form} to {form})".format(*band[:3])
        place = None if band is None else band.place(values[1])
        captured, other = (_or_dash(form, value) for value in values)
        rows.append(LikenessRow(key, label, captured, other, written, place))
    return rows


def bands_table(bands: Bands) -> Table:
    """Return bands as a table for the terminal.

    Parameters
    ----------
    bands : Bands

    Returns
    -------
    rich.table.Table
        With rate, filter and cut in its caption.
    """
    from rich.table import Table  # noqa: PLC0415  # 50 ms that only people pay

    table = Table(
        *("measure", "median", "5 %", "95 %", "n"),
        title=f"{bands.reaches} reaches of {bands.captures}",
        caption=_taken(bands.how),
    )
    for key, label in MEASURES.items():
        if key in bands.measures:
            band, form = bands.measures[key], _FORMS.get(key, "{:.3f}")
            table.add_row(label, *(form.format(value) for value in band[:3]), str(band.n))
    return table


def _taken(how: How) -> str:
    low_pass = "no filter" if how.cutoff is None else f"low-pass {how.cutoff:g} Hz"
    return f"{how.rate:g} Hz, {low_pass}, cut at {how.fraction:.0%} of peak"


def _coloured(place: Place | None) -> str:
    return f"[{_COLOURS[place]}]{place}[/]" if place else "-"


def _or_dash(form: str, value: float | None) -> str:
    return form.format(value) if value is not None and math.isfinite(value) else "-"
