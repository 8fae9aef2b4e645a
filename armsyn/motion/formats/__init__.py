"""Motion files: one module a format, one table by suffix.

Inside, everything is SI and z is up; what a file says otherwise is turned where it is read and
written. `ReadOptions` says what a file leaves open, `Reading.facts` what was found or assumed.
A file that holds several motions is read as ``FILE#TAKE``.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from armsyn.errors import FormatError
from armsyn.motion.body import BodyMotion
from armsyn.motion.formats import (
    amc,
    bvh,
    bvh_write,
    c3d_format,
    csv_format,
    csv_reaches,
    delimited,
    lerobot_format,
    mat,
    mcap_format,
    npz_bodies,
    npz_format,
    npz_reaches,
    parquet_format,
    parquet_read,
    trc,
)
from armsyn.motion.formats.archive import opened
from armsyn.motion.formats.episodes import Episode, Episodes
from armsyn.motion.formats.options import Reading, ReadOptions
from armsyn.motion.motion import Motion

__all__ = [
    "EXPORTS",
    "FORMATS",
    "Episode",
    "Format",
    "ReadOptions",
    "Reading",
    "read_body",
    "read_file",
    "read_motion",
    "split_take",
    "takes_in",
    "write_body",
    "write_episodes",
    "write_motion",
]


class Format(NamedTuple):
    """How files of one suffix are read and written.

    Attributes
    ----------
    name : str
        For people.
    read : callable
        From a path and options to a `Reading`.
    options : frozenset of str
        Names of the `ReadOptions` it hears.
    write, write_body : callable or None
        What it can hold: landmarks and angles, or a skeleton's motion.
    takes : callable or None
        Names of the motions in a file that may hold several.
    """

    name: str
    read: Callable[[Path, ReadOptions], Reading]
    options: frozenset[str] = frozenset()
    write: Callable[[Path, Motion], None] | None = None
    write_body: Callable[[Path, BodyMotion], None] | None = None
    takes: Callable[[Path], tuple[str, ...]] | None = None


def _takes_npz(path: Path) -> tuple[str, ...]:
    with opened(path) as archive:
        if npz_reaches.is_reaches(archive):
            return npz_reaches.takes(archive)
    return npz_bodies.takes(path)


def _read_npz(path: Path, options: ReadOptions) -> Reading:
    """Read a motion of our own, or one of the skeletons in an archive."""
    with opened(path) as archive:
        of_bodies = npz_bodies.is_body(archive.keys)
        of_reaches = not of_bodies and npz_reaches.is_reaches(archive)
    if of_reaches and not options.given() - {"take"}:
        return npz_reaches.read(path, options)
    if of_bodies:
        return npz_bodies.read(path, options)
    if options.given():
        raise FormatError(f"{path}: a motion of armsyn leaves nothing open: give no options")
    return Reading(npz_format.read(path), {})


_EDGE = frozenset({"rate", "up", "unit"})
_TABLE = _EDGE | {"columns", "joints"}
FORMATS: dict[str, Format] = {
    ".amc": Format("ASF/AMC", amc.read, _EDGE | {"skeleton"}),
    ".bvh": Format("BVH", bvh.read, _EDGE, write_body=bvh_write.write),
    ".c3d": Format("C3D", c3d_format.read, _EDGE),
    ".csv": Format(
        *("delimited text", delimited.read, _TABLE),
        write=csv_format.write,
        takes=csv_reaches.takes,
    ),
    ".mat": Format("MATLAB, of HuG-MP", mat.read, takes=mat.takes),
    ".npz": Format(
        *("numpy archive", _read_npz, frozenset({"up"})),
        write=npz_format.write,
        write_body=npz_bodies.write,
        takes=_takes_npz,
    ),
    ".parquet": Format(
        *("parquet table", parquet_read.read),
        write=parquet_format.write,
        takes=parquet_read.takes,
    ),
    ".trc": Format("TRC", trc.read, _EDGE, write=trc.write),
    ".tsv": Format("delimited text", delimited.read, _TABLE),
    ".txt": Format("delimited text", delimited.read, _TABLE),
}
"""By suffix, lower case."""

EXPORTS: dict[str, Callable[..., None]] = {
    ".lerobot": lerobot_format.write,
    ".mcap": mcap_format.write,
    ".parquet": parquet_format.write,
}
"""What writes many motions of an arm as the episodes of one file, or folder, by suffix."""


def read_file(path: Path | str, options: ReadOptions | None = None) -> Reading:
    """Read a file with all that was found out about it.

    Parameters
    ----------
    path : Path or str
        A file whose suffix is in `FORMATS`, or FILE#TAKE.
    options : ReadOptions, optional
        What the file does not say.

    Returns
    -------
    Reading

    Raises
    ------
    FormatError
        When the suffix is unknown, the format does not hear an option that is given, or the file
        is missing, unreadable, damaged or too large; one line with the file and the place in it.
    """
    file, take = split_take(path)
    options = options or ReadOptions()
    if take is not None:
        options = ReadOptions(**{**vars(options), "take": take})
    found = _format_of(file)
    heard = found.options | ({"take"} if found.takes else set())
    unheard = sorted(options.given() - heard)
    if unheard:
        raise FormatError(
            f"{file}: a file of this kind takes no option '{unheard[0]}'; it takes"
            f" {', '.join(sorted(heard)) or 'none'}"
        )
    return found.read(file, options)


def read_motion(path: Path | str, options: ReadOptions | None = None) -> Motion:
    """Read a motion or a recording; its suffix says the format.

    Parameters
    ----------
    path : Path or str
        A file whose suffix is in `FORMATS`, or FILE#TAKE.
    options : ReadOptions, optional
        What the file does not say.

    Returns
    -------
    Motion
        A recording's angles are the measured ones; a skeleton's landmarks are all its joints.

    Raises
    ------
    FormatError
        As `read_file`.
    """
    return read_file(path, options).motion


def read_body(path: Path | str, options: ReadOptions | None = None) -> BodyMotion:
    """Read the motion of a whole skeleton.

    Parameters
    ----------
    path : Path or str
        A file of a format with a skeleton, or FILE#TAKE.
    options : ReadOptions, optional
        What the file does not say.

    Returns
    -------
    BodyMotion

    Raises
    ------
    FormatError
        As `read_file`, and when the file has no skeleton.
    """
    body = read_file(path, options).body
    if body is None:
        raise FormatError(f"{path}: no skeleton in it, only joint angles or landmark positions")
    return body


def takes_in(path: Path | str) -> tuple[str, ...]:
    """Return the names of the motions in a file that holds several; none for any other.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    FormatError
        As `read_file`.
    """
    file, _ = split_take(path)
    takes = _format_of(file).takes
    return takes(file) if takes else ()


def split_take(path: Path | str) -> tuple[Path, str | None]:
    """Split FILE#TAKE; a file whose own name has a # is itself, when it exists.

    Of several #, the last one parts them, but for a file that is there by less of the text.
    """
    text = str(path)
    if "#" not in text or Path(text).exists():
        return Path(text), None
    file, _, take = text.partition("#")
    if not Path(file).is_file():
        file, _, take = text.rpartition("#")
    return Path(file), take


def write_motion(path: Path | str, motion: Motion) -> None:
    """Write a motion; the file appears whole or not at all.

    Parameters
    ----------
    path : Path or str
        A file of a suffix that is written; an existing one is replaced.
    motion : Motion
        Any.

    Raises
    ------
    FormatError
        When the suffix is unknown or not written, or the motion cannot be said in the format.
    InputError
        When the file cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    written = EXPORTS | {end: kind.write for end, kind in FORMATS.items() if kind.write}
    if suffix not in written:
        why = "no landmarks or angles are written as this"
        if suffix not in FORMATS:
            why = f"no motion format has the suffix '{path.suffix}'"
        bodies = sorted(end for end, kind in FORMATS.items() if kind.write_body and not kind.write)
        raise FormatError(
            f"{path}: {why}: use one of {', '.join(sorted(written))}, or, of a skeleton or an arm,"
            f" {', '.join(bodies)}"
        )
    written[suffix](path, motion)


