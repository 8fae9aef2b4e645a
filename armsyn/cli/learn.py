"""`armsyn learn`: synergies of an arm from captured reaches."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.choices import IKS, LEARNERS, MODELS

if TYPE_CHECKING:
    from armsyn.synergy.annealing import Schedule
    from armsyn.synergy.library import SynergyLibrary
    from armsyn.synergy.options import LearningOptions


@click.command()
@click.option(
    "--captures",
    "selection",
    metavar="SELECTION",
    help="See above; must be given without --atlas  [default with --atlas: garza:all]",
)
@click.option(
    "--atlas",
    is_flag=True,
    help="Learn reaches to any target instead: whole motions and synergies over the workspace.",
)
@click.option(
    "--repeats",
    metavar="SELECTION",
    help="With --atlas: captures with repeats, which the spread between repeats is learned from"
    " where the others have none  [default: hug_mp:S01 to S04]",
)
@click.option("--arm", "arm_name", required=True, metavar="NAME", help="The arm to learn for.")
@click.option(
    "--model",
    "models",
    type=MODELS,
    multiple=True,
    default=("C",),
    show_default=True,
    help="Synergy model; may be given several times.",
)
@click.option(
    "--ik",
    "iks",
    type=IKS,
    multiple=True,
    default=("svd",),
    show_default=True,
    help="Optimiser; may be given several times.",
)
@click.option(
    "--stable/--paper-bounds",
    default=None,
    help="Gains of at least 0.25, so that the loop provably converges, or the paper's -5 to 5."
    "  [default: stable for an arm with servos]",
)
@click.option("--lambda", "lambda_", type=float, help="Rate, 1/s  [default: the optimiser's own]")
@click.option("--rate", "rate_hz", type=float, help="Frame rate, Hz  [default: 120]")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@click.option(
    "--learner", type=LEARNERS, default="least-squares", show_default=True, help="How it learns."
)
@click.option(
    "--budget",
    type=click.IntRange(min=1),
    help="Roll-outs for each reach, optimiser and model"
    "  [default: 1000; for annealing what its schedule asks for]",
)
@click.option("--population", type=click.IntRange(min=1), help="Of --learner annealing.")
@click.option("--generations", type=click.IntRange(min=1), help="Over which its steps shrink.")
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    help="Processes  [default: as many as cores, where there is work for them]",
)
@click.option(
    "--calibration",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The only folder to look for the arm in.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Where to write  [default: the arm's .synergies.json (.atlas.json) beside its"
    " description]",
)
@click.option("--resume", is_flag=True, help="Keep what the file holds, learn the rest.")
@click.option(
    "--plot-convergence",
    "plot",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Plot the best distance over the roll-outs made.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def learn(**options: Any) -> None:
    """Learn an arm's synergies from captured reaches.

    SELECTION names captured reaches: garza (35 free reaches of one person; garza:return, the ways
    back; garza:all, both; garza:ForwardHigh, one), hug_mp:S01 (14 reaches of one person in an
    exoskeleton, on arm hug_mp4). Several are joined by commas. The captures are looked for in
    $ARMSYN_CAPTURES, else in shared/captures beside the checkout.

    Each reach gets its own parameters (Aubry, Julliard, Gibet 2009, 3.3): by reweighted least
    squares from many starts, by the paper's annealing of a population, by CMA-ES (the package
    cmaes) or by differential evolution. Ctrl-C keeps what is finished; the same command with
    --resume goes on from there. The result is the same for any number of workers.

    With --atlas the captures are put on the arm's own links and what they say about reaches to any
    target is learned: whole motions by a linear map and in their latent space, and synergies whose
    parameters are laid over the workspace, all with the movement time. How far the arm can take a
    person's postures is told. Ctrl-C leaves an atlas that was there as it was.
    """
    if options["atlas"]:
        from armsyn.cli.learn_atlas import learn_atlas_file

        learn_atlas_file(options)
        return
    if options["selection"] is None:
        raise click.UsageError("Missing option '--captures'.")
    if options["repeats"] is not None:
        raise click.UsageError("'--repeats' is for --atlas.")
    from armsyn.arm import find_file, load_arm
    from armsyn.cli.learn_plot import Convergence, checked_plot
    from armsyn.cli.long_work import StageBars, write_run
    from armsyn.motion.captures import load_captures
    from armsyn.synergy.learning import learn as learn_synergies
    from armsyn.synergy.library import save_library

    arm = load_arm(options["arm_name"], options["calibration"], calibrated=False)
    description = find_file(arm.name, ".toml", options["calibration"])
    out = options["out"] or description.with_name(f"{arm.name}.synergies.json")
    chosen = _learning_options(options, has_servos=bool(arm.servo))
    resumed = _resumed(out, options)
    check_writable(out)
    if options["plot"] is not None:
        check_writable(checked_plot(options["plot"]))
    captures = load_captures(options["selection"])
    convergence = Convergence()
    with StageBars() as progress:
        library = learn_synergies(
            *(arm, options["selection"], captures, chosen, progress.update),
            resumed=resumed,
            on_fitted=convergence.add,
        )
    if options["plot"] is not None:
        convergence.check(options["plot"])
    save_library(out, library)
    write_run(out)
    if options["plot"] is not None:
        convergence.plot(options["plot"])
    _report(library, out, as_json=options["as_json"])


def _resumed(out: Path, options: dict[str, Any]) -> SynergyLibrary | None:
    from armsyn.errors import InputError
    from armsyn.synergy.library import load_library

    if options["resume"]:
        if not out.exists():
            raise InputError(f"{out} does not exist: there is nothing to resume")
        return load_library(out)
    if options["out"] is None and out.exists():
        raise InputError(f"{out} exists already: name it with --out to replace it")
    return None


def _learning_options(options: dict[str, Any], *, has_servos: bool) -> LearningOptions:
    from armsyn.synergy.options import LearningOptions

    return LearningOptions(
        iks=tuple(dict.fromkeys(options["iks"])),
        models=tuple(dict.fromkeys(options["models"])),
        stable=has_servos if options["stable"] is None else options["stable"],
        rate_hz=120.0 if options["rate_hz"] is None else options["rate_hz"],
        lambda_=options["lambda_"],
        seed=options["seed"],
        workers=options["workers"],
        learner=options["learner"],
        budget=options["budget"],
        schedule=_schedule(options),
    )


def _schedule(options: dict[str, Any]) -> Schedule:
    from armsyn.errors import InputError
    from armsyn.synergy.annealing import Schedule

    changed = {key: options[key] for key in ("population", "generations") if options[key]}
    if changed and (options["learner"] != "annealing" or options["budget"] is not None):
        raise InputError(
            "--population and --generations are for --learner annealing without --budget"
        )
    if "generations" in changed:
        changed["max_generations"] = 2 * changed["generations"]
    return Schedule(**changed)


def check_writable(out: Path) -> None:
    """Raise InputError where a file cannot be written: learning takes minutes."""
    import tempfile

    from armsyn.errors import InputError

    if not out.parent.is_dir():
        raise InputError(f"{out}: the folder {out.parent} does not exist: make it first")
    try:
        with tempfile.TemporaryFile(dir=out.parent):
            pass
    except OSError as error:
        raise InputError(
            f"{out}: the folder {out.parent} cannot be written: {error.strerror or error}"
        ) from error


def _report(library: SynergyLibrary, out: Path, *, as_json: bool) -> None:
    import json

    rows = [row for ik in library.lambdas for row in _rows(library, ik)]
    not_fitting = {
        f"{reach.name} {s.ik}/{s.model}": s.misfit
        for reach in library.reaches
        for s in reach.sets
        if s.misfit and s.model in ("C", "D")  # S_A and S_B do not follow captured speed at all
    }
    if as_json:
        document = {
            "arm": library.arm,
            "captures": library.captures,
            "complete": library.complete,
            "out": str(out),
            "learned": rows,
            "left_out": library.left_out,
            "misfits": not_fitting,
        }
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"{library.arm}: training distance to {library.captures}")
    for heading in ("model", "ik", "lambda", "mean", "min", "max", "speed r", "usable"):
        table.add_column(heading, justify="right")
    for row in rows:
        table.add_row(
            f"S_{row['model']}",
            row["ik"],
            f"{row['lambda']:g}/s",
            *(f"{row[key] * 100:.2f} cm" for key in ("mean_m", "min_m", "max_m")),
            f"{row['mean_speed_r']:.3f}",
            f"{row['usable']} of {row['reaches']}",
        )
    console = Console()
    console.print(table)
    for name, reason in {**library.left_out, **not_fitting}.items():
        console.print(f"not used: {name}: {reason}", highlight=False, markup=False)
    if not any(row["usable"] for row in rows):
        console.print("no reach can be planned with this file: none of them fits")
    if not library.complete:
        console.print("interrupted: what was finished is kept; --resume goes on from there")
    console.print(f"wrote {out}", highlight=False, markup=False)


def _rows(library: SynergyLibrary, ik: str) -> list[dict[str, Any]]:
    rows = []
    for model in sorted({s.model for reach in library.reaches for s in reach.sets if s.ik == ik}):
        sets = [s for r in library.reaches for s in r.sets if (s.ik, s.model) == (ik, model)]
        distances = [s.distance_m for s in sets]
        rows.append(
            {
                "model": model,
                "ik": ik,
                "lambda": library.lambdas[ik],
                "reaches": len(sets),
                "mean_m": sum(distances) / len(sets),
                "min_m": min(distances),
                "max_m": max(distances),
                "mean_speed_r": sum(s.speed_r for s in sets) / len(sets),
                "usable": sum(not s.misfit for s in sets),
            }
        )
    return rows
