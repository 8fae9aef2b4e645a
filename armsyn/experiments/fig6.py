"""The paper's figure 6: captured, raw (S_A) and synergy (S_C) motions superposed, and animated."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from armsyn.experiments.figures import Figures, animate, draw_stills
from armsyn.experiments.learned import FloatArray, Learned, Progress, learn_each
from armsyn.experiments.reporting import TRAINING_ERROR, made_with
from armsyn.experiments.selections import BOTH, Selection, load
from armsyn.experiments.settings import Settings
from armsyn.experiments.tables import Column, Report, Table, Value, centimetres

IK = "svd"
DRAWN = 4
"""Row of the reach that is drawn: a middle one of the selection, whatever its result."""
MOMENTS = (0.0, 0.25, 0.5, 0.75, 1.0)
_COLUMNS = (
    Column("reach", "reach"),
    Column("half_way_captured_s", "half-way, captured, s", ".2f"),
    Column("half_way_a_s", "half-way S_A, s", ".2f"),
    Column("half_way_c_s", "half-way S_C, s", ".2f"),
    centimetres("elbow_above_a", "elbow S_A"),
    centimetres("elbow_above_c", "elbow S_C"),
    centimetres("distance_a", "S_A"),
    centimetres("distance_c", "S_C"),
)


def run(
    settings: Settings,
    folder: Path,
    on_progress: Progress,
    selections: Sequence[Selection] = BOTH,
) -> Report:
    """Learn S_A and S_C on every reach, superpose one of them and animate it.

    Parameters
    ----------
    settings : Settings
    folder : Path
        Where stills and animations go.
    on_progress : callable
    selections : sequence of Selection

    Returns
    -------
    Report
        Its ``films`` are there only where ffmpeg is.

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
    pictures, films = [], []
    for raw, synergy in found:
        figures = superposed(raw, synergy, min(DRAWN, len(raw.distances) - 1))
        name = f"fig6_{raw.prepared.selection.key}"
        pictures.append(draw_stills(figures, MOMENTS, folder, name))
        animations = animate(figures, folder, name, on_progress)
        pictures += [file for file in animations if file.endswith(".gif")]
        films += [file for file in animations if not file.endswith(".gif")]
    return Report(
        "fig6",
        "Captured, raw and synergy motions superposed (the paper's figure 6)",
        made_with(settings, [raw.prepared for raw, _ in found], [IK]),
        [shapes_table(raw, synergy) for raw, synergy in found],
        pictures,
        [TRAINING_ERROR],
        films,
    )


def superposed(raw: Learned, synergy: Learned, row: int) -> Figures:
    """Three figures of one reach, frame by frame.

    Parameters
    ----------
    raw, synergy : Learned
        S_A and S_C of one selection.
    row : int
        Which reach.

    Returns
    -------
    Figures
    """
    training = raw.prepared.trainings[row]
    return Figures(
        training.capture.name,
        training.time,
        training.landmarks,
        raw.play(row),
        synergy.play(row),
    )


def half_way(time: FloatArray, hand: FloatArray) -> float:
    """Moment at which a hand first is half as far from its last position as at the start, s.

    Parameters
    ----------
    time : array, shape (frames,)
        s.
    hand : array, shape (frames, 3)
        m.

    Returns
    -------
    float
    """
    left = np.linalg.norm(hand - hand[-1], axis=1)
    return float(time[np.argmax(left <= left[0] / 2)])


def shapes_table(raw: Learned, synergy: Learned) -> Table:
    """Compare when the hand is half-way and how high the elbow is, and their means.

    Parameters
    ----------
    raw, synergy : Learned

    Returns
    -------
    Table
    """
    rows: list[tuple[Value, ...]] = []
    for row, name in enumerate(raw.prepared.names):
        time = raw.prepared.trainings[row].time
        captured, a, c = superposed(raw, synergy, row).motions
        rows.append(
            (
                name,
                *(half_way(time, motion[:, -1]) for motion in (captured, a, c)),
                *(float((motion - captured)[:, 1, 2].mean()) for motion in (a, c)),
                float(raw.distances[row]),
                float(synergy.distances[row]),
            )
        )
    numbers = np.array([row[1:] for row in rows], dtype=np.float64)
    rows.append(("mean", *numbers.mean(axis=0).tolist()))
    return Table(f"{raw.prepared.selection.title}, {IK.upper()}", _COLUMNS, rows, [_NOTE])


_NOTE = (
    "half-way: when the hand is half as far from where it ends as at the start; elbow: height above"
    " the captured one, mean over time. The paper of S_A: motion is quicker and elbow is moved too"
    " high."
)
