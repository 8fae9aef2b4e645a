"""What the options of `armsyn generate` mean: arm, predictor, targets, start; and their record."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.motion import FloatArray
    from armsyn.planning.generation.batch import Recipe
    from armsyn.planning.generation.targets import Targets
    from armsyn.planning.generation.variability import Variability
    from armsyn.planning.prediction import Predictor


MOST_FRAMES = 3e7
"""In a chunk: 1.7 GB of angles, for seven joints."""
USUAL_S = 1.5
"""Duration of a reach that is not slowed further."""


class _Learned(NamedTuple):
    """What makes the reaches and their spread, and what the manifest says of both."""

    predictor: Predictor
    variability: Variability | None
    said: dict[str, Any]


def recipe_of(options: dict[str, Any]) -> tuple[Recipe, dict[str, Any]]:
    """Return what is asked for, and what the manifest says that reaches are made from.

    Parameters
    ----------
    options : dict
        Of the command.

    Raises
    ------
    InputError
        Options that contradict one another, or are no numbers of what they say.
    DescriptionError
        The arm, its calibration or its atlas is missing or unusable.
    FormatError
        A file of targets, or of a start, that cannot be read.
    """
    from armsyn.arm import load_arm
    from armsyn.cli.moving import check_slower
    from armsyn.cli.orientation_options import asked as said_of
    from armsyn.cli.orientation_options import orientation_of, tolerance_of
    from armsyn.planning.generation.batch import Recipe

    check_slower(options["slower"])
    orientation = orientation_of(options)
    arm = load_arm(options["arm_name"], options["calibration"], unit=options["unit"])
    arm = arm.slowed(options["slower"])
    learned = _models(arm, options)
    targets, asked = _targets(arm, learned.predictor, options)
    start = arm.rest if options["start"] is None else start_of(arm, options["start"])
    _check_frames(targets, options)
    recipe = Recipe(
        arm,
        learned.predictor,
        targets,
        start,
        options["rate"],
        options["repeats"],
        options["seed"],
        learned.variability,
        orientation,
    )
    inputs = {
        **{"arm": arm.name, "unit": options["unit"], "description_sha256": _hash_of(arm)},
        **{"slower": options["slower"], **learned.said, **asked},
        **{"orientation": said_of(orientation), "orientation_tolerance_rad": tolerance_of(options)},
        **{"start": start.tolist(), "rate_hz": options["rate"]},
        **{"repeats": options["repeats"], "variability": options["variability"]},
        **{"seed": options["seed"], "chunk": options["chunk"]},
    }
    return recipe, inputs


def _check_frames(targets: Targets, options: dict[str, Any]) -> None:
    """Refuse a chunk that would not fit in memory."""
    from armsyn.errors import InputError
    from armsyn.planning.pacing import thinning

    rate = options["rate"] * thinning(options["rate"])
    one = USUAL_S * options["slower"] * rate
    frames = min(options["chunk"], targets.size * options["repeats"]) * one
    if frames > MOST_FRAMES:
        raise InputError(
            f"a chunk would have some {frames:.1g} frames in memory, more than {MOST_FRAMES:.0g}:"
            f" give a smaller --rate or --slower, or a --chunk of {max(1, int(MOST_FRAMES / one))}"
        )


def start_of(arm: ArmDescription, text: str) -> FloatArray:
    """Read a posture: numbers by commas, or the last posture of a motion's file.

    Parameters
    ----------
    arm : ArmDescription
    text : str
        ``J1,J2,...`` of all joints, rad or m; or FILE, or FILE#TAKE.

    Returns
    -------
    array, shape (n,)

    Raises
    ------
    InputError
        Neither of them, or a posture outside the joints' ranges.
    """
    import numpy as np

    from armsyn.errors import InputError, LimitError
    from armsyn.motion.formats import read_motion, split_take
    from armsyn.planning.checking import checked_start

    try:
        posture = np.array([float(part) for part in text.split(",")])
    except ValueError:
        if not split_take(text)[0].is_file():
            raise InputError(
                f"--start '{text[:80]}' is no file, and not the {arm.chain.dof} numbers (rad or m,"
                f" by commas) of {', '.join(arm.joint_names)}"
            ) from None
        motion = read_motion(text)
        if motion.angles is None or not {*arm.joint_names} <= {*motion.joint_names}:
            raise InputError(f"--start {text}: has no angles of all joints of {arm.name}") from None
        posture = motion.angles[-1, [motion.joint_names.index(name) for name in arm.joint_names]]
    if posture.shape != (arm.chain.dof,):
        raise InputError(
            f"--start: {posture.size} numbers, expected {arm.chain.dof} (rad or m) of"
            f" {', '.join(arm.joint_names)}"
        )
    try:
        return checked_start(arm, posture)
    except (InputError, LimitError) as error:
        raise InputError(f"--start: {error}") from error


def _models(arm: ArmDescription, options: dict[str, Any]) -> _Learned:
    from armsyn.arm import find_file
    from armsyn.errors import DescriptionError, InputError
    from armsyn.planning.planner import ATLAS, MINIMUM_JERK, by_minimum_jerk, default_plan

    directory = options["calibration"]
    plan = options["plan"] or default_plan(arm.name, directory)
    said: dict[str, Any] = {"plan": plan}
    rule = by_minimum_jerk(arm, directory) if plan == MINIMUM_JERK else None
    if rule is not None and rule.hull is None and not options["variability"]:
        return _Learned(rule, None, said)
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
    predictor = rule or atlas.predictor(plan)
    if not options["variability"]:
        return _Learned(predictor, None, said)
    if atlas.variability is None:
        raise InputError(
            f"{file}: no spread between repeats in it: learn the atlas from captures with repeats"
        )
    return _Learned(predictor, atlas.variability, said)


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
        return _listed(arm, options)
    _check_tolerance_has_use(options, turned=False)
    if options["grid"]:
        axes = tuple(targets.checked_axis(text) for text in options["grid"])
        return targets.GridTargets(axes), {"grid": axes}
    number, seed, hull = options["number"], options["seed"], getattr(predictor, "hull", None)
    if options["box"]:
        box = targets.checked_box(options["box"])
        return targets.RandomTargets(number, seed, *box), {"random": number, "box": box}
    if hull is None:
        raise InputError(f"no captured workspace of {arm.name} is known: give --box X Y Z")
    return targets.random_within(number, seed, hull), {"random": number}


def _listed(arm: ArmDescription, options: dict[str, Any]) -> tuple[Targets, dict[str, Any]]:
    from armsyn.cli.orientation_options import tolerance_of
    from armsyn.errors import InputError
    from armsyn.planning.generation.target_file import read_targets

    file: Path = options["targets"]
    listed = read_targets(file, arm.joint_names, tolerance_of(options))
    if listed.turns is not None and (options["pointing"] or options["orientation"]):
        raise InputError(f"{file}: its columns say how hands are turned: give no other way")
    if listed.starts is not None and options["start"]:
        raise InputError(f"{file}: its columns say where reaches start: leave out --start")
    _check_tolerance_has_use(options, turned=listed.turns is not None)
    return listed, {"targets_sha256": _hash_of_file(file)}


def _check_tolerance_has_use(options: dict[str, Any], *, turned: bool) -> None:
    from armsyn.errors import InputError

    turned = turned or bool(options["pointing"] or options["orientation"])
    if options["orientation_tolerance"] is not None and not turned:
        raise InputError(
            "--orientation-tolerance needs --pointing, --orientation, or columns of --targets that"
            " say how hands are turned"
        )


def _hash_of(arm: ArmDescription) -> str:
    import hashlib

    import msgspec

    return hashlib.sha256(msgspec.json.encode(arm)).hexdigest()


def _hash_of_file(path: Path) -> str:
    from armsyn.planning.generation.chunks import checksum

    return checksum(path)
