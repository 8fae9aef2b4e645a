"""The paper's figure 5: the hand's speed, captured, raw (S_A) and with synergy (S_C)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armsyn.experiments import published
from armsyn.experiments.learned import Learned, Progress, learn_each, speed
from armsyn.experiments.pictures import CAPTURED, RAW, SYNERGY, figure, save
from armsyn.experiments.reporting import TRAINING_ERROR, made_with
from armsyn.experiments.selections import BOTH, Selection, load
from armsyn.experiments.settings import Settings
from armsyn.experiments.tables import Column, Report, Table, Value, centimetres

IK = "svd"
DRAWN = 4
_WHO = (("captured", "captured"), ("a", "S_A"), ("c", "S_C"))
_COLUMNS = (
    Column("reach", "reach"),
    Column("r_a", "r of S_A", "+.3f"),
    Column("r_c", "r of S_C", "+.3f"),
    centimetres("distance_a", "S_A"),
    centimetres("distance_c", "S_C"),
    *(Column(f"peak_{who}_m_per_s", f"peak {shown}, m/s", ".2f") for who, shown in _WHO),
    *(Column(f"peak_time_{who}_s", f"peak {shown} at, s", ".2f") for who, shown in _WHO),
)


def run(
    settings: Settings,
    folder: Path,
    on_progress: Progress,
    selections: Sequence[Selection] = BOTH,
) -> Report:
    """Learn S_A and S_C on every reach, and follow the hand's speed.

    Parameters
    ----------
    settings : Settings
    folder : Path
        Where the picture goes.
    on_progress : callable
    selections : sequence of Selection

    Returns
    -------
    Report

    Raises
    ------
    CaptureError
        Captures that are not there.
    KeyboardInterrupt
        Ctrl-C.
    """
    pairs = [(IK, "A"), (IK, "C")]
    found = [
        tuple(learn_each(load(each), pairs, settings, on_progress).values()) for each in selections
    ]
    return Report(
        "fig5",
        "Hand speed, captured, raw and with synergy (the paper's figure 5)",
        made_with(settings, [raw.prepared for raw, _ in found], [IK]),
        [speeds_table(raw, synergy) for raw, synergy in found],
        [_draw(found, folder)],
        [TRAINING_ERROR],
    )


def speeds_table(raw: Learned, synergy: Learned) -> Table:
    """Compare hand speeds of every reach, and their mean.

    Parameters
    ----------
    raw, synergy : Learned
        S_A and S_C of one selection.

    Returns
    -------
    Table
    """
    rows: list[tuple[Value, ...]] = []
    for row, name in enumerate(raw.prepared.names):
        peaks = [
            (float(values.max()), float(time[np.argmax(values)]))
            for time, values in _curves(raw, synergy, row)
        ]
        rows.append(
            (
                name,
                float(raw.speed_rs[row]),
                float(synergy.speed_rs[row]),
                float(raw.distances[row]),
                float(synergy.distances[row]),
                *(peak for peak, _ in peaks),
                *(moment for _, moment in peaks),
            )
        )
    numbers = np.array([row[1:] for row in rows], dtype=np.float64)
    rows.append(("mean", *numbers.mean(axis=0).tolist()))
    selection = raw.prepared.selection
    return Table(f"{selection.title}, {IK.upper()}", _COLUMNS, rows, [_NOTE])


_NOTE = (
    "r: correlation of the hand's speed with the captured one at equal times, over all frames of"
    " the capture, both through a zero-lag second-order Butterworth filter at 6 Hz. Wanted of S_C"
    f" on garza: {published.GOAL_SPEED_R} on the mean (the earlier study: S_A -0.02, S_C 0.93). The"
    " paper gives no number."
)


def _curves(raw: Learned, synergy: Learned, row: int) -> list[tuple[Any, Any]]:
    """Time and speed: captured, S_A, S_C."""
    training = raw.prepared.trainings[row]
    hands = (training.landmarks[:, -1], raw.play(row)[:, -1], synergy.play(row)[:, -1])
    return [(training.time, speed(training.time, hand)) for hand in hands]


def drawn_rows(count: int) -> list[int]:
    """Rows that are drawn: evenly spread over the selection, whatever their results."""
    return sorted({round(row) for row in np.linspace(0, count - 1, DRAWN)})


def _draw(found: Sequence[tuple[Learned, ...]], folder: Path) -> str:
    drawn = figure(13.0, 3.2 * len(found))
    styles = (
        (CAPTURED, "-", 3.0, "captured"),
        (RAW, ":", 1.5, "$S_A$"),
        (SYNERGY, "-", 1.5, "$S_C$"),
    )
    every = drawn.subplots(len(found), DRAWN, squeeze=False)
    for line, (raw, synergy) in zip(every, found, strict=True):
        for axes, row in zip(line, drawn_rows(len(raw.distances)), strict=False):
            for (time, values), (colour, dash, width, label) in zip(
                _curves(raw, synergy, row), styles, strict=True
            ):
                axes.plot(time, values, dash, color=colour, linewidth=width, label=label)
            axes.set_title(
                f"{raw.prepared.names[row]}\n"
                f"r {raw.speed_rs[row]:+.2f} ($S_A$), {synergy.speed_rs[row]:+.2f} ($S_C$)",
                fontsize=10,
            )
            axes.set_xlabel("time, s")
        line[0].set_ylabel("hand speed, m/s")
    every[0, 0].legend()
    return save(drawn, folder, "fig5.png")
