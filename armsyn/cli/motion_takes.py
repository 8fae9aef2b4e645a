"""All the motions that a file or a set of captures holds, for commands that take several."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from pathlib import Path

    from armsyn.motion import Motion
    from armsyn.motion.body import BodyMotion
    from armsyn.motion.formats import Episode


class Take(NamedTuple):
    """One motion by the name that finds it."""

    name: str
    motion: Motion
    body: BodyMotion | None
    """For formats with a skeleton."""
    hand_last: bool
    """Whether its last landmark is known to be the end effector."""
    cut: bool
    """Whether it is a captured reach, cut and on an arm's landmarks already."""
    facts: dict[str, str]
    """What its reader found or assumed: unit, rate, axis up."""
    episode: Episode | None = None
    """For formats with more than a motion: with what stands beside it."""


def all_takes(source: str, options: dict[str, Any]) -> Iterator[Take]:
    """Give the motions of a file (of all its takes, unless one is named) or a set, one by one.

    Parameters
    ----------
    source : str
        FILE, FILE#TAKE, or a selection of captures, such as garza:all.
    options : dict
        With the values of `armsyn.cli.motion_options.reading_options`.

    Yields
    ------
    Take
        One at least; none is kept, so that a file of many takes little memory.

    Raises
    ------
    FormatError, CaptureError, InputError
        When it cannot be read so.
    """
    from dataclasses import fields

    from armsyn.errors import InputError
    from armsyn.motion.captures import is_selection, load_captures
    from armsyn.motion.formats import ReadOptions, split_take

    given = {field.name: options[field.name] for field in fields(ReadOptions)}
    if is_selection(source) and not split_take(source)[0].exists():
        if any(value is not None for value in given.values()):
            raise InputError(f"{source}: captures need no options of files: leave them out")
        for capture in load_captures(source):
            yield Take(capture.name, capture.motion, None, hand_last=True, cut=True, facts={})
        return
    yield from _of_file(source, given)


def _of_file(source: str, given: dict[str, Any]) -> Iterator[Take]:
    from armsyn.cli.motion_options import read
    from armsyn.motion.formats import split_take, takes_in

    path, take = split_take(source)
    if path.suffix.lower() == ".mat" and path.is_file() and not (take or any(given.values())):
        yield from _of_hug_mp(path)
        return
    names: tuple[str | None, ...] = (take or given["take"],)
    if names == (None,):
        names = takes_in(path) or (None,)
    for name in names:
        reading = read(str(path), {**given, "take": name})
        markers = path.suffix.lower() in (".c3d", ".trc")
        yield Take(
            source if len(names) == 1 else f"{path}#{name}",
            reading.motion,
            reading.body,
            hand_last=reading.body is None and not markers,
            cut=False,
            facts=reading.facts,
            episode=reading.episode,
        )


def _of_hug_mp(path: Path) -> Iterator[Take]:
    """All at once: reading one of its hundreds takes as long as reading them all."""
    from armsyn.motion.formats.hug_mp import read_hug_mp

    for key, motion in read_hug_mp(path).items():
        name = ".".join(str(number) for number in key)
        yield Take(f"{path}#{name}", motion, None, hand_last=True, cut=False, facts={})
