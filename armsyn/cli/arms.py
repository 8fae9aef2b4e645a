"""`armsyn arms`: which arms there are, what is known of one, and what other programs need of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from armsyn.cli.arms_show import show
from armsyn.cli.arms_template import template

_CALIBRATION = click.option(
    "--calibration",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="The only folder to look for arms in.",
)


@click.group(invoke_without_command=True)
@_CALIBRATION
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
@click.pass_context
def arms(context: click.Context, calibration: Path | None, as_json: bool) -> None:
    """List the arms that are described, show one, or write what other programs need of it.

    Descriptions are looked for in $ARMSYN_CALIBRATION, ./calibration, ~/.config/armsyn/calibration,
    and where the project keeps its own; the first of a name counts.
    """
    context.obj = calibration
    if context.invoked_subcommand is not None:
        if as_json:
            raise click.UsageError("--json belongs to the list of arms", context)
        return
    from armsyn.arm import arm_names
    from armsyn.errors import DescriptionError

    found = [_entry(name, calibration) for name in arm_names(calibration)]
    if as_json:
        import json

        click.echo(json.dumps({"arms": found}, indent=2, allow_nan=False))
    elif not found:
        raise DescriptionError("no arms found: name the folder of their descriptions")
    else:
        _show(found)


arms.add_command(show)
arms.add_command(template)


@arms.command()
@click.argument("name")
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Where to write; a file of that name is replaced  [default: standard output]",
)
@_CALIBRATION
@click.pass_context
def rig(context: click.Context, name: str, out: Path | None, calibration: Path | None) -> None:
    """Write an arm's rig file, for `firmware-sim --rig FILE --plant mujoco`.

    It holds the servos of arm NAME, their supply, and the arm's bodies with their masses.
    """
    from armsyn.arm import load_arm
    from armsyn.arm.rig import build_rig

    text = build_rig(load_arm(name, calibration or context.obj, calibrated=False))
    if out is None:
        click.echo(text, nl=False)
        return
    from armsyn.motion.formats.files import replacing

    with replacing(out) as temporary:
        temporary.write_text(text, encoding="utf-8")
    click.echo(f"wrote {out}", err=True)


def _entry(name: str, calibration: Path | None) -> dict[str, Any]:
    """What the list says of an arm; of a damaged description, why it cannot be used."""
    from armsyn.arm import find_file, load_arm
    from armsyn.errors import DescriptionError

    try:
        file = find_file(name, ".toml", calibration)
        arm = load_arm(name, calibration)
    except DescriptionError as error:
        return {"name": name, "error": " ".join(str(error).split())}
    return {
        "name": name,
        "file": str(file),
        "title": arm.title,
        "joints": len(arm.joint),
        "servos": len(arm.servo),
        "masses": all(joint.link is not None for joint in arm.joint),
    }


def _show(found: list[dict[str, Any]]) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table("arm", "joints", "servos", "masses", "what it is", box=None)
    for entry in found:
        cells = ["", "", "", entry.get("error", "")]
        if "error" not in entry:
            masses = "yes" if entry["masses"] else "no"
            cells = [str(entry["joints"]), str(entry["servos"]), masses, entry["title"]]
        table.add_row(*(Text(cell) for cell in (entry["name"], *cells)))
    Console().print(table)
