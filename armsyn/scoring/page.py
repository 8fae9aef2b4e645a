"""A score as one page for a browser: motions to turn, speeds over the band, every figure.

The page is whole in itself: it loads nothing, and its own policy forbids it to.
"""

from __future__ import annotations

import json
from html import escape
from importlib.resources import files
from pathlib import Path

from armsyn.motion import FloatArray
from armsyn.motion.formats.files import replacing
from armsyn.scoring.drawing import band_strip, relative_speeds, speeds_in_time
from armsyn.scoring.pairing import Trimmed, other_rebuilt, pair_up, trim
from armsyn.scoring.report import FILTER, alignment, segments
from armsyn.scoring.score import Score
from armsyn.scoring.tables import distance_rows, likeness_rows

FRAME_RATE = 50.0
"""Hz, about, of the motions in the page."""
MOST_IN_A_CHAIN = 5
"""Landmarks that are drawn as an arm; more are markers or a whole skeleton, drawn as points."""


def write_page(path: Path, score: Score) -> None:
    """Write a score's page; the file appears whole or not at all.

    Parameters
    ----------
    path : Path
    score : Score

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    text = page(score)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def page(score: Score) -> str:
    """Return a score's page.

    Parameters
    ----------
    score : Score

    Returns
    -------
    str
        HTML; whatever files call themselves and their landmarks is text in it, never markup.
    """
    comparison = score.comparison
    trimmed = _trimmed(score)
    parts = {
        "title": escape(f"{score.other_name} against {score.captured_name}"),
        "captured": escape(f"{score.captured_name} ({comparison.captured_source})"),
        "other": escape(f"{score.other_name} ({comparison.other_source})"),
        "headline": _headline(score),
        "shown": "B's segments are shown rebuilt on A's lengths." if comparison.rebuilt else "",
        "plots": relative_speeds(score) + speeds_in_time(score),
        "distances": "\n".join(_row(*row) for row in distance_rows(comparison)),
        "band_heads": "<th>band</th><th>B is</th><th></th>" if score.bands else "",
        "measures": _measures(score),
        "how": "\n".join(_row(*row) for row in _how(score)),
        "motions": _motions(trimmed),
    }
    template = files("armsyn.scoring").joinpath("page.html").read_text(encoding="utf-8")
    # Split, not replaced one after the other: a name that looks like a place of another stays text.
    first, *rest = template.split("{{")
    filled = [first]
    for piece in rest:
        key, after = piece.split("}}", 1)
        filled += [parts[key], after]
    return "".join(filled)


def _trimmed(score: Score) -> Trimmed:
    """Return both motions as the held distance saw them."""
    pair = pair_up(score.captured, score.other)
    profile = score.comparison.captured_profile
    pair = other_rebuilt(pair, score.comparison.rebuilt_segments)
    return trim(pair, cutoff=profile.cutoff, fraction=profile.cut_fraction)


def _headline(score: Score) -> str:
    comparison = score.comparison
    text = f"Held distance <b>{100 * comparison.held_distance:.2f} cm</b>"
    if comparison.floor is not None:
        text += f", <b>{comparison.over_floor:.2f} times</b> the human floor"
    text += f"; the hand ends <b>{100 * comparison.endpoint_error:.2f} cm</b> away."
    if comparison.refusal is not None:
        text += (
            f' <span class="refused">The paper\'s distance is no verdict:'
            f" {escape(comparison.refusal)}.</span>"
        )
    return text


def _row(*cells: str) -> str:
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"


def _measures(score: Score) -> str:
    rows = []
    for row in likeness_rows(score):
        cells = [f"<td>{escape(cell)}</td>" for cell in (row.label, row.captured, row.other)]
        if score.bands is not None:
            band = score.bands.measures.get(row.key)
            values = score.captured_likeness[row.key], score.other_likeness[row.key]
            strip = "" if band is None else band_strip(band, *values)
            cells.append(f"<td>{escape(row.band)}</td>")
            cells.append(f'<td class="{row.place or ""}">{row.place or "-"}</td>')
            cells.append(f'<td class="strip">{strip}</td>')
        rows.append("<tr>" + "".join(cells) + "</tr>")
    return "\n".join(rows)


def _how(score: Score) -> list[tuple[str, str]]:
    comparison, how = score.comparison, score.how
    pairs = zip(comparison.landmarks, comparison.other_landmarks, strict=True)
    low_pass = "none" if how.cutoff is None else f"{FILTER}, {how.cutoff:g} Hz"
    rows = [
        ("joint map, A to B", ", ".join(f"{a} to {b}" for a, b in pairs)),
        ("landmarks in one only", ", ".join(comparison.left_out) or "none"),
        ("alignment", alignment(comparison)),
        ("segments", segments(comparison)),
        ("segment lengths of A, m", _lengths(comparison.segments)),
        ("segment lengths of B, m", _lengths(comparison.other_segments)),
        ("filter", low_pass),
        ("onset and offset", f"{how.fraction:.0%} of the peak speed"),
        ("rate of distances", f"{comparison.rate:g} Hz; the paper's {comparison.paper_rate:g} Hz"),
        ("rate of measures", f"{how.rate:g} Hz; LDLJ with T = N / fs"),
        ("movement of A", "{} of {}".format(*score.captured_movement)),
        ("movement of B", "{} of {}".format(*score.other_movement)),
    ]
    if score.bands is not None:
        rows.append(("bands", f"{score.bands.reaches} reaches of {score.bands.captures}"))
    return rows


def _lengths(lengths: tuple[float, ...]) -> str:
    return ", ".join(f"{length:.3f}" for length in lengths) or "-"


def _motions(trimmed: Trimmed) -> str:
    step = max(1, round(trimmed.rate / FRAME_RATE))
    document = {
        "chain": trimmed.captured.landmarks.shape[1] <= MOST_IN_A_CHAIN,
        "step_s": step / trimmed.rate,
        "captured": _points(trimmed.captured.landmarks, step),
        "other": _points(trimmed.other.landmarks, step),
    }
    return json.dumps(document, separators=(",", ":"), allow_nan=False)


def _points(landmarks: FloatArray, step: int) -> list[object]:
    rounded: list[object] = landmarks[::step].round(4).tolist()
    return rounded
