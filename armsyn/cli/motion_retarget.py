"""`armsyn motion retarget`: a captured arm put on a described arm's link lengths."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.arm_options import calibration_option
from armsyn.cli.motion_options import reading_options

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.cli.motion_takes import Take
    from armsyn.motion import Motion

_FILE = click.Path(path_type=Path, dir_okay=False)


@click.command()
@click.argument("source", metavar="FILE|CAPTURE")
@click.option("--arm", "arm_name", required=True, metavar="NAME", help="The arm to put it on.")
@click.option("--out", type=_FILE, required=True, help="Where it goes: .npz, .csv or .trc.")
@click.option(
    "--landmark",
    "pairs",
    multiple=True,
    metavar="NAME=POINT",
    help="What a landmark of the arm is in FILE, such as elbow=LEL+LEM (may be repeated; the"
    " shoulder first, the hand last).  [default: as known captures have them]",
)
@click.option(
    "--chest",
    metavar="JOINT|IJ+PX+C7+T8",
    help="What the trunk's motion is removed by: a joint of the skeleton, or four markers.",
)
@click.option("--from", "of_arm", metavar="ARM", help="FILE has joint angles of this arm.")
@click.option(
    "--align",
    nargs=2,
    metavar="POSES ARM_POSES",
    help="One base transform for the session, fitted to the same calibration poses of both.",
)
@click.option("--facing", type=float, metavar="DEG", help="Where the person faces, from x about z.")
@click.option("--mirror", is_flag=True, help="Exchange left and right: a left arm for a right one.")
@click.option("--return", "is_return", is_flag=True, help="FILE is the way back to rest.")
@click.option("--angles", is_flag=True, help="Fit the arm's joint angles, too, and write both.")
@calibration_option
@reading_options
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def retarget(source: str, **options: Any) -> None:
    """Put the arm of a captured motion on a described arm's link lengths.

    FILE may hold a skeleton, markers, landmarks or a robot's recording; garza:ForwardHigh names a
    captured reach. The trunk's motion is removed, not modelled: landmarks are taken in the chest's
    frame (x forward, y left, z up), relative to the shoulder, and rebuilt along their directions on
    the arm's links, from where its own shoulder is. An arm that describes its hand alone gets the
    hand's path, scaled. What ends up in OUT is in the arm's base frame; with --angles its landmarks
    are those that the fitted angles give.
    """
    from armsyn.arm import load_arm
    from armsyn.errors import InputError
    from armsyn.motion import retargeting
    from armsyn.motion.formats import write_motion

    _check_written(options["out"], angles=options["angles"])
    if options["align"] and options["facing"] is not None:
        raise InputError("--facing and --align both say how the base is turned: give one of them")
    arm = load_arm(options["arm_name"], options["calibration"], calibrated=False)
    person, facts = _person(source, arm, options)
    person, facts["base"] = _in_base(person, source, arm, options)
    motion = retargeting.retarget(person, arm, is_return=options["is_return"])
    residuals = None
    if options["angles"]:
        motion, residuals = _fitted(arm, motion)
    write_motion(options["out"], motion)
    _report(source, options, person, motion, facts, residuals)


def _check_written(out: Path, *, angles: bool) -> None:
    """Fitting takes a while: find out before."""
    from armsyn.errors import InputError
    from armsyn.motion.formats import FORMATS

    form = FORMATS.get(out.suffix.lower())
    if form is None or form.write is None:
        known = ", ".join(suffix for suffix, kind in FORMATS.items() if kind.write)
        raise InputError(f"{out}: landmarks are written as one of {known}")
    if angles and out.suffix.lower() == ".trc":
        raise InputError(f"{out}: has no place for --angles: name an .npz or .csv file")
    if not out.parent.is_dir():
        raise InputError(f"{out}: the folder {out.parent} does not exist: make it first")


def _only(source: str, options: dict[str, Any]) -> Take:
    from armsyn.cli.motion_takes import all_takes
    from armsyn.errors import InputError

    takes = all_takes(source, options)
    first = next(takes)
    others = [take.name for take in takes]
    if others:
        names = ", ".join([first.name, *others[:2]])
        raise InputError(f"{source}: {1 + len(others)} motions in it, one is needed: {names}, ...")
    return first


def _person(
    source: str, arm: ArmDescription, options: dict[str, Any]
) -> tuple[Motion, dict[str, str]]:
    """Landmarks of the arm that was captured, and how they were found."""
    from armsyn.motion.retargeting import mirrored

    person, facts = _as_captured(source, arm, options)
    if not options["mirror"]:
        return person, facts
    return mirrored(person), {**facts, "mirrored": "left and right exchanged"}


def _as_captured(
    source: str, arm: ArmDescription, options: dict[str, Any]
) -> tuple[Motion, dict[str, str]]:
    from armsyn.arm import load_arm
    from armsyn.errors import InputError
    from armsyn.motion.landmarks import LAYOUTS, arm_of_angles, known_layout

    take, chest = _only(source, options), options["chest"]
    names = take.body.skeleton.names if take.body else take.motion.landmark_names
    if options["of_arm"]:
        if options["pairs"] or chest:
            raise InputError("--from takes the described arm's landmarks: leave out the others")
        other = load_arm(options["of_arm"], options["calibration"], calibrated=False)
        said = {"landmarks": f"by the joint angles of {other.name}", "trunk": "none"}
        return arm_of_angles(take.motion, other), {**take.facts, **said}
    if options["pairs"]:
        return _found(take, _points(options["pairs"]), chest)
    kind = known_layout(names)
    if kind is not None:
        points, own_chest = LAYOUTS[kind]
        motion, facts = _found(take, dict(points), chest or own_chest)
        return motion, {**facts, "layout": f"{kind} (recognised)"}
    if chest:
        raise InputError("--chest: say with --landmark, too, what the arm's landmarks are")
    if not set(arm.landmarks) <= set(take.motion.landmark_names):
        shown = ", ".join(names[:60]) or f"none, only joints {', '.join(take.motion.joint_names)}"
        raise InputError(
            f"{source}: say what the landmarks {', '.join(arm.landmarks)} are in it (--landmark"
            f" NAME=POINT), or whose joint angles it has (--from ARM); there are {shown}"
        )
    trunk = "removed when it was captured" if take.cut else "kept but for the shoulder's moving"
    return take.motion, {**take.facts, "landmarks": "as they are named", "trunk": trunk}


def _points(pairs: tuple[str, ...]) -> dict[str, str]:
    from armsyn.errors import InputError

    found: dict[str, str] = {}
    for text in pairs:
        name, _, point = text.partition("=")
        if not name or not point or name in found:
            raise InputError(f"--landmark {text!r}: say NAME=POINT, each name once")
        found[name] = point
    if len(found) < 2:
        raise InputError("--landmark: the shoulder and the hand at least are needed")
    return found


def _found(take: Take, points: dict[str, str], chest: str | None) -> tuple[Motion, dict[str, str]]:
    from armsyn.motion.landmarks import arm_of_body, arm_of_markers

    facts = {
        **take.facts,
        "landmarks": ", ".join(f"{name}={point}" for name, point in points.items()),
        "trunk": f"removed by the frame of {chest}"
        if chest
        else "kept but for the shoulder's moving",
    }
    named = [*points.values(), *([chest] if chest else [])]
    if take.body is not None and set(named) <= set(take.body.skeleton.names):
        return arm_of_body(take.body, points, chest), facts
    return arm_of_markers(take.motion, points, chest), facts


def _in_base(
    person: Motion, source: str, arm: ArmDescription, options: dict[str, Any]
) -> tuple[Motion, str]:
    """Turn the person as the arm's base is turned."""
    import dataclasses
    import math

    from armsyn.kinematics.rotation import from_expmap
    from armsyn.motion.base_transform import check_poses, fit_base_transform
    from armsyn.motion.landmarks import arm_of_angles

    if options["align"]:
        poses, _ = _person(options["align"][0], arm, options)
        bare = {**options, **dict.fromkeys(("take", "rate", "up", "unit", "columns", "skeleton"))}
        own = _only(options["align"][1], bare).motion
        check_poses((own, poses), (person, _only(source, options).motion))
        if set(arm.joint_names) <= set(own.joint_names):
            own = arm_of_angles(own, arm)
        transform = fit_base_transform(own, poses)
        said = (
            f"one transform of {transform.poses} calibration poses,"
            f" {transform.residual * 100:.1f} cm rms off"
        )
        return transform.apply(person), said
    if options["facing"] is None:
        return person, "x forward, as captured"
    turn = from_expmap([0.0, 0.0, -math.radians(options["facing"])])
    assert person.landmarks is not None  # noqa: S101 - those of an arm
    turned = dataclasses.replace(person, landmarks=person.landmarks @ turn.T)
    return turned, f"turned from {options['facing']:g} degrees to x"


