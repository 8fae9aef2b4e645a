"""`armsyn generate`: reaches by the thousand, each checked, in files that other tools read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.arm_options import calibration_option, unit_option
from armsyn.cli.choices import PLANS, FiniteRange
from armsyn.cli.orientation_options import orientation_options

if TYPE_CHECKING:
    from armsyn.planning.generation.report import Report


@click.command()
@click.option("--arm", "arm_name", required=True, metavar="NAME", help="Whose reaches.")
@unit_option
@click.option(
    "--targets",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Targets: x, y, z in metres in every line; see above.",
)
@click.option("--grid", nargs=3, metavar="X Y Z", help="Targets on a grid: each FIRST:LAST:COUNT.")
@click.option("--random", "number", type=click.IntRange(min=1), metavar="N", help="N places.")
@click.option(
    "--box",
    nargs=3,
    metavar="X Y Z",
    help="Of --random: each FIRST:LAST, metres  [default: where people were captured]",
)
@orientation_options
@click.option(
    "--start",
    metavar="J1,J2,...|FILE",
    help="Where reaches start: all joints (rad or m), or a motion's last posture  [default: rest]",
)
@click.option("--repeats", type=click.IntRange(min=1), default=1, show_default=True, metavar="K")
@click.option(
    "--variability", is_flag=True, help="Repeats differ as people's do (start and end stay)."
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@click.option(
    "--plan",
    type=PLANS,
    help="What makes the reaches: minjerk, or, with the arm's atlas, any  [default: latent]",
)
@click.option(
    "--slower",
    type=float,
    default=1.0,
    metavar="FACTOR",
    help="Allow every reach only 1/FACTOR of the arm's speed.",
)
@click.option("--out", required=True, type=click.Path(path_type=Path, file_okay=False))
@click.option("--format", "kind", default="npz", show_default=True, help="See above.")
@click.option(
    "--rate",
    type=FiniteRange(10.0, 1000.0),
    default=200.0,
    show_default=True,
    metavar="HZ",
    help="Frames a second; limits are held at 200 or more, also where fewer are written.",
)
@click.option(
    "--chunk", type=click.IntRange(1, 100_000), default=2000, show_default=True, metavar="REACHES"
)
@click.option(
    "--workers", type=click.IntRange(min=1), help="Processes  [default: as many as cores]"
)
@click.option("--cluster", metavar="tcp://HOST:PORT", help="A scheduler of dask.distributed.")
@click.option(
    "--task", metavar="TEXT", help="What every reach does, in words  [default: reach to the target]"
)
@click.option("--resume", is_flag=True, help="Go on with what --out holds already.")
@calibration_option
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def generate(**options: Any) -> None:
    """Make reaches by the thousand, each checked as one that is driven.

    Targets come from a file, a grid or chance. A file's first line may name its columns: x, y, z;
    px, py, pz (where the hand points) or roll, pitch, yaw (how it is turned, degrees); and all
    joints, to start where the line says and not at --start. Each reach is planned as armsyn reach
    --plan does it: slowed until every joint's limits hold, checked on its whole way for contacts,
    and, where as predicted it does not pass or the hand would speed up more than once, brought
    nearer to minimum jerk or ended with another swivel, which changes.csv tells. What is refused
    stands in refusals.csv, by index and with its reason; reaches.csv has a line for every one that
    is made: target, durations, error, file. manifest.json says what the reaches are made from. They
    are planned, not measured: no arm or person moved so.

    Formats: npz and csv (many reaches a file), parquet and mcap (likewise, an episode a reach), bvh
    (a file a reach: the arm as a skeleton), lerobot (one dataset; its action is the posture of the
    plan's next frame, of the last its own, as a loop by position sends it, and its
    observation.environment_state the target). The same seed, inputs and --chunk give the same
    bytes, whatever the number of workers. Ctrl-C, a full disk (exit status 2) and even a kill keep
    every finished chunk; the same command with --resume goes on from there.

    With --cluster, workers of dask.distributed (pip install 'armsyn[cluster]') make the chunks:
    they must see --out by the same path.
    """
    from armsyn.cli.compiling import telling_of_compilation
    from armsyn.cli.generate_inputs import recipe_of
    from armsyn.cli.long_work import StageBars, write_run
    from armsyn.planning.generation.files import TASK, checked_format
    from armsyn.planning.generation.folder import MANIFEST
    from armsyn.planning.generation.order import Order
    from armsyn.planning.generation.running import digest_of
    from armsyn.planning.generation.running import generate as make
    from armsyn.planning.generation.version import version

    kind, task = checked_format(options["kind"]), options["task"] or TASK
    recipe, inputs = recipe_of(options)
    inputs |= {"format": kind, "task": task, **version()}
    out = options["out"].absolute()
    order = Order(recipe, str(out), kind, options["chunk"], digest_of(inputs), task)
    with telling_of_compilation(), StageBars() as progress:
        report = make(
            order,
            inputs,
            workers=options["workers"],
            cluster=options["cluster"],
            resume=options["resume"],
            on_progress=progress.update,
        )
    if report.error is None and not report.found:
        write_run(out / MANIFEST)
    _tell(report, options["out"], as_json=options["as_json"])


def _tell(report: Report, out: Path, *, as_json: bool) -> None:
    """Say what came of it; raise what it ended by."""
    import json

    from armsyn.cli.json_errors import DocumentedError
    from armsyn.errors import RefusedMotionError

    document = {"out": str(out), **report.as_document()}
    error = report.error
    if error is not None:
        error.add(f"{report.made} reaches are in {out}: --resume goes on from there")
    elif not report.made:
        error = RefusedMotionError(f"every reach was refused: {out}/refusals.csv says why")
    if not as_json:
        _print(report, out)
    if error is not None:
        raise DocumentedError(error, document)
    if as_json:
        click.echo(json.dumps(document, indent=2, allow_nan=False))


def _print(report: Report, out: Path) -> None:
    if report.found:
        click.echo(f"{out}: all there, nothing left to do")
    refused = ", ".join(f"{count} {kind}" for kind, count in sorted(report.refused.items()))
    click.echo(
        f"{out}: {report.made} of {report.asked} reaches, {report.frames} frames; planned, not"
        " measured"
    )
    if report.made:
        click.echo(f"slowed {report.slowed:.2f} times on the mean, to keep the joints' limits")
    if report.evened or report.swivelled:
        click.echo(
            f"{report.evened} of them brought nearer to minimum jerk, {report.swivelled} with"
            " another swivel of the arm: see changes.csv"
        )
    if report.outside:
        click.echo(f"{report.outside} of them to targets outside the captured workspace")
    if refused:
        click.echo(f"refused: {refused}: see refusals.csv")
