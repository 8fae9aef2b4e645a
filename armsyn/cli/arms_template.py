"""`armsyn arms template`: a description of one's own arm to be filled in."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.option("--name", default="my_arm", show_default=True, help="Of the arm and its file.")
@click.option(
    "--urdf",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Take joints, limits and masses from this URDF.",
)
@click.option("--base", metavar="LINK", help="Of the URDF: the arm's base  [default: the root]")
@click.option("--tip", metavar="LINK", help="Of the URDF: the hand  [default: the only end]")
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Where to write; no file is replaced  [default: standard output]",
)
def template(
    name: str, urdf: Path | None, base: str | None, tip: str | None, out: Path | None
) -> None:
    """Write a description of your own arm to be filled in, with comments.

    Keep it as NAME.toml: armsyn arms template > calibration/my_arm.toml. From a URDF it is filled
    in as far as that goes; keep the two files in one folder.
    """
    from armsyn.arm.template import build_template
    from armsyn.errors import InputError

    if urdf is None and (base or tip):
        raise InputError("--base and --tip name links of a URDF: give --urdf as well")
    text = build_template(name, urdf, base, tip, None if out is None else out.parent)
    if out is None:
        click.echo(text, nl=False)
        return
    try:
        with out.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError as error:
        raise InputError(f"{out} exists already: name another, or remove it first") from error
    except OSError as error:
        raise InputError(f"{out}: cannot write it: {error.strerror or error}") from error
    click.echo(f"wrote {out}", err=True)
