"""`armsyn learn --atlas`: reaches of an arm to any target, from captured reaches."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from armsyn.planning.atlas import Atlas

CAPTURES = "garza:all"
_TAKEN = ("atlas", "selection", "repeats", "arm_name", "seed", "calibration", "out", "as_json")


def learn_atlas_file(options: dict[str, Any]) -> None:
    """Learn an atlas and write it.

    Parameters
    ----------
    options : dict
        Of `armsyn learn`.

    Raises
    ------
    ArmsynError
        As `armsyn.planning.atlas_learning.learn_atlas`; an option that is none of an atlas, or a
        file that is there or cannot be written.
    """
    from armsyn.arm import find_file, load_arm
    from armsyn.cli.learn import check_writable
    from armsyn.cli.long_work import StageBars, write_run
    from armsyn.motion.captures import load_captures
    from armsyn.planning.atlas import SUFFIX
    from armsyn.planning.atlas_file import save_atlas
    from armsyn.planning.atlas_learning import REPEATS, learn_atlas

    _check_options()
    arm = load_arm(options["arm_name"], options["calibration"], calibrated=False)
    out = options["out"]
    if out is None:
        description = find_file(arm.name, ".toml", options["calibration"])
        out = description.with_name(f"{arm.name}{SUFFIX}")
        _check_new(out)
    check_writable(out)
    selection = options["selection"] or CAPTURES
    captures = load_captures(selection)
    with StageBars() as progress:
        atlas = learn_atlas(
            *(arm, selection, captures),
            repeats=options["repeats"] or REPEATS,
            seed=options["seed"],
            on_progress=progress.update,
        )
    save_atlas(out, atlas)
    write_run(out)
    _report(atlas, out, as_json=options["as_json"])


def _check_options() -> None:
    from click.core import ParameterSource

    from armsyn.errors import InputError

    context = click.get_current_context()
    for parameter in context.command.params:
        given = context.get_parameter_source(parameter.name or "") is ParameterSource.COMMANDLINE
        if given and parameter.name not in _TAKEN:
            raise InputError(f"{parameter.opts[0]} is not for --atlas: leave it out")


def _check_new(out: Path) -> None:
    from armsyn.errors import InputError

    if out.exists():
        raise InputError(f"{out} exists already: name it with --out to replace it")


def _report(atlas: Atlas, out: Path, *, as_json: bool) -> None:
    import json

    import msgspec

    facts = atlas.facts
    if as_json:
        document = msgspec.to_builtins(facts) | {"kinds": atlas.kinds, "out": str(out)}
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    for line in _lines(atlas):
        click.echo(line)
    for name, reason in facts.left_out.items():
        click.echo(f"not used: {name}: {reason}")
    click.echo(f"wrote {out} ({out.stat().st_size / 1000:.0f} kB)")


def _lines(atlas: Atlas) -> list[str]:
    facts, likeness = atlas.facts, atlas.facts.likeness
    followed = ", ".join(likeness.landmarks)
    lines = [
        f"{facts.arm}: {', '.join(atlas.kinds)} from {facts.reaches} reaches to {facts.places}"
        f" places ({facts.captures})",
        f"follows the captured {followed} to {likeness.residual_m * 100:.1f} cm on the mean,"
        f" {likeness.worst_m * 100:.1f} cm at worst",
    ]
    off = {"upper arm": likeness.upper_arm_deg, "forearm": likeness.forearm_deg}
    said = [f"{name} {angle:.0f}" for name, angle in off.items() if angle is not None]
    if said:
        lines.append(f"degrees between its segments and the person's: {', '.join(said)}")
    if atlas.variability is not None:
        lines.append(
            f"spread between repeats: {len(atlas.variability.times)} modes from"
            f" {atlas.variability.repeats} repeats ({facts.repeats})"
        )
    if len(likeness.landmarks) == 1:
        lines.append(
            f"its {len(facts.joint_names)} joints follow the hand's path alone: how a person holds"
            " elbow and forearm on the way is not expressed"
        )
    return lines
