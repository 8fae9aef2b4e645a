"""The table of servos on a terminal, drawn by a process of its own.

Drawing takes many milliseconds, an answer on the wire less than one: the simulator only sends
readings through a pipe (`table_feed`), which this module turns into a table:
``python -m firmware_sim.command.live_table`` reads a JSON document a line until its input ends.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Mapping
from typing import Any, TextIO

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table

COLUMNS = (
    ("ID", "right"),
    ("model", "left"),
    ("mode", "left"),
    ("torque", "left"),
    ("position", "right"),
    ("goal", "right"),
    ("velocity", "right"),
    ("load", "right"),
    ("temp", "right"),
    ("supply", "right"),
    ("errors", "left"),
    ("pkt/s", "right"),
    ("faults", "left"),
)
"""Headings and sides; a row has one text for each."""

_NARROW = 126
"""Below this width some columns are left out, characters."""

_LEFT_OUT = frozenset(("temp", "supply", "mode"))
_FRAME = 6
"""Lines of a table that are no servos: title, headings, rules and two lines of notes."""

_NICENESS = 10
_RED = frozenset(("errors", "faults"))


def draw(document: Mapping[str, Any], width: int, height: int = 1000) -> Table:
    """Return the table of one document.

    Parameters
    ----------
    document : mapping
        ``title`` (text), ``rows`` (lists of texts, one for each of `COLUMNS`) and ``note`` (text).
    width : int
        Of the terminal, characters.
    height : int
        Of the terminal, lines: of more servos than fit the first are shown, and the others counted.

    Returns
    -------
    rich.table.Table
        Without what does not fit.
    """
    shown = [
        place
        for place, (name, _) in enumerate(COLUMNS)
        if width >= _NARROW or name not in _LEFT_OUT
    ]
    rows = document["rows"]
    room = max(1, height - _FRAME)
    hidden = 0 if len(rows) <= room else len(rows) - room
    notes = [f"and {hidden} more servos"] if hidden else []
    notes += [document["note"]] if document["note"] else []
    table = Table(
        title=escape(document["title"]),
        caption=escape("; ".join(notes)) or None,
        box=SIMPLE_HEAD,
        padding=(0, 1 if width >= _NARROW else 0),
        pad_edge=False,
    )
    for place in shown:
        name, side = COLUMNS[place]
        table.add_column(
            name,
            justify="right" if side == "right" else "left",
            no_wrap=name not in _RED,  # these may be long, and are cut before others
            style="red" if name in _RED else None,
        )
    for row in rows[: len(rows) - hidden]:
        table.add_row(*(escape(str(row[place])) for place in shown))
    return table


def show(lines: TextIO, console: Console) -> None:
    """Draw each document that arrives, until there are no more.

    Parameters
    ----------
    lines : text file
        One JSON document a line.
    console : rich.console.Console
        Where to draw.
    """
    with Live(console=console, auto_refresh=False, redirect_stdout=False) as live:
        for line in lines:
            document = json.loads(line)
            live.update(draw(document, console.width, console.height), refresh=True)


def main() -> int:
    """Draw on standard error what standard input says; Ctrl-C is for the simulator."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(_NICENESS)
    show(sys.stdin, Console(stderr=True))
    return 0


if __name__ == "__main__":
    sys.exit(main())
