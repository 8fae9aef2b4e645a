"""What `armsyn track` tells: events as they come, what came of it, and the plot."""

from __future__ import annotations

import json
import math
import os
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import numpy as np

from armsyn.arm import ArmDescription
from armsyn.cli.moving import status_of
from armsyn.driver import Ending, Recording, save_recording
from armsyn.errors import ArmsynError, InputError, UnreachableError

_MOST_LINES = 30
"""Targets whose beginnings are marked in a plot; more would hide it."""

_MOST_KEPT = 720_000
"""Ticks, and targets, that are kept for a plot: an hour at 200 Hz, as recordings keep."""

REFUSALS = ("malformed", "refused")


class Teller:
    """Tells people, or programs, what happens.

    Once nobody reads the standard output any more, it goes on in silence: the arm follows its
    targets, not its listeners.

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
    ticks : list of float
        Path time at each tick, s, of the first that are recorded: it does not jump over missed
        ticks, as the clock of the recording does.
    """

    def __init__(self, *, as_json: bool, keeping: bool) -> None:
        self.as_json = as_json
        self.counts: Counter[str] = Counter()
        self.accepted: list[dict[str, Any]] = []
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
            click.echo(f"armsyn: line {event['line']}: {event['reason']}", err=True)
        if self.as_json:
            self.line(event)
        elif kind not in REFUSALS:
            self.say(_text(event))

    def line(self, content: dict[str, Any]) -> None:
        """Print one line of JSON."""
        self.say(json.dumps(content, allow_nan=False))

    def say(self, text: str) -> None:
        """Print a line, if somebody reads it."""
        try:
            click.echo(text)
        except BrokenPipeError:
            silence = os.open(os.devnull, os.O_WRONLY)
            os.dup2(silence, sys.stdout.fileno())  # nor at the end, when what is left is flushed
            os.close(silence)

    def fault(self, error: ArmsynError) -> None:
        """Tell how the command failed, as one line of JSON and one for people."""
        said = " ".join(str(error).split())
        click.echo(f"armsyn: {said}", err=True)
        found = {"type": type(error).__name__, "message": said, "exit_status": error.exit_status}
        self.line({"event": "failed", "error": found})


def _text(event: dict[str, Any]) -> str:
    if event["event"] == "ready":
        return "ready: waiting for targets"
    name = f"line {event['line']}" + ("" if event["id"] is None else f" ({event['id']})")
    match event["event"]:
        case "accepted":
            where = "({:.3f}, {:.3f}, {:.3f}) m".format(*event["target_m"])
            return (
                f"{event['t_s']:8.3f} s  {name}: to {where}, like {event['like']},"
                f" {event['time_scale']:.2f} times slower, about {event['expected_s']:.2f} s"
            )
        case "arrived" | "missed" as how:
            took = f"{event['error_mm']:.1f} mm from it after {event['time_s']:.2f} s"
            return f"{event['t_s']:8.3f} s  {name}: {how}, {took}"
        case "replaced":
            left = f"still {event['error_mm']:.0f} mm away"
            return f"{event['t_s']:8.3f} s  {name}: left for another, {left}"
        case _:
            return f"            {name}: passed over for a newer one"


def check_plot(path: Path | None) -> None:
    """Refuse a place that cannot be drawn to, before anything moves; InputError."""
    if path and (path.suffix.lower() != ".png" or not path.parent.is_dir()):
        raise InputError(f"--plot {path}: must end in .png, in a folder that exists")


def finish(
    recording: Recording,
    ending: Ending,
    arm: ArmDescription,
    teller: Teller,
    options: dict[str, Any],
) -> int:
    """Write the files, and say what came of it.

    Parameters
    ----------
    recording : Recording
        Of the tracking; parking is not in it.
    ending : Ending
        How the arm was left.
    arm : ArmDescription
    teller : Teller
    options : dict

    Returns
    -------
    int
        Exit status: 0; 130 when it was stopped on request, 3 when parking missed; where no line
        held a target that could be followed, 2 (no target at all) or 4.

    Raises
    ------
    InputError
        The first file that cannot be written, after all else is said.
    """
    failed: list[InputError] = []
    written: dict[str, str | None] = {"record": None, "plot": None}
    writers: dict[str, Callable[[Path], None]] = {
        "record": lambda path: save_recording(path, recording, arm),
        "plot": lambda path: draw(path, recording, arm, teller),
    }
    for kind, write in writers.items():
        if options[kind]:
            try:
                write(options[kind])
                written[kind] = str(options[kind])
            except InputError as error:
                failed.append(error)
    _say_end(recording, ending, teller, written)
    if failed:
        raise failed[0]
    return status_of(ending) or _status_of_lines(teller)


