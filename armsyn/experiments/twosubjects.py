"""The paper's 192 motions of two persons: what holds on 14 reaches holds on many."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from armsyn.experiments.learned import Learned, Progress, learn_each
from armsyn.experiments.pictures import CAPTURED, figure, save, spans
from armsyn.experiments.reporting import TRAINING_ERROR, made_with
from armsyn.experiments.selections import Selection, load
from armsyn.experiments.settings import Settings
from armsyn.experiments.tables import Column, Report, Table, Value, centimetres, percent

IK = "svd"
MODELS = ("A", "C")
TWO = tuple(
    Selection(subject, f"HuG-MP {subject}", "hug_mp4", f"hug_mp:{subject}:all", 100.0, at_most=96)
    for subject in ("S01", "S02")
)
"""96 of each: the first usable reaches from rest in the table's order."""
_COLUMNS = (
    Column("who", "who"),
    Column("target", "target"),
    Column("motions", "motions", ".0f"),
    *(centimetres(f"a_{key}", f"S_A {key}") for key in ("mean", "min", "max")),
    *(centimetres(f"c_{key}", f"S_C {key}") for key in ("mean", "min", "max")),
    percent("change", "change"),
    Column("r_a", "speed r of S_A", "+.2f"),
    Column("r_c", "speed r of S_C", "+.2f"),
)


def run(
    settings: Settings,
    folder: Path,
    on_progress: Progress,
    selections: Sequence[Selection] = TWO,
) -> Report:
    """Learn S_A and S_C on 96 reaches of each of two persons.

    Parameters
    ----------
    settings : Settings
    folder : Path
        Where the picture goes.
    on_progress : callable
    selections : sequence of Selection
        One a person.

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
    pairs = [(IK, model) for model in MODELS]
    found = [
        tuple(learn_each(load(each), pairs, settings, on_progress).values()) for each in selections
    ]
    count = sum(len(raw.distances) for raw, _ in found)
    return Report(
        "twosubjects",
        f"{count} motions of {len(found)} persons (the paper's discussion)",
        made_with(settings, [raw.prepared for raw, _ in found], [IK]),
        [persons_table(found), *(targets_table(*pair) for pair in found)],
        [_draw(found, folder)],
        [TRAINING_ERROR],
    )


def persons_table(found: Sequence[tuple[Learned, ...]]) -> Table:
    """Compare S_C with S_A for each person and for all.

    Parameters
    ----------
    found : sequence of (Learned, Learned)
        S_A and S_C of each person.

    Returns
    -------
    Table
    """
    rows = [
        _row(raw.prepared.selection.title, "all", [(raw, synergy, range(len(raw.distances)))])
        for raw, synergy in found
    ]
    everybody = [(raw, synergy, range(len(raw.distances))) for raw, synergy in found]
    rows.append(_row("together", "all", everybody))
    return Table("Two persons, SVD", _COLUMNS, rows, [_NOTE])


def targets_table(raw: Learned, synergy: Learned) -> Table:
    """Compare S_C with S_A for each target of a person.

    Parameters
    ----------
    raw, synergy : Learned

    Returns
    -------
    Table
    """
    targets = [name.rpartition(":")[2] for name in raw.prepared.names]
    rows = [
        _row(
            raw.prepared.selection.title,
            target,
            [(raw, synergy, [row for row, other in enumerate(targets) if other == target])],
        )
        for target in sorted(set(targets), key=_number)
    ]
    return Table(f"{raw.prepared.selection.title}: by target", _COLUMNS, rows)


_NOTE = (
    "The paper gives no figure for its 192 motions, only that the model learns individual"
    " synergies regardless of their number. speed r: see fig5."
)


def _number(target: str) -> int:
    return int(target.removeprefix("R-"))


def _row(
    who: str, target: str, parts: Sequence[tuple[Learned, Learned, Sequence[int]]]
) -> tuple[Value, ...]:
    a = np.concatenate([raw.distances[rows] for raw, _, rows in parts])
    c = np.concatenate([synergy.distances[rows] for _, synergy, rows in parts])
    r_a = np.concatenate([raw.speed_rs[rows] for raw, _, rows in parts])
    r_c = np.concatenate([synergy.speed_rs[rows] for _, synergy, rows in parts])
    return (
        who,
        target,
        a.size,
        *(
            float(value)
            for values in (a, c)
            for value in (values.mean(), values.min(), values.max())
        ),
        float(c.mean() / a.mean() - 1),
        float(r_a.mean()),
        float(r_c.mean()),
    )


def _draw(found: Sequence[tuple[Learned, ...]], folder: Path) -> str:
    drawn = figure(5.0 * len(found), 4.0)
    for axes, (raw, synergy) in zip(
        drawn.subplots(1, len(found), squeeze=False, sharey=True)[0], found, strict=True
    ):
        targets = np.array([name.rpartition(":")[2] for name in raw.prepared.names])
        names = sorted(set(targets.tolist()), key=_number)
        for place, target in enumerate(names):
            first, rows = place == 0, targets == target
            spans(axes, place - 0.2, raw.distances[rows], "white", "$S_A$" * first)
            spans(axes, place + 0.2, synergy.distances[rows], CAPTURED, "$S_C$" * first)
        axes.set_xticks(range(len(names)), names)
        axes.set_title(f"{raw.prepared.selection.title}, {len(targets)} motions")
        axes.set_xlabel("from rest to target")
        axes.legend()
    drawn.axes[0].set_ylabel("distance to the capture, cm (mean, min, max)")
    return save(drawn, folder, "twosubjects.png")
