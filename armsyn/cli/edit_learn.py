"""`armsyn edit learn`: the pattern of a set of motions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from armsyn.editing import Clip, Figure, MotionModel

_SHOWN = 8
"""Of a body's joints, at most so many are listed."""


@click.command()
@click.argument("motions", metavar="SET...", nargs=-1, required=True)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    required=True,
    metavar="MODEL",
    help="Where to write: .npz, or .json with a CSV of components beside it; a file of that name is"
    " replaced.",
)
@click.option(
    "--variance",
    type=float,
    metavar="SHARE",
    help="Of the variance to keep  [default: 0.98]",
)
@click.option("--components", type=click.IntRange(min=1), help="How many to keep, instead.")
@click.option(
    "--frames",
    type=click.IntRange(min=2),
    help="Of the normalised motion  [default: the median of the motions']",
)
@click.option(
    "--radians-per-metre",
    type=float,
    default=2.0,
    show_default=True,
    help="What a metre of the root counts against a radian.",
)
@click.option("--arm", "arm_name", metavar="NAME", help="Learn from this arm's motions.")
@click.option(
    "--retarget",
    is_flag=True,
    help="Bring motions of other skeletons onto the first one's, by joints' names.",
)
@click.option("--unit", help="Of files' lengths: m, cm, mm, in, ft or a number of metres.")
@click.option(
    "--calibration",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The only folder to look for the arm in.",
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def learn(**options: Any) -> None:
    """Learn the pattern of a set of motions.

    Each of SET is one whole movement in a file (a body's .bvh, .npz, .amc; with --arm, recordings
    and trajectories of that arm; FILE#* is all of a file with several), or names captured ones:
    garza (35 reaches from rest; garza:return, garza:all), jump (24), golf (12 swings), or one
    such as garza:ForwardHigh.
    With --arm, captured reaches (garza, or hug_mp:S01 for hug_mp4) are put on that arm first,
    slowed until it can follow.
    """
    from armsyn.cli.edit_clips import load_examples
    from armsyn.cli.edit_files import check_places
    from armsyn.editing import ChainFigure, learn_model, save_model
    from armsyn.errors import InputError

    if options["variance"] is not None and options["components"] is not None:
        raise InputError("give either --variance or --components")
    out = options["out"]
    if out.suffix not in (".npz", ".json"):
        raise InputError(f"{out}: a model is kept as .npz or .json")
    check_places([out], options["motions"])
    figure, arm = None, None
    if options["arm_name"] is not None:
        from armsyn.arm import load_arm

        arm = load_arm(options["arm_name"], options["calibration"], calibrated=False)
        figure = ChainFigure(arm.chain, arm.name)
    clips = load_examples(options["motions"], arm, options["unit"])
    if options["retarget"]:
        clips = _on_the_first(clips, figure)
    model = learn_model(
        clips,
        figure=figure,
        frames=options["frames"],
        variance=0.98 if options["variance"] is None else options["variance"],
        components=options["components"],
        radians_per_metre=options["radians_per_metre"],
        seed=options["seed"],
    )
    save_model(out, model)
    _report(model, out, options["as_json"])


def _on_the_first(clips: list[Clip], figure: Figure | None) -> list[Clip]:
    from armsyn.editing import retargeted
    from armsyn.errors import InputError
    from armsyn.motion.body import BodyMotion

    first = clips[0]
    if figure is not None or not isinstance(first, BodyMotion):
        raise InputError("--retarget is for bodies: an arm's motions are its own")
    return [first, *(retargeted(c, first.skeleton) for c in clips[1:] if isinstance(c, BodyMotion))]


def _report(model: MotionModel, out: Path, as_json: bool) -> None:
    left_out = model.left_out_m
    worst = int(left_out.argmax())
    document = {
        **{"out": str(out), "motions": len(model.names), "frames": model.frames},
        **{"columns": model.figure.size, "components": model.size, "variance": model.variance},
        **{"duration_s": model.duration, "bodies": list(model.figure.tree.bodies)},
        **{"sigma": model.sigma.tolist(), "inputs_sha256": model.inputs_sha256},
        "left_out_m": dict(zip(model.names, left_out.tolist(), strict=True)),
        "cautions": model.doubts,
    }
    for doubt in model.doubts:
        click.echo(f"look: {doubt}", err=True)
    if as_json:
        import json

        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    click.echo(
        f"{out}: {len(model.names)} motions of {model.frames} frames x {model.figure.size}"
        f" numbers in {model.size} components, {100 * model.variance:.1f} % of the variance"
    )
    click.echo(
        f"each left out and rebuilt from the others: mean {100 * left_out.mean():.2f} cm, worst"
        f" {100 * left_out[worst]:.2f} cm ({model.names[worst]})"
    )
    bodies = model.figure.tree.bodies
    others = f", and {len(bodies) - _SHOWN} others (--json)" if len(bodies) > _SHOWN else ""
    click.echo(f"bodies to constrain: {', '.join(bodies[:_SHOWN])}{others}")