def _status_of_lines(teller: Teller) -> int:
    counts = teller.counts
    if counts["accepted"] or not (counts["refused"] or counts["malformed"]):
        return 0
    return UnreachableError.exit_status if counts["refused"] else InputError.exit_status


def _say_end(
    recording: Recording, ending: Ending, teller: Teller, written: dict[str, str | None]
) -> None:
    rms = recording.tracking_rms()
    kinds = ("accepted", "arrived", "missed", "replaced", "passed_over", *REFUSALS)
    counts = {kind: teller.counts[kind] for kind in kinds}
    if teller.as_json:
        teller.line(
            {
                "event": "ended",
                "arm": recording.arm,
                "port": recording.port,
                "simulated": recording.simulated,
                "ending": ending.value,
                "targets": counts,
                "ticks": recording.ticks,
                "missed_ticks": recording.missed_ticks,
                "command_success_rate": recording.command_success_rate,
                "tracking_rms_rad": rms if math.isfinite(rms) else None,
                "rate_hz": recording.rate_hz,
                "events": [f"{event.time:.3f} s: {event.text}" for event in recording.events],
                **written,
            }
        )
        return
    told = ", ".join(f"{count} {kind.replace('_', ' ')}" for kind, count in counts.items() if count)
    teller.say(f"targets: {told or 'none'}")
    teller.say(
        f"stream: {recording.ticks} ticks at {recording.rate_hz:g} Hz, {recording.missed_ticks}"
        f" missed, success {recording.command_success_rate:.2f} of the last 100, tracking"
        f" {'unknown' if not math.isfinite(rms) else f'{rms:.4f} rad rms'}"
    )
    for event in recording.events:
        if event.level != "info":
            teller.say(f"  {event.time:.3f} s: {event.text}")
    after = " (the simulated arm ends with this command)" if recording.simulated else ""
    teller.say(f"ended: {ending.value}{after}")
    for kind, what in (("record", "recording"), ("plot", "plot")):
        if written[kind]:
            teller.say(f"{what}: {written[kind]}")


def draw(path: Path, recording: Recording, arm: ArmDescription, teller: Teller) -> None:
    """Draw targets and hand over time, and the hand's speed.

    Parameters
    ----------
    path : Path
        PNG to write.
    recording : Recording
    arm : ArmDescription
    teller : Teller
        That was told of the targets.

    Raises
    ------
    InputError
        When the file cannot be written, or there is too little to draw.
    """
    from matplotlib.figure import Figure

    from armsyn.motion.filtering import hand_speed
    from armsyn.motion.formats.files import replacing

    measured = recording.measured_motion(arm)
    figure = Figure(figsize=(8, 7), layout="constrained")
    places, speeds = figure.subplots(2, 1, sharex=True)
    turns = teller.accepted
    rows = min(len(teller.ticks), recording.time_s.size)
    begins = np.interp(
        [event["t_s"] for event in turns], teller.ticks[:rows], recording.time_s[:rows]
    )
    ends = [*begins[1:], float(measured.time[-1])]
    for axis, colour in enumerate(("tab:red", "tab:green", "tab:blue")):
        places.plot(
            measured.time, measured.hand[:, axis], color=colour, label=f"hand {'xyz'[axis]}"
        )
        for turn, begin, end in zip(turns, begins, ends, strict=True):
            height = turn["target_m"][axis]
            places.plot([begin, end], [height, height], color=colour, linestyle=":")
    commanded = arm.chain.positions(recording.commanded_rad)[:, -1]
    for what, hand, style in (
        ("commanded", commanded, {"color": "tab:blue", "linestyle": "--"}),
        ("measured", measured.hand, {"color": "tab:red"}),
    ):
        time = recording.time_s if what == "commanded" else measured.time
        found = hand_speed(time, hand)
        inside = (found.time >= time[0]) & (found.time <= time[-1])
        speeds.plot(found.time[inside], found.speed[inside], label=what, **style)
    for begin in begins[: _MOST_LINES if len(begins) <= _MOST_LINES else 0]:
        for axes in (places, speeds):
            axes.axvline(begin, color="0.8", linewidth=1, zorder=0)
    kind = "simulated" if recording.simulated else recording.port
    places.set(ylabel="m, base frame", title=f"{arm.name} ({kind}) follows its targets (dotted)")
    speeds.set(xlabel="time, s", ylabel="hand speed, m/s", ylim=(0, None))
    for axes in (places, speeds):
        axes.legend(loc="upper right")
        axes.grid(visible=True, alpha=0.3)
    with replacing(path) as temporary:
        figure.savefig(temporary, format="png", dpi=120)
