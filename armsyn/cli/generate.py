"""`armsyn generate`: reaches by the thousand, each checked, in files that other tools read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.choices import PLANS, FiniteRange

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.planning.generation.report import Report
    from armsyn.planning.generation.targets import Targets
    from armsyn.planning.generation.variability import Variability
    from armsyn.planning.prediction import Predictor


@click.command()
@click.option("--arm", "arm_name", required=True, metavar="NAME", help="Whose reaches.")
@click.option(
    "--targets",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Targets: x, y, z in metres in every line.",
)
@click.option("--grid", nargs=3, metavar="X Y Z", help="Targets on a grid: each FIRST:LAST:COUNT.")
@click.option("--random", "number", type=click.IntRange(min=1), metavar="N", help="N places.")
@click.option(
    "--box",
    nargs=3,
    metavar="X Y Z",
    help="Of --random: each FIRST:LAST, metres  [default: where people were captured]",
)
@click.option("--repeats", type=click.IntRange(min=1), default=1, show_default=True, metavar="K")
@click.option(
    "--variability", is_flag=True, help="Repeats differ as people's do (start and end stay)."
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@click.option(
    "--plan",
    type=PLANS,
    help="What makes the reaches  [default: latent; without an atlas only minjerk]",
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
@click.option(
    "--calibration",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The only folder to look for the arm in.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def generate(**options: Any) -> None:
    """Make reaches by the thousand, each checked as one that is driven.

    Targets come from a file, a grid or chance; every reach starts at the arm's rest posture, or, if
    the file's first line names the columns x, y, z and all joints, where its line says. Each is
    planned as armsyn reach --plan does it: slowed until every joint's limits hold, checked on its
    whole way for contacts, and, where as predicted it does not pass or the hand would speed up more
    than once, mixed with minimum jerk or ended with another swivel, which changes.csv tells. What
    is refused stands in refusals.csv, by index and with its reason; reaches.csv has a line for
    every one that is made: target, durations, error, file. manifest.json says what the reaches are
    made from. They are planned, not measured: no arm or person moved so.

    Formats: npz and csv (many reaches a file), parquet and mcap (likewise, an episode a reach), bvh
    (a file a reach: the arm as a skeleton), lerobot (one dataset; its action is the posture of the
    plan's next frame, of the last its own, as a loop by position sends it, and its
    observation.environment_state the target). The same seed and inputs give the same bytes,
    whatever the number of workers. Ctrl-C, a full disk and even a kill keep every finished chunk;
    the same command with --resume goes on from there.

    With --cluster, workers of dask.distributed (pip install 'armsyn[cluster]') make the chunks:
    they must see --out by the same path.
    """
    from armsyn.arm import load_arm
    from armsyn.cli.long_work import StageBars, write_run
    from armsyn.planning.generation.batch import Recipe
    from armsyn.planning.generation.chunks import Order
    from armsyn.planning.generation.files import TASK, checked_format
    from armsyn.planning.generation.folder import MANIFEST
    from armsyn.planning.generation.running import digest_of
    from armsyn.planning.generation.running import generate as make
    from armsyn.planning.generation.version import version

    kind, task = checked_format(options["kind"]), options["task"] or TASK
    arm = load_arm(options["arm_name"], options["calibration"])
    predictor, variability, learned = _models(arm, options)
    targets, asked = _targets(arm, predictor, options)
    recipe = Recipe(
        arm,
        predictor,
        targets,
        arm.rest,
        options["rate"],
        options["repeats"],
        options["seed"],
        variability,
    )
    inputs = {
        **{"arm": arm.name, "description_sha256": _hash_of(arm), **learned, **asked},
        **{"start": arm.rest.tolist(), "rate_hz": options["rate"], "format": kind},
        **{"repeats": options["repeats"], "variability": options["variability"]},
        **{"seed": options["seed"], "chunk": options["chunk"], "task": task},
        **version(),
    }
    out = options["out"].absolute()
    order = Order(recipe, str(out), kind, options["chunk"], digest_of(inputs), task)
    with StageBars() as progress:
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


def _models(
    arm: ArmDescription, options: dict[str, Any]
) -> tuple[Predictor, Variability | None, dict[str, Any]]:
    """What makes the reaches and their spread, and what the manifest says of both."""
    from armsyn.arm import find_file
    from armsyn.errors import DescriptionError, InputError
    from armsyn.planning.minimum_jerk import MinimumJerkPredictor
    from armsyn.planning.planner import ATLAS, MINIMUM_JERK, default_plan

    directory = options["calibration"]
    plan = options["plan"] or default_plan(arm.name, directory)
    said: dict[str, Any] = {"plan": plan}
    if plan == MINIMUM_JERK and not options["variability"]:
        return MinimumJerkPredictor(arm.chain), None, said
    from armsyn.planning.atlas_file import load_atlas

    try:
        file = find_file(arm.name, ATLAS, directory)
    except DescriptionError as error:
        other = "leave out --variability" if plan == MINIMUM_JERK else f"use --plan {MINIMUM_JERK}"
        raise DescriptionError(
            f"no {arm.name}{ATLAS} was found: learn it by armsyn learn --arm {arm.name} --atlas, or"
            f" {other}"
        ) from error
    atlas = load_atlas(file, arm)
    said["atlas_sha256"] = _hash_of_file(file)
    predictor = MinimumJerkPredictor(arm.chain) if plan == MINIMUM_JERK else atlas.predictor(plan)
    if not options["variability"]:
        return predictor, None, said
    if atlas.variability is None:
        raise InputError(
            f"{file}: no spread between repeats in it: learn the atlas from captures with repeats"
        )
    return predictor, atlas.variability, said


def _targets(
    arm: ArmDescription, predictor: Predictor, options: dict[str, Any]
) -> tuple[Targets, dict[str, Any]]:
    """Where the reaches go, and what the manifest says of it."""
    from armsyn.errors import InputError
    from armsyn.planning.generation import targets

    given = [name for name in ("targets", "grid", "number") if options[name]]
    if len(given) != 1:
        raise InputError("give one of --targets FILE, --grid X Y Z and --random N")
    if options["box"] and not options["number"]:
        raise InputError("--box goes with --random")
    if options["targets"]:
        listed = targets.read_targets(options["targets"], arm.joint_names)
        return listed, {"targets_sha256": _hash_of_file(options["targets"])}
    if options["grid"]:
        axes = tuple(targets.checked_axis(text) for text in options["grid"])
        return targets.GridTargets(axes), {"grid": axes}
    number, seed, hull = options["number"], options["seed"], getattr(predictor, "hull", None)
    if options["box"]:
        box = targets.checked_box(options["box"])
        return targets.RandomTargets(number, seed, *box), {"random": number, "box": box}
    if hull is None:
        raise InputError("--plan minjerk knows no captured workspace: give --box X Y Z")
    return targets.random_within(number, seed, hull), {"random": number}


def _hash_of(arm: ArmDescription) -> str:
    import hashlib

    import msgspec

    return hashlib.sha256(msgspec.json.encode(arm)).hexdigest()


def _hash_of_file(path: Path) -> str:
    from armsyn.planning.generation.chunks import checksum

    return checksum(path)


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
            f"{report.evened} of them mixed with minimum jerk, {report.swivelled} with another"
            " swivel of the arm: see changes.csv"
        )
    if report.outside:
        click.echo(f"{report.outside} of them to targets outside the captured workspace")
    if refused:
        click.echo(f"refused: {refused}: see refusals.csv")
