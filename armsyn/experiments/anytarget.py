"""Reaches to targets that nobody captured: every way of predicting them beside the human floor.

Each captured reach is predicted from its first posture and where its hand ends alone, by what was
learned from the same person's reaches to other targets, or from other people's; what comes out is
scored by the held distance, and set beside how close the person's own other repeats come.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armsyn.experiments.anytarget_bootstrap import RESAMPLES
from armsyn.experiments.anytarget_controls import controls_table
from armsyn.experiments.anytarget_driven import driven_table
from armsyn.experiments.anytarget_people import (
    People,
    Protocol,
    load_garza,
    load_garza_taught,
    load_hug_mp,
)
from armsyn.experiments.anytarget_plot import draw
from armsyn.experiments.anytarget_rows import ROWS, Row
from armsyn.experiments.anytarget_run import Group, Outcome, predict_all
from armsyn.experiments.anytarget_tables import (
    captured_looks,
    differences_table,
    distances_table,
    looks_table,
    persons_table,
    postures_table,
    rows_table,
    targets_table,
    times_table,
)
from armsyn.experiments.anytarget_verdict import best_of
from armsyn.experiments.learned import Progress
from armsyn.experiments.settings import Settings
from armsyn.experiments.tables import Report, Table
from armsyn.planning.planner import DEFAULT_PLAN

FEW_REPEATS, FEW_GARZA = 3, 10
"""Reaches to each target, and of garza, on a small budget."""
_FEW_PERSONS, _PERSONS = ("S01", "S02"), ("S01", "S02", "S03", "S04")
_HOW = (
    "No row but the labelled ones has seen the target that it predicts: start posture and target"
    " are given, the rest is learned from other reaches. The held distance is taken on the segments"
    " as they were cut, as the human floors are (garza has one reach a target, so no floor: n/a)."
    " garza, 4 joints: the standing person's reaches on the seated persons' arm, predicted by"
    " theirs, many of them far outside of what those reached for."
    " Constants of some rows were set with these very reaches of HuG-MP in view, so what they come"
    " to there is not held out; the table of rows says which. Best row and verdicts are read from"
    " the figures of the other rows: of latent motions, of `latent, chosen`, whose kernels are"
    " chosen in every fold from the fold's own targets. Its damping of 1 and its bounds are fixed"
    " over all folds, not chosen in them; so is the ridge of synergies and joined."
    " So is how deviations from minimum jerk are carried over and evened: steps and powers are few"
    " and were set with garza's ways back and these reaches in view. Rows but `latent, chosen` are"
    " scored as predicted, before a planner evens them; what an arm would get, bent and evened, is"
    " the table `as driven`."
)


def run(
    settings: Settings,
    folder: Path,
    on_progress: Progress,
    groups: Sequence[People] | None = None,
    rows: Sequence[Row] = ROWS,
) -> Report:
    """Predict every captured reach from other reaches by every row.

    Parameters
    ----------
    settings : Settings
        A small budget takes two persons of HuG-MP, few repeats, and few reaches of garza.
    folder : Path
        Where the picture goes.
    on_progress : callable
    groups : sequence of People, optional
        By the budget when None. Persons are left out where a group has several.
    rows : sequence of Row

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
    people = groups or _people(settings)
    missing = {row.key: why for row in rows if (why := row.missing())}
    there = [row for row in rows if row.key not in missing]
    asked = [Group(one, protocol) for one in people for protocol in _protocols(one)]
    found = predict_all(asked, there, settings.workers, on_progress)
    tables = [_summaries(outcomes, settings.seed) for outcomes in found]
    best = best_of(found[0])
    tables[0].append(controls_table(best, settings.seed, settings.workers, on_progress))
    for part, outcomes in zip(tables, found, strict=True):
        arm = next(iter(outcomes.values())).people.arm
        if arm is not None:
            driven = outcomes.get(DEFAULT_PLAN) or best_of(outcomes)
            part.append(driven_table(driven, arm, settings.workers, on_progress))
    return Report(
        "anytarget",
        "Reaches to targets that nobody captured",
        _made_with(settings, people),
        [
            rows_table(rows, missing),
            *(table for part in tables for table in part),
            *map(targets_table, found),
        ],
        [draw(found, settings.seed, folder)],
        [_HOW],
        timings=[times_table(found)],
    )


def _people(settings: Settings) -> list[People]:
    is_small = settings.budget == "small"
    hug_mp = load_hug_mp(_FEW_PERSONS, FEW_REPEATS) if is_small else load_hug_mp(_PERSONS)
    few = FEW_GARZA if is_small else None
    return [hug_mp, load_garza(few), load_garza_taught(hug_mp.examples, few)]


def _protocols(people: People) -> tuple[Protocol, ...]:
    """Persons are left out where there are others, targets where the person's own are learned."""
    if people.teachers is not None:
        return ("subject",)
    return ("target", "subject") if len(people.subjects) > 1 else ("target",)


def _summaries(outcomes: Mapping[str, Outcome], seed: int) -> list[Table]:
    captured = captured_looks(next(iter(outcomes.values())).people)
    return [
        distances_table(outcomes),
        differences_table(outcomes, seed, captured["one_peak"]),
        postures_table(outcomes),
        looks_table(outcomes, captured),
        persons_table(outcomes),
    ]


def _made_with(settings: Settings, groups: Sequence[People]) -> dict[str, Any]:
    return {
        "budget": settings.budget,
        "seed": settings.seed,
        "bootstrap": f"{RESAMPLES} resamples",
        "inputs_sha256": {people.title: _hash(people) for people in groups},
    }


def _hash(people: People) -> str:
    """Of the reaches: their names, times, and landmarks as scored."""
    digest = hashlib.sha256()
    for name, motion in zip(people.examples.names, people.captured, strict=True):
        digest.update(name.encode())
        for part in (motion.time, motion.landmarks):
            digest.update(np.round(np.asarray(part), 9).tobytes())
    return digest.hexdigest()
