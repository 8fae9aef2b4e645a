"""Tables of results, written as JSON (SI units) and as Markdown (for people)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from armsyn.motion.formats.files import replacing

SCHEMA = "armsyn-experiment-1"
MOST_ROWS = 100
"""Of a table for people; longer ones are in the JSON file only."""
Value = str | int | float | None


class Column(NamedTuple):
    """A column: its key in JSON, its heading for people and how numbers are shown to them.

    A value is multiplied by `scale` and formatted by `form`; None is a dash.
    """

    key: str
    heading: str
    form: str = ""
    scale: float = 1.0

    def shown(self, value: Value) -> str:
        """Text of a value for people."""
        if value is None:
            return "-"
        if isinstance(value, str) or not self.form:
            return str(value)
        return format(value * self.scale, self.form)


def centimetres(key: str, heading: str) -> Column:
    """Column of lengths that people read in cm; `key` gets the unit that is written, m."""
    return Column(f"{key}_m", f"{heading}, cm", ".2f", 100.0)


def percent(key: str, heading: str) -> Column:
    """Column of signed shares that people read in per cent."""
    return Column(key, heading, "+.0%")


@dataclass(frozen=True)
class Table:
    """One table.

    Parameters
    ----------
    title : str
    columns : sequence of Column
    rows : list of tuple
        A value a column.
    notes : sequence of str
        Sentences below it.
    """

    title: str
    columns: Sequence[Column]
    rows: list[tuple[Value, ...]]
    notes: Sequence[str] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain values: each row by its columns' keys."""
        keys = [column.key for column in self.columns]
        return {
            "title": self.title,
            "rows": [dict(zip(keys, row, strict=True)) for row in self.rows],
            "notes": list(self.notes),
        }

    def shown(self) -> list[list[str]]:
        """Texts of every row, for people."""
        return [
            [column.shown(value) for column, value in zip(self.columns, row, strict=True)]
            for row in self.rows
        ]

    def as_markdown(self) -> str:
        """Markdown, its columns padded so that it reads as text, too."""
        if len(self.rows) > MOST_ROWS:
            return f"## {self.title}\n\n{len(self.rows)} rows, in the JSON file.\n"
        lines = [[column.heading for column in self.columns], *self.shown()]
        widths = [max(map(len, texts)) for texts in zip(*lines, strict=True)]
        numeric = [bool(column.form) for column in self.columns]
        padded = [
            "| "
            + " | ".join(
                text.rjust(width) if right else text.ljust(width)
                for text, width, right in zip(line, widths, numeric, strict=True)
            )
            + " |"
            for line in lines
        ]
        rule = "|".join(
            "-" * (width + 1) + (":" if right else "-")
            for width, right in zip(widths, numeric, strict=True)
        )
        body = "\n".join([padded[0], f"|{rule}|", *padded[1:]])
        notes = "".join(f"\n\n{note}" for note in self.notes)
        return f"## {self.title}\n\n{body}{notes}\n"


@dataclass(frozen=True)
class Report:
    """What an experiment found.

    Parameters
    ----------
    name : str
        Of the experiment.
    title : str
    made_with : dict
        Seed, budget, lambdas, bounds, hashes of inputs: all that the result depends on.
    tables : list of Table
    pictures : list of str
        Names of the files drawn beside it.
    notes : sequence of str
        What to know before reading a figure.
    films : sequence of str
        Files that only some machines can make; so they stand in no document.
    timings : sequence of Table
        Times on this machine: in a document of their own, so that the others are the same bytes
        anywhere.
    """

    name: str
    title: str
    made_with: dict[str, Any]
    tables: list[Table]
    pictures: list[str]
    notes: Sequence[str] = ()
    films: Sequence[str] = ()
    timings: Sequence[Table] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain values, as written to ``NAME.json``."""
        return {
            "schema": SCHEMA,
            "experiment": self.name,
            "title": self.title,
            "notes": list(self.notes),
            "made_with": self.made_with,
            "tables": [table.as_dict() for table in self.tables],
            "pictures": self.pictures,
        }

    def as_markdown(self) -> str:
        """Text of ``NAME.md``."""
        parts = [f"# {self.title}\n", *(f"{note}\n" for note in self.notes)]
        parts += [table.as_markdown() for table in self.tables]
        parts += [f"![{name}]({name})\n" for name in self.pictures]
        made = ", ".join(f"{key} {_plain(value)}" for key, value in self.made_with.items())
        return "\n".join([*parts, f"Made with: {made}.\n"])


def _plain(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_plain(part)}" for key, part in value.items())
    return str(value)


def write(report: Report, folder: Path) -> list[Path]:
    """Write a report as ``NAME.json`` and ``NAME.md``, its timings as ``NAME.times.json``.

    Parameters
    ----------
    report : Report
    folder : Path
        Must exist.

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        When they cannot be written.
    """
    texts = {
        folder / f"{report.name}.json": _json(report.as_dict()),
        folder / f"{report.name}.md": report.as_markdown(),
    }
    if report.timings:
        times = {"schema": SCHEMA, "tables": [table.as_dict() for table in report.timings]}
        texts[folder / f"{report.name}.times.json"] = _json(times)
    for path, text in texts.items():
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
    return list(texts)


def _json(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=1, allow_nan=False) + "\n"
