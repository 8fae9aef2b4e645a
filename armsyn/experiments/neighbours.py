"""The paper's last wish: where a learned set still serves, and how few sets serve every target.

Each set of S_C parameters, learned from one reach, is used on the same person's reaches to every
target: started in their posture, given their target, played at its own pace. What comes out is
scored by the held distance, onset to offset, and set beside the human floor: the held distance of
a reach to the mean of the person's other repeats.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from armsyn.experiments.learned import Progress, learn_each
from armsyn.experiments.neighbours_plot import draw
from armsyn.experiments.neighbours_tables import (
    distance_table,
    fewest_table,
    pairs_table,
    regions_table,
)
from armsyn.experiments.reporting import made_with
from armsyn.experiments.selections import (
    GARZA_ALL,
    HUG_MP_PERSONS,
    Prepared,
    Selection,
    load,
    more_repeats,
)
from armsyn.experiments.serving import SERVES, SERVES_M, Served, serve
from armsyn.experiments.settings import Settings
from armsyn.experiments.tables import Report
from armsyn.motion.captures import load_captures
from armsyn.scoring.floor import human_floor
from armsyn.scoring.repeats import repeats_in
from armsyn.synergy.controller import ARM_RATES, RATES
from armsyn.synergy.models import STABLE_GAIN

IK, MODEL = "svd", "C"
BOUNDS = {"paper": False, "positive": True}
"""Whether gains are bounded below: the paper's bounds, or those of arms that move."""
FEW_REPEATS = 3
_BOTH_BOUNDS = {
    "bounds": "slopes 1 to 10 1/s, offsets 0 to 20; gains -5 to 5 (the paper's), or"
    f" {STABLE_GAIN:g} to 5 (positive)",
    "lambda_per_s": {"paper": RATES[IK], "positive": ARM_RATES[IK]},
}
_HOW = (
    "Sets of S_C (SVD) used on reaches that they were **not** learned from: no training errors,"
    " except where a set's own reach is named. Held distance, onset to offset at 5 % of the peak"
    " speed; a set keeps its own pace. The human floor is taken the same way; garza has one reach a"
    f" target, so none (n/a). A set serves a target up to {SERVES:g} floors on the mean of its"
    f" reaches; up to {SERVES_M * 100:g} cm where there is no floor. Bounds: the paper's (lambda"
    " 6/s), or positive gains as for arms that move (lambda 10/s)."
)


def run(
    settings: Settings,
    folder: Path,
    on_progress: Progress,
    selections: Sequence[Selection] | None = None,
) -> Report:
    """Use each learned set on the same person's other reaches.

    Parameters
    ----------
    settings : Settings
        A small budget takes one person of HuG-MP, and few repeats.
    folder : Path
        Where the picture goes.
    on_progress : callable
    selections : sequence of Selection, optional
        Where sets are learned from, one a person; by the budget when None.

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
    is_small = settings.budget == "small"
    chosen = selections or (*HUG_MP_PERSONS[: 1 if is_small else None], GARZA_ALL)
    people = [
        _serve_person(settings, selection, FEW_REPEATS if is_small else None, on_progress)
        for selection in chosen
    ]
    flat = [served for person in people for served in person]
    return Report(
        "neighbours",
        "Learned sets on other targets of the same person (the paper's last wish)",
        made_with(settings, [person[0].reaches for person in people], [IK]) | _BOTH_BOUNDS,
        [
            distance_table(flat),
            *(fewest_table(person) for person in people),
            *(regions_table(person) for person in people),
            pairs_table(flat),
        ],
        [draw(people, folder)],
        [_HOW],
    )


def _serve_person(
    settings: Settings, selection: Selection, at_most: int | None, on_progress: Progress
) -> list[Served]:
    """Learn with either kind of bounds and use what was learned."""
    prepared = load(selection)
    reaches = more_repeats(prepared, at_most)
    floors = _floors(reaches, on_progress)
    found = []
    for bounds, stable in BOUNDS.items():
        each = learn_each(prepared, [(IK, MODEL)], settings, on_progress, stable=stable)
        stage = f"{selection.title}: used, {bounds} bounds"
        found.append(serve(bounds, each[IK, MODEL], reaches, floors, on_progress, stage))
    return found


def _floors(reaches: Prepared, on_progress: Progress) -> dict[str, float]:
    """Human floor of each reach that has repeats among all of its person's reaches, m."""
    if reaches.selection.everything is None:
        return {}
    captures = load_captures(reaches.selection.everything)
    repeats = dict(repeats_in([(capture.name, capture.motion) for capture in captures]))
    floors = {}
    for number, name in enumerate(reaches.names):
        floors[name] = human_floor(*repeats[name]).distance
        stage = f"{reaches.selection.title}: human floor"
        on_progress(stage, number + 1, len(reaches.names), "")
    return floors
