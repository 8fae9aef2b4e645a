"""`armsyn motion convert`: one motion file written as another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from armsyn.cli.motion_options import read, reading_options

if TYPE_CHECKING:
    from armsyn.motion import Motion
    from armsyn.motion.formats import Episode, Reading


@click.command()
@click.argument("sources", metavar="IN...", nargs=-1, required=True)
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
@click.option(
    "--arm",
    metavar="NAME",
    help="Whose joints they are, for .bvh and .lerobot; a recording in .npz and generated reaches"
    " know.",
)
@click.option("--task", metavar="TEXT", help="What the motions do, for .mcap, .parquet, .lerobot.")
@click.option(
    "--units",
    type=click.Choice(["degrees", "radians", "normalised"]),
    help="Of .lerobot: degrees by default; normalised is -100 to 100 of the arm's joint ranges.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON document on standard output.")
def convert(
    sources: tuple[str, ...],
    out: Path,
    fill_gaps: float | None,
    resample: float | None,
    landmarks: str | None,
    body: bool,
    arm: str | None,
    task: str | None,
    units: str | None,
    as_json: bool,
    **given: Any,
) -> None:
    """Write the motion of the file IN as the file OUT; its suffix says the format.

    Written are .csv and .npz (landmarks and angles; SI units, z up), .trc (landmarks; mm, y up)
    and, with the skeleton, .bvh (cm, y up) and, with --body, .npz.

    For other programs, an arm's motions, many IN one OUT: .mcap (a ROS 2 bag: JointTrajectory and
    JointState), .lerobot (a folder: LeRobotDataset v3.0), .parquet (one table). Of a recording
    they have what was commanded and what was measured, the others only the measured motion.
    What OUT has no place for is said.

    A file that is there already is replaced, but none of IN; a folder is refused.
    """
    from armsyn.cli.motion_export import export
    from armsyn.errors import InputError
    from armsyn.motion.formats import EXPORTS, write_motion

    _check_apart(sources, out)
    changes = (fill_gaps, resample, landmarks)
    if out.suffix.lower() in EXPORTS and not body:
        from armsyn.cli.motion_episodes import episodes_in

        def episodes(some: Iterable[str]) -> Iterator[Episode]:
            return episodes_in(some, given, task or "", lambda m: _changed(m, *changes))

        export(out, sources, episodes, arm, units, as_json)
        return
    if len(sources) > 1:
        raise InputError(
            f"{out}: holds one motion: name one file to write, or one of {', '.join(EXPORTS)}"
        )
    if task is not None or units is not None:
        raise InputError(f"{out}: --task and --units are for {', '.join(EXPORTS)}")
    of_body = body or out.suffix.lower() == ".bvh"
    if arm is not None and not of_body:
        raise InputError(f"{out}: --arm is for .bvh and .lerobot: leave it out")
    reading = read(sources[0], given)
    left_out = _beside(sources[0], reading, out)
    if of_body:
        reading = _with_body(sources[0], out, reading, arm, changes)
        motion = _write_body(out, reading)
        left_out += _without_markers(reading)
    else:
        motion = _changed(reading.motion, *changes)
        write_motion(out, motion)
        left_out += _left_out(reading, motion, out)
    _report(sources[0], out, reading, motion, left_out, as_json)


def _check_apart(sources: tuple[str, ...], out: Path) -> None:
    """Refuse to write over what is read: it may hold more than OUT can, such as commands."""
    from armsyn.errors import InputError
    from armsyn.motion.formats import split_take

    for source in sources:
        try:
            same = out.samefile(split_take(source)[0])
        except (OSError, ValueError):
            continue  # one of them is not there
        if same:
            raise InputError(f"{out}: is a file to read: name another one to write")


def _with_body(
    source: str, out: Path, reading: Reading, arm: str | None, changes: tuple[Any, ...]
) -> Reading:
    """Return a file's reading with its skeleton, or with that of the arm whose angles it has."""
    import dataclasses

    from armsyn.cli.motion_export import chain_of
    from armsyn.errors import InputError
    from armsyn.motion.formats import arm_bvh

    if reading.body is None:
        told = {} if reading.episode is None else reading.episode.facts
        chain = chain_of(source, reading.motion, arm or told.get("arm"))
        skeleton = arm_bvh.body_of(_changed(reading.motion, *changes), chain)
        return dataclasses.replace(reading, body=skeleton, motion=skeleton.as_motion())
    if arm is not None:
        raise InputError(f"{source}: has a skeleton of its own: leave out --arm")
    if any(change is not None for change in changes):
        raise InputError(
            f"{out}: a whole skeleton is written as it is: leave out --fill-gaps, --resample"
            " and --landmarks, or write its joints' positions without --body"
        )
    return reading


def _write_body(out: Path, reading: Reading) -> Motion:
    from armsyn.motion.formats import write_body

    assert reading.body is not None  # noqa: S101 - it has been looked for
    write_body(out, reading.body)
    return reading.body.as_motion()


def _changed(
    motion: Motion, fill_gaps: float | None, rate: float | None, names: str | None
) -> Motion:
    from armsyn.motion import gaps, resample

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


def _beside(source: str, reading: Reading, out: Path) -> list[str]:
    """Name what a recording or an episode holds beside its motion."""
    from armsyn.cli.motion_beside import beside, beside_in, in_words, not_held
    from armsyn.motion.formats import split_take

    path, _ = split_take(source)
    found = beside(path) | beside_in(reading.episode)
    return in_words(not_held(found, path, out.suffix.lower()))


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