def _fitted(arm: ArmDescription, motion: Motion) -> tuple[Motion, list[float]]:
    from armsyn.cli.long_work import StageBars
    from armsyn.motion.retargeting import fit_angles

    with StageBars() as bars:
        track = fit_angles(
            arm, motion, lambda done: bars.update("fitting", done, motion.frames, "")
        )
    return track.motion, track.residuals.tolist()


def _report(
    source: str,
    options: dict[str, Any],
    person: Motion,
    motion: Motion,
    facts: dict[str, str],
    residuals: list[float] | None,
) -> None:
    from armsyn.motion.rebuilding import segment_lengths

    assert person.landmarks is not None  # noqa: S101 - those of an arm
    assert motion.landmarks is not None  # noqa: S101 - those of an arm
    document = {
        **{"in": source, "out": str(options["out"]), "arm": options["arm_name"], "facts": facts},
        **{"frames": motion.frames, "rate_hz": motion.rate},
        **{"landmarks": list(motion.landmark_names), "joints": list(motion.joint_names)},
        "captured_segments_m": segment_lengths(person.landmarks).tolist(),
        "segments_m": segment_lengths(motion.landmarks).tolist(),
        "fit_mean_m": None if residuals is None else sum(residuals) / len(residuals),
        "fit_worst_m": None if residuals is None else max(residuals),
    }
    if options["as_json"]:
        import json

        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    for key, value in facts.items():
        click.echo(f"{key}: {value}")
    for key, text in (("captured_segments_m", "captured"), ("segments_m", options["arm_name"])):
        lengths = ", ".join(f"{length * 100:.1f}" for length in document[key])
        click.echo(f"segments, {text}: {lengths + ' cm' if lengths else 'none, the hand alone'}")
    if residuals is not None:
        click.echo(
            f"joint angles: landmarks off by {document['fit_mean_m'] * 100:.2f} cm on the mean,"
            f" {document['fit_worst_m'] * 100:.2f} at worst"
        )
    click.echo(f"{options['out']}: {motion.frames} frames at {motion.rate:.6g} Hz")
