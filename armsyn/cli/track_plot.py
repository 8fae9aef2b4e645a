"""The plot of `armsyn track`: targets, the hand, and its speed."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from armsyn.arm import ArmDescription
from armsyn.cli.track_teller import Teller
from armsyn.driver import Recording

_MOST_LINES = 30
"""Targets whose beginnings are marked in a plot; more would hide it."""


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
