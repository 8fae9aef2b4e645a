"""`armsyn record`: an arm recorded without moving it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.arm_options import arm_options, connected
from armsyn.cli.choices import FiniteRange

if TYPE_CHECKING:
    from collections.abc import Callable

    from armsyn.driver import Recording
    from armsyn.driver.observe import Observer

NOBODY_MOVES = (
    "Nothing is written to the servos. Move the limp arm by hand meanwhile (`armsyn release` lets"
    " go of one that holds)."
)


@click.command()
@arm_options
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    required=True,
    metavar="FILE",
    help="Where the recording goes (.npz or .csv).",
)
@click.option("--seconds", type=float, metavar="S", help="How long.  [default: until Ctrl-C]")
@click.option(
    "--rate",
    "rate_hz",
    type=FiniteRange(1.0, 1000.0),
    default=100.0,
    show_default=True,
    help="Looks a second.",
)
def record(**options: Any) -> None:
    """Record an arm without moving it.

    Nothing is written to the servos: an arm that holds goes on holding, a limp one can be moved by
    hand, and `armsyn stream` plays the file back. The port is this program's alone meanwhile:
    an arm that another program moves cannot be recorded beside it; that program records itself
    (--record). Looking feeds the servos' bus watchdogs, so that those which a fault left armed do
    not expire meanwhile.

    Rows go to the disk as they come, off the loop; a disk that is slow or full costs rows, which
    are counted, and nothing else.
    """
    from armsyn.driver import check_recording_path, save_recording
    from armsyn.driver.monitor import ArmMonitor
    from armsyn.driver.observe import Observer

    check_recording_path(options["out"])
    with connected(options) as there, ArmMonitor.open(there.port, there.arm) as monitor:
        observer = Observer(
            monitor,
            options["rate_hz"],
            options["out"].parent,
            simulated=there.simulated,
        )
        until = "Ctrl-C ends it" if options["seconds"] is None else f"{options['seconds']:g} s"
        click.echo(f"recording at {options['rate_hz']:g} Hz ({until}). {NOBODY_MOVES}", err=True)
        recording = _recorded(observer, options["seconds"])
    save_recording(options["out"], recording, there.arm)
    _report(recording, options)


def _recorded(observer: Observer, seconds: float | None) -> Recording:
    """Record, with a bar on a terminal."""
    from armsyn.cli.moving import with_progress

    def run(show: Callable[[float, float], None] | None) -> Recording:
        if show is None or seconds is None:
            return observer.record(seconds)
        return observer.record(seconds, lambda time: show(time, seconds))

    return with_progress(run)


def _report(recording: Recording, options: dict[str, Any]) -> None:
    import json

    import numpy as np

    lost = float(np.mean(recording.stale.any(axis=1)))
    if options["as_json"]:
        document = {
            "arm": recording.arm,
            "port": recording.port,
            "simulated": recording.simulated,
            "ticks": recording.ticks,
            "missed_ticks": recording.missed_ticks,
            "dropped_rows": recording.dropped_rows,
            "incomplete": lost,
            "seconds": float(recording.time_s[-1]),
            "events": [f"{event.time:.3f} s: {event.text}" for event in recording.events],
            "record": str(options["out"]),
        }
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    click.echo(
        f"recording: {options['out']}, {recording.ticks} looks in {recording.time_s[-1]:.1f} s,"
        f" {recording.missed_ticks} missed, {lost:.1%} with a reply lost"
    )
    moved = np.degrees(np.nanmax(recording.measured_rad, 0) - np.nanmin(recording.measured_rad, 0))
    for name, degrees in zip(recording.joint_names, moved, strict=True):
        click.echo(f"  {name}: moved over {degrees:.1f} degrees")
    for event in recording.events:
        click.echo(f"  {event.time:.3f} s: {event.text}")
