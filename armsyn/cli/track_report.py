"""What came of `armsyn track`: files, and the last words."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from armsyn.arm import ArmDescription
from armsyn.cli.moving import status_of
from armsyn.cli.track_plot import draw
from armsyn.cli.track_teller import REFUSALS, Teller
from armsyn.driver import Ending, Recording, save_recording
from armsyn.driver.recording import NEXT
from armsyn.errors import InputError, UnreachableError


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
    if teller.lost:
        said = f"standard output: {teller.lost.strerror}; what was told after that is lost"
        failed.append(InputError(said))
    if failed:
        raise failed[0]
    return status_of(ending) or status_of_lines(teller.counts)


def status_of_lines(counts: Counter[str]) -> int:
    """Exit status for what the lines held: 0, or, where there was no target to follow, 2 or 4."""
    if counts["accepted"] or not (counts["refused"] or counts["malformed"]):
        return 0
    return UnreachableError.exit_status if counts["refused"] else InputError.exit_status


def words_of(ending: Ending) -> str:
    """How the arm was left; at a target or short of it is told of each target."""
    if ending is Ending.COMPLETED:
        return f"at rest, torque on, holding; {NEXT}"
    return str(ending.value)


def _say_end(
    recording: Recording, ending: Ending, teller: Teller, written: dict[str, str | None]
) -> None:
    rms = recording.tracking_rms()
    kinds = ("accepted", "arrived", "missed", "replaced", "passed_over", "unfinished", *REFUSALS)
    counts = {kind: teller.counts[kind] for kind in kinds}
    if teller.as_json:
        teller.line(
            {
                "event": "ended",
                "arm": recording.arm,
                "port": recording.port,
                "simulated": recording.simulated,
                "ending": words_of(ending),
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
    teller.say(f"ended: {words_of(ending)}{after}")
    for kind, what in (("record", "recording"), ("plot", "plot")):
        if written[kind]:
            teller.say(f"{what}: {written[kind]}")
