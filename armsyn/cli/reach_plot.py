"""The plot of `armsyn reach`: the hand's speed, captured, planned, measured, and raw."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from armsyn.cli.reach_report import STOPS, arrival_row
from armsyn.cli.reach_run import Done
from armsyn.errors import InputError, RefusedMotionError
from armsyn.motion import Motion
from armsyn.planning import planner_for
from armsyn.scoring import movement


def draw_speeds(path: Path, done: Done, directory: Path | None = None) -> None:
    """Draw the hand's speed: captured, planned, measured, and the raw controller's.

    Parameters
    ----------
    path : Path
        PNG to write.
    done : Done
    directory : Path, optional
        Where the arm's files are searched, for the raw controller.

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
    _draw(axes, done.out.trajectory, f"planned ({done.out.plan})", color="tab:blue", linestyle="--")
    kind = "simulated" if done.recording.simulated else done.recording.port
    _draw(axes, measured, f"measured ({kind})", color="tab:red")
    synergy = done.out.synergy
    raw = None if synergy is not None and synergy.model == "A" else _raw(done, directory)
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
    learned = done.out.learned
    if learned is None:
        return
    try:
        moved = movement(measured.time, measured.hand)
    except InputError as error:
        click.echo(f"no capture in the plot: {error}", err=True)
        return
    profile = np.array(learned.speed_profile)
    duration = moved.time[-1] - moved.time[0]
    scale = np.trapezoid(moved.speed, moved.time) / (np.trapezoid(profile, dx=0.01) * duration)
    axes.plot(
        moved.time[0] + np.linspace(0.0, 1.0, profile.size) * duration,
        profile * scale,
        color="0.6",
        linewidth=5,
        label=f"captured: {learned.name} (same duration and path)",
    )


def _draw(axes: Any, motion: Motion, label: str, **style: Any) -> None:
    from armsyn.motion.filtering import hand_speed

    found = hand_speed(motion.time, motion.hand)
    inside = (found.time >= motion.time[0]) & (found.time <= motion.time[-1])
    axes.plot(found.time[inside], found.speed[inside], label=label, **style)


def _raw(done: Done, directory: Path | None) -> Motion | None:
    """Plan the same reach without synergy; None where that fails (it is drawn, not moved)."""
    ik = "svd" if done.out.synergy is None else done.out.synergy.ik
    try:
        raw = planner_for(done.arm, "synergy", directory, ik=ik, model="A")
        planned = raw.plan(done.start, done.out.target)
    except (RefusedMotionError, InputError) as error:
        click.echo(f"no raw controller in the plot: {error}", err=True)
        return None
    return planned.trajectory
