"""`armsyn score`: compare a motion with a captured one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from armsyn.motion import Motion


@click.command()
@click.argument("captured", metavar="A")
@click.argument("other", metavar="B")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def score(captured: str, other: str, as_json: bool) -> None:
    """Score motion B against the captured (or reference) motion A.

    Each is a file (.csv, .npz, a recording of `armsyn reach --record`) or one captured reach, such
    as garza:ForwardHigh or hug_mp:S01:1.1.1:R-1. Both need landmark positions in one frame.
    """
    import json

    from armsyn.scoring import compare
    from armsyn.scoring.report import as_dict
    from armsyn.scoring.tables import distance_table, profile_table

    comparison = compare(load_motion(captured), load_motion(other))
    if as_json:
        document = {"a": captured, "b": other, **as_dict(comparison)}
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    from rich.console import Console

    console = Console()
    console.print(f"A {captured}: {comparison.captured_source}", highlight=False, markup=False)
    console.print(f"B {other}: {comparison.other_source}", highlight=False, markup=False)
    console.print(distance_table(comparison), profile_table(comparison))
    for label, found in (("A", comparison.captured_profile), ("B", comparison.other_profile)):
        console.print(
            f"{label}: the largest movement counts, from {found.onset:.2f} to {found.offset:.2f} s"
        )
    if comparison.left_out:
        console.print(f"landmarks in only one of them: {', '.join(comparison.left_out)}")


def load_motion(text: str) -> Motion:
    """Return the motion that a file or a selection of captures names.

    Parameters
    ----------
    text : str
        A path with a known suffix, or a selection such as `garza:ForwardHigh`.

    Returns
    -------
    Motion
        As read.

    Raises
    ------
    FormatError
        When the file is damaged, missing or of no known format.
    CaptureError
        When the selection names no capture, or several.
    """
    from pathlib import Path

    from armsyn.errors import FormatError
    from armsyn.motion.formats import FORMATS, read_motion

    if Path(text).suffix.lower() in FORMATS:
        return read_motion(text)
    from armsyn.motion.captures import load_capture

    motion = load_capture(text)
    if motion is None:
        known = ", ".join(FORMATS)
        raise FormatError(
            f"{text}: neither a motion file ({known}) nor a captured reach: name one, such as"
            " reach.npz or garza:ForwardHigh"
        )
    return motion
