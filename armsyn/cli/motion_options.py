"""Options that say about a motion file what it leaves open, and the file read with them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from armsyn.motion.formats import Reading

_FILE = click.Path(path_type=Path)
_OPTIONS = (
    click.option("--take", metavar="NAME", help="One motion of a file with several: FILE#NAME."),
    click.option(
        "--unit",
        help="Of the file's lengths: m, cm, mm, in, ft or a number of metres; of a joint log's"
        " angles: rad, deg.",
    ),
    click.option("--rate", type=float, metavar="HZ", help="Frames a second of the file."),
    click.option("--up", type=click.Choice(["x", "y", "z"]), help="Axis of the file that is up."),
    click.option(
        "--columns", type=_FILE, metavar="TOML", help="Which column of a table is what: a map."
    ),
    click.option(
        "--joints",
        type=_FILE,
        metavar="URDF|ARM",
        help="A table is a log of the joints of this URDF file or arm.",
    ),
    click.option("--skeleton", type=_FILE, metavar="ASF", help="The skeleton of an AMC file."),
)


def reading_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that `read` takes."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def read(path: str, given: dict[str, Any]) -> Reading:
    """Read a file as the options say.

    Parameters
    ----------
    path : str
        Or FILE#TAKE.
    given : dict
        Values of `reading_options`.

    Returns
    -------
    Reading

    Raises
    ------
    FormatError
        When the file cannot be read so.
    """
    from armsyn.motion.formats import ReadOptions, read_file

    return read_file(path, ReadOptions(**given))
