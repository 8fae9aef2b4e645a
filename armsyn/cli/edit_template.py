"""`armsyn edit template`: a scene to be filled in."""

from __future__ import annotations

import click


@click.command()
def template() -> None:
    """Print a scene with every part it may have: armsyn edit template > scene.toml."""
    from armsyn.editing.scene import TEMPLATE

    click.echo(TEMPLATE, nl=False)
