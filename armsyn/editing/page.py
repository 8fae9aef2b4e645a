"""An edit as one page for a browser, whole in itself: it loads nothing."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

from armsyn.editing.cautions import edit_cautions
from armsyn.editing.pictures import draw_edit
from armsyn.editing.report import Scored, figure_rows
from armsyn.editing.result import EditResult
from armsyn.motion.formats.files import replacing
from armsyn.scoring.tables import distance_rows, likeness_rows

_HEAD = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy"
      content="default-src 'none'; style-src 'unsafe-inline'; img-src data:">
<title>{title}</title>
<style>
body {{ font: 15px/1.45 system-ui, sans-serif; max-width: 66rem; margin: 1.5rem auto; }}
table {{ border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }}
th, td {{ text-align: left; padding: .2rem .7rem .2rem 0; border-bottom: 1px solid #e2e2e2; }}
img {{ width: 100%; height: auto; }}
</style>
</head>
<body>
<h1>{title}</h1>
<p>{verdict}</p>
"""


def write_page(
    path: Path, result: EditResult, scored: Scored, coefficient_bound: float, notes: Sequence[str]
) -> None:
    """Write an edit's page; the file appears whole or not at all.

    Parameters
    ----------
    path : Path
    result : EditResult
    scored : Scored
    coefficient_bound : float
        Standard deviations beyond which an edit is refused unless forced.
    notes : sequence of str
        What else is to be said, such as what the safety's check found.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    text = page(result, scored, coefficient_bound, notes)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def page(
    result: EditResult, scored: Scored, coefficient_bound: float, notes: Sequence[str] = ()
) -> str:
    """Return an edit's page; whatever files call themselves is text in it, never markup."""
    verdict = "Every constraint is met." if result.success else ""
    cautions = [f"Look: {caution}." for caution in edit_cautions(result, coefficient_bound)]
    said = " ".join(map(escape, filter(None, [verdict, *cautions, *notes])))
    title = escape(f"{result.original.source or 'clip'}, edited")
    parts = [_HEAD.format(title=title, verdict=said)]
    parts.append(f'<img alt="before and after" src="{_picture(result, coefficient_bound)}">')
    parts += ["<h2>The edit</h2>", _table(("what", "value"), figure_rows(result))]
    parts.append("<h2>Score of after against before</h2>")
    if scored.score is None:
        parts.append(f"<p>Not taken: {escape(scored.refusal)}</p>")
    else:
        score = scored.score
        distances = distance_rows(score.comparison)
        measures = [(row.label, row.captured, row.other) for row in likeness_rows(score)]
        parts.append(_table(("distance", "value", "remark"), distances))
        parts.append(_table(("measure", "before", "after"), measures))
    return "\n".join([*parts, "</body>", "</html>", ""])


def _table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    lines = [_row("th", heads), *(_row("td", row) for row in rows)]
    return "<table>\n" + "\n".join(lines) + "\n</table>"


def _row(tag: str, cells: Iterable[str]) -> str:
    return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"


def _picture(result: EditResult, coefficient_bound: float) -> str:
    content = io.BytesIO()
    draw_edit(result, coefficient_bound).savefig(content, format="png", dpi=110)
    return "data:image/png;base64," + base64.b64encode(content.getvalue()).decode("ascii")
