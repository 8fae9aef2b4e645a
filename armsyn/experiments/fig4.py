"""The paper's figure 4: what S_C gains over the raw controller S_A with each optimiser."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from armsyn.experiments import published
from armsyn.experiments.learned import Learned, Progress, learn_each
from armsyn.experiments.pictures import CAPTURED, figure, save, spans
from armsyn.experiments.reporting import TRAINING_ERROR, each_reach, made_with
from armsyn.experiments.selections import BOTH, Selection, load
from armsyn.experiments.settings import Settings
from armsyn.experiments.tables import Column, Report, Table, Value, centimetres, percent

IKS = {"jt": "J^T", "svd": "SVD", "njt": "NJ^T"}
_COLUMNS = (
    Column("ik", "ik"),
    Column("lambda_per_s", "lambda, 1/s", "g"),
    *(centimetres(f"a_{key}", f"S_A {key}") for key in ("mean", "min", "max")),
    *(centimetres(f"c_{key}", f"S_C {key}") for key in ("mean", "min", "max")),
    percent("change", "change"),
    percent("paper_change", "paper"),
    percent("earlier_change", "earlier study"),
    centimetres("paper_c_mean", "paper S_C"),
    centimetres("earlier_c_mean", "earlier S_C"),
)


def run(
    settings: Settings,
    folder: Path,
    on_progress: Progress,
    selections: Sequence[Selection] = BOTH,
) -> Report:
    """Learn S_A and S_C with J^T, SVD and NJ^T on every reach of each selection.

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
    pairs = [(ik, model) for ik in IKS for model in ("A", "C")]
    found = [learn_each(load(selection), pairs, settings, on_progress) for selection in selections]
    tables = [
        table
        for learned in found
        for table in (optimisers_table(learned), each_reach(list(learned.values())))
    ]
    return Report(
        "fig4",
        "S_A and S_C with three optimisers (the paper's figure 4)",
        made_with(settings, [learned["svd", "A"].prepared for learned in found], list(IKS)),
        tables,
        [_draw(found, folder)],
        [TRAINING_ERROR],
    )


def optimisers_table(learned: dict[tuple[str, str], Learned]) -> Table:
    """Compare S_C with S_A for each optimiser.

    Parameters
    ----------
    learned : dict of (ik, model) to Learned
        Of one selection.

    Returns
    -------
    Table
    """
    selection = learned["svd", "A"].prepared.selection
    earlier = published.EARLIER_MEANS_M[selection.key]
    rows: list[tuple[Value, ...]] = []
    for ik, name in IKS.items():
        raw, synergy = learned[ik, "A"], learned[ik, "C"]
        rows.append(
            (
                name,
                raw.rate,
                *_spread(raw),
                *_spread(synergy),
                synergy.mean / raw.mean - 1,
                published.PAPER_GAINS[ik],
                earlier[ik]["C"] / earlier[ik]["A"] - 1,
                published.PAPER_MEANS_OF_C_M[ik],
                earlier[ik]["C"],
            )
        )
    count = len(learned["svd", "A"].distances)
    return Table(f"{selection.title}: {count} reaches", _COLUMNS, rows, [_NOTE])


_NOTE = (
    "change: of the mean from S_A to S_C. The paper's means are other people's reaches (no unit"
    " given; taken as cm); which of 2.15 and 2.26 is J^T's follows its order of naming. Earlier"
    " study: the same reaches, lambda 20, 2 and 1 per second, a small budget of differential"
    " evolution. How far NJ^T steps is left open by the paper; here in proportion to the task"
    " error, so that it converges: its means need not be those of another reading."
)


def _spread(learned: Learned) -> tuple[float, float, float]:
    return learned.mean, float(learned.distances.min()), float(learned.distances.max())


def _draw(found: Sequence[dict[tuple[str, str], Learned]], folder: Path) -> str:
    drawn = figure(5.0 * len(found), 4.0)
    for axes, learned in zip(drawn.subplots(1, len(found), squeeze=False)[0], found, strict=True):
        for place, ik in enumerate(IKS):
            first = place == 0
            spans(axes, place - 0.2, learned[ik, "A"].distances, "white", "$S_A$" * first)
            spans(axes, place + 0.2, learned[ik, "C"].distances, CAPTURED, "$S_C$" * first)
        axes.set_xticks(range(len(IKS)), ["$J^T$", "SVD", "$NJ^T$"])
        axes.set_title(learned["svd", "A"].prepared.selection.title)
        axes.set_ylabel("distance to the capture, cm (mean, min, max)")
        axes.legend()
    return save(drawn, folder, "fig4.png")
