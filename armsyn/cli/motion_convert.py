"""`armsyn motion convert`: one motion file written as another."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.motion_options import read, reading_options

if TYPE_CHECKING:
    from armsyn.motion import Motion
    from armsyn.motion.formats import Reading


@click.command()
@click.argument("source", metavar="IN")
@click.argument("out", metavar="OUT", type=click.Path(path_type=Path))
@reading_options
@click.option(
    "--fill-gaps",
    type=float,
    metavar="SECONDS",
    help="Fill gaps of landmarks up to so long by a spline, and mark where.",
)
@click.option("--resample", type=float, metavar="HZ", help="Interpolate to this rate.")
@click.option(
    "--landmarks",
    metavar="A,B,...",
    help="Keep these, in this order: the end effector last.",
)
@click.option("--body", is_flag=True, help="Write the whole skeleton (always so for .bvh).")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def convert(
    source: str,
    out: Path,
    fill_gaps: float | None,
    resample: float | None,
    landmarks: str | None,
    body: bool,
    as_json: bool,
    **given: Any,
) -> None:
    """Write the motion of the file IN as the file OUT; its suffix says the format.

    Written are .csv and .npz (landmarks and angles; SI units, z up), .trc (landmarks; mm, y up)
    and, with the skeleton, .bvh (cm, y up) and, with --body, .npz.
    """
    from armsyn.errors import InputError
    from armsyn.motion.formats import write_body, write_motion

    reading = read(source, given)
    if body or out.suffix.lower() == ".bvh":
        if any(option is not None for option in (fill_gaps, resample, landmarks)):
            raise InputError(
                f"{out}: a whole skeleton is written as it is: leave out --fill-gaps, --resample"
                " and --landmarks, or write its joints' positions without --body"
            )
        if reading.body is None:
            raise InputError(f"{source}: no skeleton in it, only joint angles or landmarks")
        write_body(out, reading.body)
        motion = reading.body.as_motion()
        left_out = _without_markers(reading)
    else:
        motion = _changed(reading, fill_gaps, resample, landmarks)
        write_motion(out, motion)
        left_out = _left_out(reading, motion, out)
    _report(source, out, reading, motion, left_out, as_json)


def _changed(
    reading: Reading, fill_gaps: float | None, rate: float | None, names: str | None
) -> Motion:
    from armsyn.motion import gaps, resample

    motion = reading.motion
    if names is not None:
        motion = _kept(motion, [name.strip() for name in names.split(",")])
    if fill_gaps is not None:
        motion = gaps.fill_gaps(motion, fill_gaps)
    return motion if rate is None else resample.resample(motion, rate)


def _kept(motion: Motion, names: list[str]) -> Motion:
    import dataclasses

    from armsyn.errors import InputError

    for name in names:
        if name not in motion.landmark_names:
            there = ", ".join(motion.landmark_names) or "none"
            raise InputError(f"{motion.source}: no landmark '{name}'; there are {there}")
    columns = [motion.landmark_names.index(name) for name in names]
    assert motion.landmarks is not None  # noqa: S101 - it has names
    return dataclasses.replace(
        motion,
        landmark_names=tuple(names),
        landmarks=motion.landmarks[:, columns],
        filled=None if motion.filled is None else motion.filled[:, columns],
    )


def _without_markers(reading: Reading) -> list[str]:
    """Name the markers that a file has beside its skeleton."""
    assert reading.body is not None  # noqa: S101 - it has just been written
    names = reading.motion.landmark_names
    return [] if names == reading.body.skeleton.names else [f"{len(names)} markers"]


def _left_out(reading: Reading, motion: Motion, out: Path) -> list[str]:
    """Name what the format has no place for."""
    found = []
    if out.suffix.lower() == ".trc":
        if motion.angles is not None:
            found.append(f"{len(motion.joint_names)} joint angles")
        if motion.filled is not None:
            found.append("marks of what was filled in")
    if reading.body is not None:
        found.append("the skeleton's rotations (--body)")
    return found


def _report(
    source: str,
    out: Path,
    reading: Reading,
    motion: Motion,
    left_out: list[str],
    as_json: bool,
) -> None:
    from armsyn.motion.gaps import find_gaps

    filled = 0 if motion.filled is None else int(motion.filled.sum())
    document = {
        **{"in": source, "out": str(out), "facts": reading.facts},
        **{"frames": motion.frames, "rate_hz": motion.rate, "joints": len(motion.joint_names)},
        **{"landmarks": len(motion.landmark_names), "filled_positions": filled},
        **{"gaps": len(find_gaps(motion)), "left_out": left_out},
    }
    if as_json:
        import json

        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    for key, value in reading.facts.items():
        click.echo(f"{source}: {key}: {value}")
    click.echo(
        f"{out}: {motion.frames} frames at {motion.rate:.6g} Hz, {document['joints']} joints,"
        f" {document['landmarks']} landmarks; {filled} positions filled in,"
        f" {document['gaps']} gaps"
    )
    for part in left_out:
        click.echo(f"{out}: left out: {part}")
