"""`armsyn motion convert` to what holds an arm's motions for other programs."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.cli.long_work import StageBars
    from armsyn.kinematics import SerialChain
    from armsyn.motion import Motion
    from armsyn.motion.formats import Episode


class Written:
    """What has gone by on its way into a file.

    Parameters
    ----------
    bars : StageBars
        Shows how far it is, when there are several episodes or files.
    sources : tuple of str
        Files that they come from; each has one at least. How many more it has is not known before.
    """

    def __init__(self, bars: StageBars, sources: tuple[str, ...]) -> None:
        self._bars = bars
        self._sources = sources
        self._read = 0
        self.episodes = 0
        self.frames = 0
        self.kinds: dict[str, int] = {}
        self.joints: tuple[str, ...] = ()
        self.landmarks = 0
        self.filled = False
        self._beside: frozenset[str] = frozenset()
        self.assumed: dict[str, str] = {}
        self.made: dict[str, Any] = {}

    def each_source(self) -> Iterator[str]:
        """Give the sources, and count those whose episodes have all gone by."""
        for source in self._sources:
            yield source
            self._read += 1
            self._show()

    def _show(self) -> None:
        if max(self.episodes, len(self._sources)) > 1:
            said = f"{self.episodes} {'episode' if self.episodes == 1 else 'episodes'}"
            self._bars.update("files", self._read, len(self._sources), said)

    def counted(self, episodes: Iterable[Episode]) -> Iterator[Episode]:
        """Give episodes on, and count them."""
        from armsyn.cli.motion_beside import beside_in

        for episode in episodes:
            self.episodes += 1
            self.frames += episode.motion.frames
            self.kinds[episode.kind] = self.kinds.get(episode.kind, 0) + 1
            self.joints = episode.motion.joint_names
            self.landmarks = len(episode.motion.landmark_names)
            self.filled |= episode.motion.filled is not None
            self._beside |= beside_in(episode)
            self.assumed |= {k: v for k, v in episode.facts.items() if v.endswith("(assumed)")}
            yield episode
            self._show()

    def look_into(self, dataset: Path) -> None:
        """Take over what a LeRobotDataset has made of the frames."""
        info, origin = (
            json.loads((dataset / "meta" / f"{name}.json").read_text("utf-8"))
            for name in ("info", "armsyn")
        )
        self.frames = info["total_frames"]
        units = "/".join(sorted(set(origin["units"].values())))
        self.made = {"fps": info["fps"], "units": units}
        self.made["interpolated_episodes"] = origin["interpolated_episodes"]

    def left_out(self, suffix: str) -> list[str]:
        """Name what a format has no place for."""
        from armsyn.cli.motion_beside import beside, in_words, not_held
        from armsyn.motion.formats import split_take

        found = []
        if suffix != ".parquet" and self.landmarks:
            found.append(f"{self.landmarks} landmarks")
        if suffix == ".parquet" and self.filled:
            found.append("marks of what was filled in")
        paths = [split_take(source)[0] for source in self._sources]
        lost = [not_held(beside(path), path, suffix) for path in paths]
        lost.append(not_held(self._beside, Path(), suffix))
        return found + in_words(frozenset().union(*lost))


def export(
    out: Path,
    sources: tuple[str, ...],
    episodes_in: Callable[[Iterable[str]], Iterable[Episode]],
    arm: str | None,
    units: str | None,
    as_json: bool,
) -> None:
    """Write episodes as the file or folder OUT, and say what was written.

    Parameters
    ----------
    out : Path
        With a suffix of `armsyn.motion.formats.EXPORTS`.
    sources : tuple of str
        Where they come from.
    episodes_in : callable
        From sources to their episodes, one by one.
    arm : str or None
        Name of a described arm, whose joints they are.
    units : str or None
        Of a LeRobotDataset.
    as_json : bool

    Raises
    ------
    InputError
        When units are told for another format, or something cannot be read or written.
    """
    from armsyn.cli.long_work import StageBars
    from armsyn.errors import InputError
    from armsyn.motion.formats import write_episodes

    suffix = out.suffix.lower()
    if suffix != ".lerobot" and (units is not None or arm is not None):
        raise InputError(f"{out}: --units and --arm are for .lerobot: here are radians and metres")
    with StageBars() as bars:
        written = Written(bars, sources)
        given = written.counted(episodes_in(written.each_source()))
        options: dict[str, Any] = {}
        if suffix == ".lerobot" and (first := next(given, None)) is not None:
            given = itertools.chain([first], given)
            options = _of_lerobot(out, first, arm, units or "degrees")
        write_episodes(out, given, **options)
    if suffix == ".lerobot":
        written.look_into(out)
    _report(out, sources, written, as_json)


def _of_lerobot(out: Path, first: Episode, arm: str | None, units: str) -> dict[str, Any]:
    """Options of the writer for the arm that is told, or that a recording names."""
    from armsyn.errors import DescriptionError, InputError
    from armsyn.motion.formats.lerobot_format import options_of

    options: dict[str, Any] = {"units": units}
    name = arm or first.facts.get("arm")
    if name is None:
        return options
    try:
        known = described(name)
    except DescriptionError as error:
        if arm is not None or units == "normalised":
            raise
        click.echo(f"{out}: joints are taken to turn, not to slide: {error}", err=True)
        return options
    foreign = set(first.motion.joint_names) - set(known.joint_names)
    if foreign:
        raise InputError(
            f"{out}: {first.source or 'motion'} has joints that {name} has not:"
            f" {', '.join(sorted(foreign))}"
        )
    return options | options_of(known)


def described(arm: str) -> ArmDescription:
    """Return the description of an arm with its own zeros."""
    from armsyn.arm import load_arm

    return load_arm(arm, calibrated=False)


def chain_of(source: str, motion: Motion, arm: str | None) -> SerialChain:
    """Return the kinematics of the arm that a motion is of.

    Parameters
    ----------
    source : str
        Its file, for messages and, if it is a recording, the arm's name.
    motion : Motion
    arm : str or None
        The arm's name, if it was told.

    Raises
    ------
    InputError
        When it is not known which arm it is, or there is no such arm.
    """
    from armsyn.errors import InputError
    from armsyn.motion.formats import split_take
    from armsyn.motion.formats.archive import opened

    path, _ = split_take(source)
    if arm is None and path.suffix.lower() == ".npz":
        with opened(path) as archive:
            arm = archive.text("arm") if "arm" in archive.keys else None
    if arm is None:
        raise InputError(
            f"{source}: no skeleton in it, only"
            f" {'joint angles' if motion.angles is not None else 'landmarks'}: of an arm's angles,"
            " --arm NAME makes one"
        )
    return described(arm).chain


def _report(out: Path, sources: tuple[str, ...], written: Written, as_json: bool) -> None:
    left_out = written.left_out(out.suffix.lower())
    if as_json:
        document = {
            **{"in": list(sources), "out": str(out), "episodes": written.episodes},
            **{"frames": written.frames, "joints": len(written.joints)},
            **{"kinds": written.kinds, **written.made, "assumed": written.assumed},
            "left_out": left_out,
        }
        click.echo(json.dumps(document, indent=2, allow_nan=False))
        return
    kinds = ", ".join(f"{count} {kind}" for kind, count in written.kinds.items())
    click.echo(
        f"{out}: {written.episodes} {'episode' if written.episodes == 1 else 'episodes'} ({kinds}),"
        f" {written.frames} frames, {len(written.joints)} joints"
    )
    for what, value in written.assumed.items():
        click.echo(f"{out}: {what}: {value}")
    if written.made:
        fps, units, brought = written.made.values()
        click.echo(f"{out}: {fps} frames a second, {units}; {brought} interpolated to that rate")
    for part in left_out:
        click.echo(f"{out}: left out: {part}")
