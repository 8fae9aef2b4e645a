"""What `armsyn track` tells as it goes: events, for people or for programs."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections import Counter
from typing import Any

import click

from armsyn.cli.track_words import event_text, printable
from armsyn.errors import ArmsynError

_MOST_KEPT = 720_000
"""Ticks, and targets, that are kept for a plot: an hour at 200 Hz, as recordings keep."""

REFUSALS = ("malformed", "refused")


class Teller:
    """Tells people, or programs, what happens.

    Once nobody reads the standard output any more, or it takes no more, it goes on in silence: the
    arm follows its targets, not its listeners.

    Parameters
    ----------
    as_json : bool
        Every event is one line of JSON on standard output; refusals stand on standard error, too.
    keeping : bool
        Whether to keep what a plot shows.

    Attributes
    ----------
    counts : Counter of str
        How often each kind of event was told.
    accepted : list of dict
        Events of targets that were accepted, of the first `_MOST_KEPT`.
    lost : OSError or None
        Why the standard output takes no more.
    ticks : list of float
        Path time at each tick, s, of the first that are recorded: it does not jump over missed
        ticks, as the clock of the recording does.
    """

    def __init__(self, *, as_json: bool, keeping: bool) -> None:
        self.as_json = as_json
        self.counts: Counter[str] = Counter()
        self.accepted: list[dict[str, Any]] = []
        self.lost: OSError | None = None
        self.ticks: list[float] = []
        self._left = _MOST_KEPT if keeping else 0

    def tick(self, path_time: float, _: float) -> None:
        """Keep the path time of a tick."""
        if len(self.ticks) < self._left:
            self.ticks.append(path_time)

    def tell(self, event: dict[str, Any]) -> None:
        """Tell what happened to a target."""
        kind = event["event"]
        self.counts[kind] += 1
        if kind == "accepted" and len(self.accepted) < self._left:
            self.accepted.append(event)
        if kind in REFUSALS:
            self.complain(f"line {event['line']}: {event['reason']}")
        if self.as_json:
            self.line(event)
        elif kind not in REFUSALS:
            self.say(event_text(event))

    def line(self, content: dict[str, Any]) -> None:
        """Print one line of JSON."""
        self.say(json.dumps(content, allow_nan=False))

    def say(self, text: str) -> None:
        """Print a line, if somebody reads it."""
        try:
            click.echo(printable(text, sys.stdout.encoding))
        except OSError as error:
            if not isinstance(error, BrokenPipeError):
                self.lost = error
            silence = os.open(os.devnull, os.O_WRONLY)
            os.dup2(silence, sys.stdout.fileno())  # nor at the end, when what is left is flushed
            os.close(silence)

    def complain(self, text: str) -> None:
        """Print a line on standard error, if that takes it: there is nowhere to say otherwise."""
        with contextlib.suppress(OSError):
            click.echo(f"armsyn: {printable(text, sys.stderr.encoding)}", err=True)

    def fault(self, error: ArmsynError) -> None:
        """Tell how the command failed, as one line of JSON and one for people."""
        said = " ".join(str(error).split())
        self.complain(said)
        found = {"type": type(error).__name__, "message": said, "exit_status": error.exit_status}
        self.line({"event": "failed", "error": found})
