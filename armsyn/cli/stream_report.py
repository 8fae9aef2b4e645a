"""What `armsyn stream` tells: what to expect of a motion, and what came of it."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import click
import numpy as np

from armsyn.arm import ArmDescription
from armsyn.cli.json_errors import DocumentedError
from armsyn.cli.moving import status_of
from armsyn.driver import Recording, save_recording
from armsyn.driver.replay import Expected, Replay, expect
from armsyn.errors import InputError
from armsyn.motion import Motion


def print_expected(
    replay: Replay, arm: ArmDescription, way: Motion | None, options: dict[str, Any]
) -> None:
    """Say what a motion asks of an arm; it is checked already.

    Parameters
    ----------
    replay : Replay
    arm : ArmDescription
    way : Motion or None
        From where the arm is to where the motion starts.
    options : dict
    """
    expected = expect(replay.motion, arm)
    if options["as_json"]:
        document = _document(expected, arm) | {
            "file": str(options["file"]),
            "made_of": replay.what,
            "approach_s": None if way is None else way.duration,
        }
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    click.echo(f"{options['file']}: {replay.what}, {expected.duration:.2f} s on {arm.name}")
    for row, name in enumerate(arm.joint_names):
        speed = expected.speed[row] / arm.max_velocity[row]
        acceleration = expected.acceleration[row] / arm.max_acceleration[row]
        click.echo(
            f"  {name}: {math.degrees(expected.lowest[row]):.1f} to"
            f" {math.degrees(expected.highest[row]):.1f} degrees,"
            f" {speed:.0%} of its speed, {acceleration:.0%} of its acceleration"
        )
    if expected.nearest is not None:
        near = expected.nearest
        click.echo(f"nearest: {near.first} and {near.second}, {near.distance * 1000:.0f} mm")
    if way is not None:
        click.echo(f"before it: a straight way of {way.duration:.2f} s to where it starts")
    click.echo("all checks passed; nothing has moved (dry run)")


def _document(expected: Expected, arm: ArmDescription) -> dict[str, Any]:
    joints = {
        name: {
            "lowest_rad": float(expected.lowest[row]),
            "highest_rad": float(expected.highest[row]),
            "speed_rad_s": float(expected.speed[row]),
            "acceleration_rad_s2": float(expected.acceleration[row]),
        }
        for row, name in enumerate(arm.joint_names)
    }
    near = expected.nearest
    return {
        "arm": arm.name,
        "duration_s": expected.duration,
        "joints": joints,
        "nearest": None
        if near is None
        else {"first": near.first, "second": near.second, "distance_m": near.distance},
    }


def report(
    recordings: Sequence[Recording], replay: Replay, arm: ArmDescription, options: dict[str, Any]
) -> int:
    """Say what came of it, and write the recording.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError, DocumentedError
        The recording cannot be written; said after how the arm was left, or in one document.
    """
    last = recordings[-1]
    failed: InputError | None = None
    if options["record"]:
        try:
            save_recording(options["record"], last, arm)
        except InputError as error:
            failed = error
    if options["as_json"]:
        document = _result(last, replay, arm, options)
        if failed is not None:
            raise DocumentedError(failed, document | {"record": None})
        click.echo(json.dumps(document, indent=2, allow_nan=False))
    else:
        _print_result(last, replay, arm, options, written=failed is None)
    if failed is not None:
        raise failed
    return status_of(last.ending)


def _end_error(recording: Recording, replay: Replay, arm: ArmDescription) -> float | None:
    """Distance of the hand from where the motion ends, m; None where it was not there."""
    assert replay.motion.angles is not None  # noqa: S101 - of a replay
    goal = replay.motion.angles[-1]
    there = np.abs(recording.commanded_rad - goal).max(axis=1) < 1e-9
    rows = np.flatnonzero(there & ~recording.stale.any(axis=1))
    if not rows.size:
        return None
    measured = arm.chain.forward(recording.measured_rad[rows[-1]]).tip
    return float(np.linalg.norm(measured - arm.chain.forward(goal).tip))


def _result(
    recording: Recording, replay: Replay, arm: ArmDescription, options: dict[str, Any]
) -> dict[str, Any]:
    rms = recording.tracking_rms()
    return {
        "file": str(options["file"]),
        "made_of": replay.what,
        "arm": recording.arm,
        "port": recording.port,
        "simulated": recording.simulated,
        "ending": recording.ending.value,
        "hand_error_m": _end_error(recording, replay, arm),
        "tracking_rms_rad": rms if math.isfinite(rms) else None,
        "ticks": recording.ticks,
        "missed_ticks": recording.missed_ticks,
        "command_success_rate": recording.command_success_rate,
        "rate_hz": recording.rate_hz,
        "events": [f"{event.time:.3f} s: {event.text}" for event in recording.events],
        "record": None if options["record"] is None else str(options["record"]),
    }


def _print_result(
    recording: Recording,
    replay: Replay,
    arm: ArmDescription,
    options: dict[str, Any],
    *,
    written: bool,
) -> None:
    error = _end_error(recording, replay, arm)
    where = "not at its end" if error is None else f"hand {error * 1000:.1f} mm from its end"
    click.echo(f"stream of {options['file']} ({replay.what}): {where}")
    click.echo(
        f"  {recording.ticks} ticks at {recording.rate_hz:g} Hz, {recording.missed_ticks} missed,"
        f" success {recording.command_success_rate:.2f} of the last 100, tracking"
        f" {recording.tracking_rms():.4f} rad rms"
    )
    for event in recording.events:
        if event.level != "info":
            click.echo(f"  {event.time:.3f} s: {event.text}")
    after = " (the simulated arm ends with this command)" if recording.simulated else ""
    click.echo(f"ended: {recording.ending.value}{after}")
    if options["record"] and written:
        click.echo(f"recording: {options['record']}")


def keep(recordings: Sequence[Recording], arm: ArmDescription, options: dict[str, Any]) -> None:
    """Write what was recorded of a run that failed; what it failed of is the error to end with."""
    if not (recordings and options["record"]):
        return
    try:
        save_recording(options["record"], recordings[-1], arm)
    except InputError as error:
        click.echo(f"nothing recorded: {error}", err=True)
    else:
        click.echo(f"what was recorded until then: {options['record']}", err=True)
