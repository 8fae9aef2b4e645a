"""What `armsyn reach` tells: the summary, as text or JSON, and the plot of the hand's speed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from armsyn.cli.json_errors import DocumentedError
from armsyn.cli.reach import Done
from armsyn.driver import Ending
from armsyn.errors import ArmFaultError, FormatError, InputError, RefusedMotionError
from armsyn.motion import FloatArray, Motion
from armsyn.planning import PlannedReach, ReachPlanner
from armsyn.scoring import ProfileMeasures, correlation, measure, movement, normalised_speed

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
        **_leg(done.out, measured, slice(0, split + 1)),
        "tracking_rms_rad": tracking if np.isfinite(tracking) else None,
        "ticks": recording.ticks,
        "missed_ticks": recording.missed_ticks,
        "command_success_rate": recording.command_success_rate,
        "rate_hz": recording.rate_hz,
        "events": [f"{event.time:.3f} s: {event.text}" for event in recording.events],
    }
    if done.back is not None:
        document["return"] = _leg(done.back, measured, slice(split, return_row(done) + 1))
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


def _leg(planned: PlannedReach, measured: Motion | str, rows: slice) -> dict[str, Any]:
    document: dict[str, Any] = {
        "target_m": planned.target.tolist(),
        "hand_error_m": None,
        "captured": planned.learned.name,
        "captured_rank": planned.rank,
        "ik": planned.synergy.ik,
        "model": planned.synergy.model,
        "time_scale": planned.time_scale,
        "planned_time_s": planned.trajectory.duration,
    }
    keys = ("movement_time_s", "speed_peaks", "time_to_peak", "peak_over_mean", "min_jerk_r")
    document |= dict.fromkeys((*keys, "sparc", "captured_r"))
    if isinstance(measured, str):
        return document | {"not_measured": measured}
    document["hand_error_m"] = float(np.linalg.norm(measured.hand[rows][-1] - planned.target))
    try:
        taken = measured.between(rows.start, rows.stop - 1)
        found = measure(taken)
        document |= _measures(found)
        document["captured_r"] = correlation(
            np.array(planned.learned.speed_profile), normalised_speed(taken.time, taken.hand)
        )
    except InputError as error:
        document["not_measured"] = str(error)
    return document


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
    manner = f"like {leg['captured']}"
    if leg["model"] == "A":
        manner = f"raw controller (no synergy) at the pace learned from {leg['captured']}"
    miss = leg["hand_error_m"]
    error = "an unknown distance" if miss is None else f"{miss * 1000:.1f} mm"
    lines = [
        f"{name}: hand {error} from its target, {manner}, {leg['time_scale']:.2f} times slower"
    ]
    if leg["captured_rank"]:
        lines.append(f"  ({leg['captured_rank']} nearer learned reaches would miss the target)")
    if leg["movement_time_s"] is not None:
        lines.append(
            f"  {leg['movement_time_s']:.2f} s, {leg['speed_peaks']} speed peak(s), peak at"
            f" {leg['time_to_peak']:.2f} of the time, peak/mean {leg['peak_over_mean']:.2f};"
            f" r with minimum jerk {leg['min_jerk_r']:.2f}, with the capture"
            f" {leg['captured_r']:.2f}; SPARC {leg['sparc']:.2f}"
        )
    else:
        lines.append(f"  speed not measured: {leg['not_measured']}")
    return "\n".join(lines)


def draw_speeds(path: Path, done: Done, planner: ReachPlanner) -> None:
    """Draw the hand's speed: captured, planned, measured, and the raw controller's.

    Parameters
    ----------
    path : Path
        PNG to write.
    done : Done
    planner : ReachPlanner

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    from matplotlib.figure import Figure

    from armsyn.motion.formats.files import replacing

    if done.recording.ending in STOPS:
        raise InputError(f"{path}: not drawn, for the reach was stopped")
    figure = Figure(figsize=(8, 4.5), layout="constrained")
    axes = figure.add_subplot()
    split = arrival_row(done)
    measured = done.recording.measured_motion(done.arm).between(0, split)
    _draw_captured(axes, done, measured)
    _draw(axes, done.out.trajectory, "planned", color="tab:blue", linestyle="--")
    kind = "simulated" if done.recording.simulated else done.recording.port
    _draw(axes, measured, f"measured ({kind})", color="tab:red")
    raw = _raw(done, planner) if planner.model != "A" else None
    if raw is not None:
        _draw(axes, raw, "raw controller (S_A), planned", color="k", linestyle=":")
    highest = max(float(np.max(np.asarray(line.get_ydata()))) for line in axes.get_lines())
    axes.set(xlabel="time, s", ylabel="hand speed, m/s")
    axes.set(xlim=(0, 1.3 * measured.time[-1]), ylim=(0, 1.4 * highest or 0.1))
    x, y, z = done.out.target
    axes.set_title(f"{done.arm.name} ({kind}) reaches for ({x:.2f}, {y:.2f}, {z:.2f}) m")
    axes.legend(loc="upper right")
    axes.grid(visible=True, alpha=0.3)
    with replacing(path) as temporary:
        figure.savefig(temporary, format="png", dpi=120)


def _draw_captured(axes: Any, done: Done, measured: Motion) -> None:
    """Draw the capture's profile over the measured duration, scaled to the same path length."""
    try:
        moved = movement(measured.time, measured.hand)
    except InputError as error:
        click.echo(f"no capture in the plot: {error}", err=True)
        return
    profile = np.array(done.out.learned.speed_profile)
    duration = moved.time[-1] - moved.time[0]
    scale = np.trapezoid(moved.speed, moved.time) / (np.trapezoid(profile, dx=0.01) * duration)
    axes.plot(
        moved.time[0] + np.linspace(0.0, 1.0, profile.size) * duration,
        profile * scale,
        color="0.6",
        linewidth=5,
        label=f"captured: {done.out.learned.name} (same duration and path)",
    )


def _draw(axes: Any, motion: Motion, label: str, **style: Any) -> None:
    from armsyn.motion.filtering import hand_speed

    found = hand_speed(motion.time, motion.hand)
    inside = (found.time >= motion.time[0]) & (found.time <= motion.time[-1])
    axes.plot(found.time[inside], found.speed[inside], label=label, **style)


def _raw(done: Done, planner: ReachPlanner) -> Motion | None:
    """Plan the same reach without synergy; None where that fails (it is drawn, not moved)."""
    try:
        raw = ReachPlanner(planner.arm, planner.library, planner.ik, "A")
        planned = raw.plan(done.start, done.out.target)
    except (RefusedMotionError, InputError) as error:
        click.echo(f"no raw controller in the plot: {error}", err=True)
        return None
    return planned.trajectory
