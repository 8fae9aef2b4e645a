"""`armsyn edit apply`: one clip bent to constraints, checked, scored and written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.choices import FiniteRange

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.editing import (
        Clip,
        Constraint,
        EditResult,
        Effector,
        KeyFrame,
        MotionModel,
        SolverOptions,
    )

_FILE = click.Path(path_type=Path, dir_okay=False)
_TRIPLE = (float, float, float)


@click.command()
@click.argument("clip")
@click.option("--model", "model_path", type=_FILE, required=True, help="Of armsyn edit learn.")
@click.option(
    "--scene", type=_FILE, metavar="TOML", help="Constraints; armsyn edit template writes one."
)
@click.option(
    "--point", metavar="BODY", help="A key-frame of this body (tip: an arm's), or BODY:X,Y,Z."
)
@click.option("--frame", type=int, help="At this frame; negative from the end  [default: -1]")
@click.option(
    "--to",
    nargs=3,
    type=_TRIPLE,
    metavar="X Y Z",
    help="Goes there, m; z is up, a body's x forward, y left; an arm's base frame.",
)
@click.option(
    "--by", nargs=3, type=_TRIPLE, metavar="X Y Z", help="Is moved by that, m: 0 0 0.1 is 10 cm up."
)
@click.option("--level", type=click.IntRange(min=1), help="Its priority  [default: 1]")
@click.option(
    "--slower",
    type=FiniteRange(min=1.0, max=100.0),
    metavar="FACTOR",
    help="An arm's clip takes FACTOR times its time, before it is edited.",
)
@click.option("--pin", "pins", multiple=True, metavar="BODY", help="Stays; repeatable.")
@click.option(
    "--out",
    type=_FILE,
    required=True,
    metavar="FILE",
    help="A body's .bvh, .npz or .csv (positions); an arm's .npz or .csv. Files of that name are"
    " replaced, here and below.",
)
@click.option("--latent", type=_FILE, metavar="FILE.json", help="Write the latent variables, too.")
@click.option("--report", "page", type=_FILE, metavar="FILE.html", help="Write a page about it.")
@click.option("--plot", type=_FILE, metavar="FILE.png", help="Draw before and after.")
@click.option("--force", is_flag=True, help="However far from the examples, or the goal.")
@click.option("--unit", help="Of CLIP's lengths: m, cm, mm, in, ft or a number of metres.")
@click.option("--retarget", is_flag=True, help="Bring CLIP onto the model's skeleton, by names.")
@click.option(
    "--calibration",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The only folder to look for the arm in.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def apply(**options: Any) -> None:
    """Bend CLIP to constraints without leaving the pattern of MODEL.

    CLIP is one movement, as for `armsyn edit learn`. An arm's comes out from rest to rest, within
    its description's ranges, speeds and accelerations and free of collisions, or not at all; it
    can be streamed then. What is left of the clip that the pattern does not hold stays as it is.
    Exit status 4, nothing written: too far from the examples, the first level missed by more than
    a millimetre (--force writes both anyway), or unsafe for the arm (which --force does not).
    """
    from armsyn.cli.edit_clips import load_clip, on_skeleton_of
    from armsyn.cli.edit_files import check_outputs, check_suffix, tell, write
    from armsyn.cli.edit_safety import check_safe
    from armsyn.editing import Editor, load_model
    from armsyn.editing.report import score_edit

    check_outputs(options)
    model = load_model(options["model_path"])
    arm = _arm_of(model, options)
    check_suffix(options["out"], arm)
    constraints, solver = _asked(options)
    clip = load_clip(options["clip"], arm, options["unit"])
    if options["retarget"]:
        clip = on_skeleton_of(clip, model.figure)

    def edited(slower: float | None) -> EditResult:
        return Editor(_slowed(clip, slower), model, solver).edit(
            constraints, force=options["force"]
        )

    result, slower = edited(options["slower"]), options["slower"] or 1.0
    notes = [] if arm is None else check_safe(result, arm, slower, edited)
    scored = score_edit(result)
    write(result, model, scored, solver.coefficient_bound, notes, options)
    tell(result, scored, solver.coefficient_bound, notes, options)


def _slowed(clip: Clip, factor: float | None) -> Clip:
    from armsyn.driver.replay import slowed
    from armsyn.errors import InputError
    from armsyn.motion import Motion

    if factor is None:
        return clip
    if not isinstance(clip, Motion):
        raise InputError("--slower is for arms, which are slower than people")
    return slowed(clip, factor, clip.rate)


def _arm_of(model: MotionModel, options: dict[str, Any]) -> ArmDescription | None:
    from armsyn.editing import ChainFigure
    from armsyn.errors import InputError

    if not isinstance(model.figure, ChainFigure):
        return None
    from armsyn.arm import load_arm

    arm = load_arm(model.figure.name, options["calibration"], calibrated=False)
    own, learned = arm.chain, model.figure.chain
    if (own.joints, own.tip_xyz, own.tip_rpy) != (learned.joints, learned.tip_xyz, learned.tip_rpy):
        raise InputError(
            f"{options['model_path']}: learned for another description of {arm.name}: learn again"
        )
    return arm


def _asked(options: dict[str, Any]) -> tuple[list[Constraint], SolverOptions]:
    """Return the constraints of scene and command line, and the scene's solver."""
    from armsyn.editing import Pin, SolverOptions
    from armsyn.editing.scene import load_scene
    from armsyn.errors import InputError

    constraints: list[Constraint] = []
    solver = SolverOptions()
    if options["scene"] is not None:
        scene = load_scene(options["scene"])
        constraints, solver = list(scene.constraints), scene.options
    if options["point"] is not None:
        constraints.append(_key_frame(options))
    elif any(options[key] is not None for key in ("frame", "to", "by", "level")):
        raise InputError("--frame, --to, --by and --level say what --point does: give --point")
    if not constraints:
        raise InputError("nothing is asked for: give --scene, or --point with --to or --by")
    return constraints + [Pin(_effector(text)) for text in options["pins"]], solver


def _key_frame(options: dict[str, Any]) -> KeyFrame:
    from armsyn.editing import KeyFrame
    from armsyn.errors import InputError

    if (options["to"] is None) == (options["by"] is None):
        raise InputError("--point goes --to a place or is moved --by something: give one of them")
    return KeyFrame(
        _effector(options["point"]),
        -1 if options["frame"] is None else options["frame"],
        options["to"],
        options["by"],
        options["level"] or 1,
    )


def _effector(text: str) -> Effector:
    from armsyn.editing import Effector
    from armsyn.errors import ConstraintError

    body, colon, place = text.rpartition(":")
    if not colon:
        return Effector(text)
    try:
        x, y, z = (float(number) for number in place.split(","))
    except ValueError:
        raise ConstraintError(f"{text!r}: give a body, or BODY:X,Y,Z in metres") from None
    return Effector(body, (x, y, z))
