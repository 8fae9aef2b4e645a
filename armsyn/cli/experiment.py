"""`armsyn experiment`: the papers' figures and cases on real captures."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from armsyn.experiments import EXPERIMENTS

LONG_TEXT = 40
"""Characters from which a column of text is broken into lines."""
MOST_ROWS = 40
"""Of a table on a terminal; longer ones are in the files."""

if TYPE_CHECKING:
    from armsyn.experiments.settings import Budget
    from armsyn.experiments.tables import Report


@click.command(epilog="\n\n".join(f"{name}: {what}" for name, what in EXPERIMENTS.items()))
@click.argument("name", type=click.Choice(list(EXPERIMENTS)))
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    metavar="DIR",
    help="Where tables and pictures go; made when it is missing.",
)
@click.option(
    "--budget",
    type=click.Choice(["small", "full"]),
    default="full",
    show_default=True,
    help="small: see in a minute or two that it works; full: the figures.",
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@click.option("--workers", type=click.IntRange(min=1), help="Cores  [default: all]")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def experiment(
    name: str, out: Path, budget: Budget, seed: int, workers: int | None, as_json: bool
) -> None:
    """Repeat a figure or case of the papers on captured motions.

    Learns synergies with the paper's bounds, and writes NAME.json (SI units), NAME.md (for
    people), pictures, and NAME.run.json (command, machine, time). The same seed gives the same
    tables at any number of workers, but for the times of edits (times of predictions are in
    NAME.times.json). The captures are looked for in
    $ARMSYN_CAPTURES, else in shared/captures beside the checkout.
    """
    from armsyn.cli.long_work import StageBars, write_run
    from armsyn.experiments.settings import Settings
    from armsyn.experiments.tables import write

    _make_folder(out)
    module = importlib.import_module(f"armsyn.experiments.{name.replace('-', '_')}")
    with StageBars() as progress:
        report = module.run(Settings(budget, seed, workers), out, progress.update)
    written = write(report, out)
    write_run(written[0])
    if as_json:
        click.echo(written[0].read_text(encoding="utf-8"), nl=False)
    else:
        _show(report, written + [out / name for name in (*report.pictures, *report.films)])


def _make_folder(out: Path) -> None:
    """Learning takes minutes: find out before, not after."""
    import tempfile

    from armsyn.errors import InputError

    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out):
            pass
    except OSError as error:
        raise InputError(f"{out}: cannot write there: {error.strerror or error}") from error


def _show(report: Report, written: list[Path]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console()
    console.print(report.title, style="bold", highlight=False)
    for note in report.notes:
        console.print(note.replace("**", ""), highlight=False, markup=False)
    for table in (*report.tables, *report.timings):
        if len(table.rows) > MOST_ROWS:
            console.print(f"{table.title}: {len(table.rows)} rows, in {report.name}.md or .json")
            continue
        shown = Table(title=table.title)
        rows = table.shown()
        for place, column in enumerate(table.columns):
            is_number = bool(column.form)
            is_long = any(len(row[place]) > LONG_TEXT for row in rows)
            justify: Literal["right", "left"] = "right" if is_number else "left"
            no_wrap = not (is_number or is_long)
            shown.add_column(column.heading, justify=justify, no_wrap=no_wrap)
        for row in rows:
            shown.add_row(*row)
        console.print(shown)
        for note in table.notes:
            console.print(note, highlight=False, markup=False)
    for path in written:
        console.print(f"wrote {path}", highlight=False, markup=False, soft_wrap=True)
