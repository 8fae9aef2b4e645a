"""The paper's figure 3: how close the four synergy models S_A to S_D come to captured reaches."""

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
from armsyn.synergy.models import MODELS

IK = "svd"
_COLUMNS = (
    Column("model", "model"),
    Column("parameters", "params", ".0f"),
    centimetres("mean", "mean"),
    centimetres("min", "min"),
    centimetres("max", "max"),
    percent("against_a", "vs S_A"),
    percent("against_previous", "vs before"),
    percent("further_points_of_a", "more, of S_A"),
    percent("paper_step", "paper"),
    centimetres("earlier_mean", "earlier study"),
)


def run(
    settings: Settings,
    folder: Path,
    on_progress: Progress,
    selections: Sequence[Selection] = BOTH,
) -> Report:
    """Learn S_A to S_D on every reach of each selection, and compare their distances.

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
    found = [
        list(
            learn_each(
                load(selection),
                [(IK, model) for model in MODELS],
                settings,
                on_progress,
            ).values()
        )
        for selection in selections
    ]
    tables = [table for models in found for table in (models_table(models), each_reach(models))]
    return Report(
        "fig3",
        "Synergy models S_A to S_D (the paper's figure 3)",
        made_with(settings, [models[0].prepared for models in found], [IK]),
        tables,
        [_draw(found, folder)],
        [TRAINING_ERROR],
    )


def models_table(models: Sequence[Learned]) -> Table:
    """Compare the models of one selection.

    Parameters
    ----------
    models : sequence of Learned
        S_A first, each with more parameters than the one before.

    Returns
    -------
    Table
    """
    selection = models[0].prepared.selection
    earlier = published.EARLIER_MEANS_M.get(selection.key, {}).get(IK, {})
    rows: list[tuple[Value, ...]] = []
    for number, learned in enumerate(models):
        before = models[number - 1] if number else None
        rows.append(
            (
                f"S_{learned.model}",
                learned.parameters.shape[1],
                learned.mean,
                float(learned.distances.min()),
                float(learned.distances.max()),
                learned.mean / models[0].mean - 1 if before else None,
                learned.mean / before.mean - 1 if before else None,
                (learned.mean - before.mean) / models[0].mean if before else None,
                published.PAPER_STEPS.get(learned.model),
                earlier.get(learned.model),
            )
        )
    return Table(
        f"{selection.title}: {len(models[0].distances)} reaches, {IK.upper()}",
        _COLUMNS,
        rows,
        [_verdict(models), _PAPERS_OWN],
    )


_PAPERS_OWN = (
    "vs before: change from the model above; more, of S_A: the same in shares of S_A's mean. The"
    " paper's changes may be read either way (it says: 13 % more). Its own mean"
    f" {published.PAPER_MEAN_OF_D_M * 100:.2f} by S_D and least distance"
    f" {published.PAPER_LEAST_OF_C_M * 100:.2f} by S_C are other people's reaches, their unit is"
    " taken as cm. Earlier study: the same reaches, lambda 2/s, a small budget of differential"
    " evolution."
)


def _verdict(models: Sequence[Learned]) -> str:
    c, d = (next(learned for learned in models if learned.model == model) for model in "CD")
    gap = (d.mean - c.mean) * 100
    where = int((d.distances > c.distances).sum())
    return (
        f"S_D's mean is {abs(gap):.2f} cm {'above' if gap > 0 else 'below'} S_C's; S_D holds S_C"
        f" (equal sigmoids), so where it is above (here in {where} of {len(d.distances)} reaches)"
        " the search, not the model, fell short."
    )


def _draw(found: Sequence[Sequence[Learned]], folder: Path) -> str:
    drawn = figure(5.0 * len(found), 4.0)
    for axes, models in zip(drawn.subplots(1, len(found), squeeze=False)[0], found, strict=True):
        for place, learned in enumerate(models):
            spans(axes, place, learned.distances, CAPTURED)
        axes.set_xticks(range(len(models)), [f"$S_{learned.model}$" for learned in models])
        axes.set_title(models[0].prepared.selection.title)
        axes.set_ylabel("distance to the capture, cm (mean, min, max)")
    return save(drawn, folder, "fig3.png")
