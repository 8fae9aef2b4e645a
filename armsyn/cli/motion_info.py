"""`armsyn motion info`: what is in a motion file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.motion_options import read, reading_options

if TYPE_CHECKING:
    from armsyn.motion.formats import Reading

_SHOWN = 12
_SUMMED_UP = 5


@click.command()
@click.argument("file")
@reading_options
@click.option("--plot", type=click.Path(path_type=Path), help="Write a plot of the speeds.")
@click.option(
    "--landmark", "wanted", multiple=True, help="Plot this landmark's speed (may be repeated)."
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def info(
    file: str, plot: Path | None, wanted: tuple[str, ...], as_json: bool, **given: Any
) -> None:
    """Show what is in a motion FILE: rate, joints, landmarks, gaps, glitches.

    A file that holds several motions is listed; --take NAME (or FILE#NAME) shows one of them.
    Frames are counted from 0.
    """
    from armsyn.errors import InputError
    from armsyn.motion.formats import FORMATS, split_take, takes_in

    if wanted and plot is None:
        raise InputError("--landmark says what is plotted: give --plot FILE with it")
    path, take = split_take(file)
    takes = takes_in(path)
    if len(takes) > 1 and plot is None and not (take or given["take"]):
        _show_takes(file, FORMATS[path.suffix.lower()].name, takes, as_json)
        return
    reading = read(file, given)
    document = {
        "file": file,
        "format": FORMATS[path.suffix.lower()].name,
        **describe(reading),
    }
    if as_json:
        import json

        click.echo(json.dumps(document, indent=2, allow_nan=False))
    else:
        _show(document)
    if plot is not None:
        from armsyn.cli.motion_plot import plot_speeds

        plot_speeds(plot, reading.motion, wanted)


def _show_takes(file: str, kind: str, takes: tuple[str, ...], as_json: bool) -> None:
    if as_json:
        import json

        click.echo(json.dumps({"file": file, "format": kind, "takes": list(takes)}, indent=2))
        return
    click.echo(f"{file}: {kind} with {len(takes)} motions; look at one with --take NAME:")
    for name in takes:
        click.echo(f"  {name}")


def describe(reading: Reading) -> dict[str, Any]:
    """Return what is in a file as values of a JSON document.

    Parameters
    ----------
    reading : Reading

    Returns
    -------
    dict
        SI units; gaps at the ends have null seconds.
    """
    import numpy as np

    from armsyn.motion.gaps import find_gaps

    motion = reading.motion
    steps = np.diff(motion.time)
    return {
        "source": motion.source,
        "facts": reading.facts,
        "frames": motion.frames,
        "duration_s": motion.duration,
        "rate_hz": motion.rate,
        "shortest_step_s": float(steps.min()),
        "longest_step_s": float(steps.max()),
        "joints": list(motion.joint_names),
        "landmarks": list(motion.landmark_names),
        "skeleton": list(reading.body.skeleton.names) if reading.body else [],
        "gaps": [
            {**gap._asdict(), "seconds": gap.seconds if np.isfinite(gap.seconds) else None}
            for gap in find_gaps(motion)
        ],
        "filled_frames": 0 if motion.filled is None else int(motion.filled.any(axis=1).sum()),
        "glitches": _glitches(reading),
    }


def _glitches(reading: Reading) -> list[dict[str, Any]]:
    from armsyn.motion.glitches import find_glitches

    found = find_glitches(reading.motion)
    if reading.body and reading.motion.landmark_names != reading.body.skeleton.names:
        found += find_glitches(reading.body.as_motion())
    return [glitch._asdict() for glitch in found]


def _show(document: dict[str, Any]) -> None:
    click.echo(f"{document['file']}: {document['format']}")
    for key, value in document["facts"].items():
        click.echo(f"  {key}: {value}")
    click.echo(
        f"  {document['frames']} frames, {document['duration_s']:.3f} s,"
        f" {document['rate_hz']:.6g} Hz{_jitter(document)}"
    )
    for part in ("joints", "landmarks"):
        if document[part]:
            click.echo(f"  {len(document[part])} {part}: {_listed(document[part])}")
    if document["skeleton"] == document["landmarks"] and document["skeleton"]:
        click.echo("  the landmarks are all the joints of a skeleton")
    elif document["skeleton"]:
        names = document["skeleton"]
        click.echo(f"  a skeleton of {len(names)} joints: {_listed(names)}")
    _show_gaps(document)
    if document["filled_frames"]:
        click.echo(f"  filled in: positions of {document['filled_frames']} frames")
    frames = sorted({glitch["frame"] for glitch in document["glitches"]})
    if frames:
        click.echo(f"  glitches, steps unlike those around them, at frames {_listed(frames)}")


def _jitter(document: dict[str, Any]) -> str:
    shortest, longest = document["shortest_step_s"], document["longest_step_s"]
    if longest - shortest < 1e-3 / document["rate_hz"]:
        return ""
    return f", unevenly: steps of {shortest * 1e3:.3g} to {longest * 1e3:.3g} ms"


def _listed(names: list[Any]) -> str:
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(map(str, names[:_SHOWN])) + more


def _show_gaps(document: dict[str, Any]) -> None:
    gaps = document["gaps"]
    if not document["landmarks"]:
        return
    if not gaps:
        click.echo("  no gaps")
        return
    click.echo(f"  {len(gaps)} {'gap' if len(gaps) == 1 else 'gaps'}:")
    by_landmark: dict[str, list[dict[str, Any]]] = {}
    for gap in gaps:
        by_landmark.setdefault(gap["landmark"], []).append(gap)
    for name, own in by_landmark.items():
        frames = sum(gap["last"] - gap["first"] + 1 for gap in own)
        where = ", ".join(f"{gap['first']}-{gap['last']}" for gap in own[:_SUMMED_UP])
        more = ", ..." if len(own) > _SUMMED_UP else ""
        inner = [gap["seconds"] for gap in own if gap["seconds"] is not None]
        longest = f", longest {max(inner):.3f} s" if inner else ""
        click.echo(f"    {name}: {frames} frames in {len(own)}: {where}{more}{longest}")
