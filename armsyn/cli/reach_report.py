"""What `armsyn reach` tells: the summary, as text or JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.cli.json_errors import DocumentedError
from armsyn.cli.orientation_options import asked
from armsyn.cli.reach_run import Done
from armsyn.driver import Ending
from armsyn.errors import ArmFaultError, FormatError, InputError
from armsyn.motion import FloatArray, Motion
from armsyn.planning import PlannedReach
from armsyn.planning.posing import HandTask
from armsyn.scoring import ProfileMeasures, correlation, measure, normalised_speed

STOPPED = 130
STOPS = {Ending.STOPPED_HOLDING, Ending.STOPPED_PARKED, Ending.ABORTED}


def report(
    done: Done,
    *,
    record: Path | None,
    plot: Path | None,
    as_json: bool,
    failed: InputError | None = None,
) -> int:
    """Print the summary.

    Parameters
    ----------
    done : Done
    record, plot : Path or None
        Files that were written.
    as_json : bool
    failed : InputError, optional
        Why a file could not be written.

    Returns
    -------
    int
        Exit status: 0; 130 when the run was stopped on request, 3 when parking missed.

    Raises
    ------
    InputError, DocumentedError
        `failed`, after the summary or with it in one document.
    """
    document = summary(done)
    document["record"] = None if record is None else str(record)
    document["plot"] = None if plot is None else str(plot)
    if failed is not None and as_json:
        raise DocumentedError(failed, document)
    if as_json:
        click.echo(json.dumps(document, indent=2, allow_nan=False))
    else:
        _print(document)
    if failed is not None:
        raise failed
    if done.recording.ending is Ending.PARK_MISSED:
        return ArmFaultError.exit_status
    return STOPPED if done.recording.ending in STOPS else 0


def summary(done: Done) -> dict[str, Any]:
    """Return what is known of a reach, ready for JSON.

    Parameters
    ----------
    done : Done

    Returns
    -------
    dict
        Measures are of measured positions, filtered as `armsyn.scoring` says; None where the
        reach was stopped before they could be taken.
    """
    recording = done.recording
    measured: Motion | str
    try:
        measured = recording.measured_motion(done.arm)
    except FormatError as error:  # stopped before the arm could answer
        measured = str(error)
    split = arrival_row(done)
    if recording.ending in STOPS and not _was_there(recording.commanded_rad, done.out.trajectory):
        measured = "the reach was stopped before its end"
    tracking = recording.tracking_rms()
    document: dict[str, Any] = {
        "arm": recording.arm,
        "port": recording.port,
        "simulated": recording.simulated,
        "ending": recording.ending.value,
        **_leg(done.out, measured, done.arm, slice(0, split + 1)),
        "tracking_rms_rad": tracking if np.isfinite(tracking) else None,
        "ticks": recording.ticks,
        "missed_ticks": recording.missed_ticks,
        "command_success_rate": recording.command_success_rate,
        "rate_hz": recording.rate_hz,
        "events": [f"{event.time:.3f} s: {event.text}" for event in recording.events],
    }
    if done.back is not None:
        rows = slice(split, return_row(done) + 1)
        document["return"] = _leg(done.back, measured, done.arm, rows)
    return document


def arrival_row(done: Done) -> int:
    """Last row of the recording at which the reach's end was commanded; the last row if never."""
    return _last_row_at(done.recording.commanded_rad, done.out.trajectory)


def return_row(done: Done) -> int:
    """Last row at which the return's end was commanded; the last row if never."""
    assert done.back is not None  # noqa: S101 - asked for only with a way back
    return _last_row_at(done.recording.commanded_rad, done.back.trajectory)


def _last_row_at(commanded: FloatArray, trajectory: Motion) -> int:
    there = _rows_at_end(commanded, trajectory)
    return int(there[-1]) if there.size else commanded.shape[0] - 1


def _was_there(commanded: FloatArray, trajectory: Motion) -> bool:
    return _rows_at_end(commanded, trajectory).size > 0


def _rows_at_end(commanded: FloatArray, trajectory: Motion) -> NDArray[np.intp]:
    assert trajectory.angles is not None  # noqa: S101 - planned
    return np.flatnonzero(np.abs(commanded - trajectory.angles[-1]).max(axis=1) < 1e-9)