def write_episodes(path: Path | str, episodes: Episodes, **options: Any) -> None:
    """Write motions of an arm as the episodes of one file; it appears whole or not at all.

    Parameters
    ----------
    path : Path or str
        Of a suffix in `EXPORTS`; ``.lerobot`` is a folder, which must not exist.
    episodes : Motion, Episode, or an iterable of them
        All of the same joints and landmarks. They are taken one by one and not kept.
    options
        Those of the format's own writer, such as ``units`` of
        `armsyn.motion.formats.lerobot_format.write`.

    Raises
    ------
    FormatError
        When the suffix is none of these, a package is missing, there is no motion, or one cannot be
        said in the format.
    InputError
        When it cannot be written.
    """
    try:
        write = EXPORTS[Path(path).suffix.lower()]
    except KeyError:
        raise FormatError(
            f"{path}: not a file of several motions: use one of {', '.join(EXPORTS)}, or .bvh for"
            " each alone"
        ) from None
    write(Path(path), episodes, **options)


def write_body(path: Path | str, body: BodyMotion) -> None:
    """Write a skeleton's motion; the file appears whole or not at all.

    Parameters
    ----------
    path : Path or str
        A file of a suffix that holds a skeleton; an existing one is replaced.
    body : BodyMotion

    Raises
    ------
    FormatError
        When the suffix is unknown, or no skeleton is written as it.
    InputError
        When the file cannot be written.
    """
    write = _format_of(Path(path)).write_body
    if write is None:
        known = ", ".join(suffix for suffix, kind in FORMATS.items() if kind.write_body)
        raise FormatError(f"{path}: no skeleton is written as this: use one of {known}")
    write(Path(path), body)


def _format_of(path: Path) -> Format:
    try:
        return FORMATS[path.suffix.lower()]
    except KeyError:
        known = ", ".join(FORMATS)
        if path.suffix.lower() in EXPORTS:
            raise FormatError(
                f"{path}: this is only written, not read: use one of {known}"
            ) from None
        raise FormatError(
            f"{path}: no motion format has the suffix '{path.suffix}': use one of {known}"
        ) from None
