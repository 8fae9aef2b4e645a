"""`armsyn bands`: what captured reaches measure, as bands to place others in."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.choices import FiniteRange
from armsyn.cli.measuring import measuring_options
from armsyn.cli.motion_sources import load_motions

if TYPE_CHECKING:
    from armsyn.motion import Motion
    from armsyn.scoring.bands import Bands

_FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("captures", nargs=-1, required=True)
@click.option("--out", type=_FILE, required=True, help="The bands' file, JSON.")
@click.option("--plot", type=_FILE, help="Draw the bands as a .png file.")
@measuring_options
@click.option(
    "--rate",
    type=FiniteRange(min=20, max=2000),
    default=100.0,
    show_default=True,
    help="Hz at which all are measured.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def bands(**options: Any) -> None:
    """Compute bands of human-likeness from CAPTURES, for `armsyn score --bands`.

    Each of CAPTURES is a motion file with one reach, or a selection of captured reaches, such as
    hug_mp:S01:all or garza:all; five reaches at least. A band is the median and the 5th to 95th
    percentile of one measure. Compare like with like: bands of a task for motions of that task.
    """
    from armsyn.cli.long_work import StageBars, write_run
    from armsyn.scoring.bands import bands_of
    from armsyn.scoring.bands_file import save_bands
    from armsyn.scoring.human_likeness import How

    _check_written(options)
    motions = _all_motions(options["captures"])
    how = How(options["cutoff"], options["cut"], options["rate"])
    with StageBars() as bars:

        def progress(stage: str, done: int, total: int) -> None:
            bars.update(stage, done, total, "")

        found = bands_of(" ".join(options["captures"]), motions, how, progress)
    save_bands(options["out"], found)
    write_run(options["out"])
    if options["plot"] is not None:
        from armsyn.cli.bands_plot import draw_bands

        draw_bands(options["plot"], found)
    _report(found, options)


def _check_written(options: dict[str, Any]) -> None:
    """Measuring takes a while: find out before."""
    from armsyn.errors import InputError

    for path, suffix in ((options["out"], ".json"), (options["plot"], ".png")):
        if path is None:
            continue
        if path.suffix.lower() != suffix:
            raise InputError(f"{path}: is written as {suffix}: name it so")
        if not path.parent.is_dir():
            raise InputError(f"{path}: the folder {path.parent} does not exist: make it first")


def _all_motions(captures: tuple[str, ...]) -> list[tuple[str, Motion]]:
    from armsyn.errors import CaptureError

    motions = [named for text in captures for named in load_motions(text)]
    names = [name for name, _ in motions]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise CaptureError(f"{twice} is named twice: it would count double")
    return motions


def _report(found: Bands, options: dict[str, Any]) -> None:
    if options["as_json"]:
        import json

        from armsyn.scoring.bands_file import bands_as_dict

        document = {"out": str(options["out"]), **bands_as_dict(found)}
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    from rich.console import Console

    from armsyn.scoring.tables import bands_table

    console = Console()
    console.print(bands_table(found))
    if found.floor is not None:
        floor = found.floor
        console.print(
            f"human floor of {floor.reaches} repeated reaches: {100 * floor.floor:.2f} cm, repeats"
            f" {100 * floor.repeat_distance:.2f} cm apart (as cut {100 * floor.floor_as_cut:.2f}"
            f" and {100 * floor.repeat_distance_as_cut:.2f})",
            highlight=False,
        )
    for name, reason in found.left_out.items():
        console.print(f"left out: {name}: {reason}", highlight=False, markup=False)
    for key in ("out", "plot"):
        if options[key] is not None:
            console.print(f"wrote {options[key]}", highlight=False, markup=False)