def _leg(
    planned: PlannedReach, measured: Motion | str, arm: ArmDescription, rows: slice
) -> dict[str, Any]:
    document: dict[str, Any] = {
        "target_m": planned.target.tolist(),
        "hand_error_m": None,
        "plan": planned.plan,
        "captured": None if planned.learned is None else planned.learned.name,
        "captured_rank": None if planned.synergy is None else planned.rank,
        "ik": None if planned.synergy is None else planned.synergy.ik,
        "model": None if planned.synergy is None else planned.synergy.model,
        "outside_m": planned.outside_m,
        "predicted_time_s": planned.duration_s,
        "time_scale": planned.time_scale,
        "planned_time_s": planned.trajectory.duration,
        "planned_error_m": planned.error_m,
        "swivel_m": planned.swivel_m,
        "evened": planned.evened,
        "first_refused": planned.refused or None,
        "planned_speed_peaks": _planned_peaks(planned),
        "orientation": asked(planned.orientation),
        "orientation_error_rad": None,
    }
    keys = ("movement_time_s", "speed_peaks", "time_to_peak", "peak_over_mean", "min_jerk_r")
    document |= dict.fromkeys((*keys, "sparc", "captured_r"))
    if isinstance(measured, str):
        return document | {"not_measured": measured}
    document["hand_error_m"] = float(np.linalg.norm(measured.hand[rows][-1] - planned.target))
    if planned.orientation is not None and measured.angles is not None:
        task = HandTask(planned.target, planned.orientation)
        document["orientation_error_rad"] = task.errors(arm.chain, measured.angles[rows][-1])[1]
    try:
        taken = measured.between(rows.start, rows.stop - 1)
        found = measure(taken)
        document |= _measures(found)
        if planned.learned is not None:
            document["captured_r"] = correlation(
                np.array(planned.learned.speed_profile), normalised_speed(taken.time, taken.hand)
            )
    except InputError as error:
        document["not_measured"] = str(error)
    return document


def _planned_peaks(planned: PlannedReach) -> int | None:
    """How often the planned hand speeds up; None for a hand that stays."""
    try:
        return measure(planned.trajectory).speed_peaks
    except InputError:
        return None


def _measures(found: ProfileMeasures) -> dict[str, Any]:
    return {
        "movement_time_s": found.movement_time,
        "speed_peaks": found.speed_peaks,
        "time_to_peak": found.time_to_peak,
        "peak_over_mean": found.peak_over_mean,
        "min_jerk_r": found.min_jerk_r,
        "sparc": found.sparc,
        "speed_rate_hz": found.rate,
        "speed_filter_hz": found.cutoff,
        "speed_cut": found.cut_fraction,
    }


def _print(document: dict[str, Any]) -> None:
    where = " (the simulated arm ends with this command)" if document["simulated"] else ""
    ended = f"ended: {document['ending']}{where}"
    stopped = Ending(document["ending"]) in STOPS
    if stopped:  # it is no reach that measures could be taken of
        click.echo(ended)
    else:
        click.echo(_leg_text("reach", document))
        if "return" in document:
            click.echo(_leg_text("return", document["return"]))
    rms = document["tracking_rms_rad"]
    tracking = "unknown" if rms is None else f"{rms:.4f} rad rms"
    click.echo(
        f"stream: {document['ticks']} ticks at {document['rate_hz']:g} Hz,"
        f" {document['missed_ticks']} missed, success {document['command_success_rate']:.2f} of"
        " the last 100,"
        f" tracking {tracking}"
    )
    if not stopped:
        click.echo(ended)
    for key, what in (("record", "recording"), ("plot", "plot")):
        if document[key]:
            click.echo(f"{what}: {document[key]}")


def _leg_text(name: str, leg: dict[str, Any]) -> str:
    miss = leg["hand_error_m"]
    error = "an unknown distance" if miss is None else f"{miss * 1000:.1f} mm"
    turned = leg["orientation_error_rad"]
    if turned is not None:
        error += f" and {np.degrees(turned):.1f} degrees"
    lines = [
        f"{name}: hand {error} from its target, {_manner(leg)}, {leg['time_scale']:.2f} times"
        " slower"
    ]
    if leg["captured_rank"]:
        lines.append(f"  ({leg['captured_rank']} nearer learned reaches would miss the target)")
    if leg["movement_time_s"] is not None:
        # A rule's own time is no person's: nothing captured tells it
        known = leg["plan"] != "minjerk"
        person = f" (a person: {leg['predicted_time_s']:.2f} s)" if known else ""
        beside = "" if leg["captured_r"] is None else f", with the capture {leg['captured_r']:.2f}"
        lines.append(
            f"  {leg['movement_time_s']:.2f} s{person},"
            f" {leg['speed_peaks']} speed peak(s), peak at"
            f" {leg['time_to_peak']:.2f} of the time, peak/mean {leg['peak_over_mean']:.2f};"
            f" r with minimum jerk {leg['min_jerk_r']:.2f}{beside}; SPARC {leg['sparc']:.2f}"
        )
    else:
        lines.append(f"  speed not measured: {leg['not_measured']}")
    return "\n".join(lines)


def _manner(leg: dict[str, Any]) -> str:
    """After what a reach was planned."""
    if leg["model"] == "A":
        pace = f"learned from {leg['captured']}" if leg["captured"] else "of no capture"
        return f"raw controller (no synergy) at the pace {pace}"
    if leg["model"] is not None:
        return f"like {leg['captured']}"
    if leg["captured"] is None:
        return f"planned by {leg['plan']}"
    return f"planned by {leg['plan']} (nearest capture: {leg['captured']})"
