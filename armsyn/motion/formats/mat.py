"""MATLAB files of HuG-MP as motions: one take a repetition, task and motion, such as ``2.4.5``."""

from __future__ import annotations

from pathlib import Path

from armsyn.errors import FormatError
from armsyn.motion.formats.files import check_size
from armsyn.motion.formats.hug_mp import LARGEST_FILE, Key, read_hug_mp
from armsyn.motion.formats.npz_bodies import chosen
from armsyn.motion.formats.options import Reading, ReadOptions
from armsyn.motion.motion import Motion


def takes(path: Path) -> tuple[str, ...]:
    """Return the names of the motions in a file.

    Raises
    ------
    FormatError
        When it cannot be read.
    """
    return tuple(_motions(path))


def read(path: Path, options: ReadOptions) -> Reading:
    """Read one motion.

    Parameters
    ----------
    path : Path
    options : ReadOptions
        `take` is heard.

    Returns
    -------
    Reading
        Joint angles and landmarks; see `armsyn.motion.formats.hug_mp` for the segments' lengths.

    Raises
    ------
    FormatError
        When no take is named, or the file is not such a file.
    """
    motions = _motions(path)
    take = chosen(options.take, tuple(motions), path)
    return Reading(motions[take], {"take": take, "unit": "deg", "up": "z", "rate": "100 Hz"})


def _motions(path: Path) -> dict[str, Motion]:
    check_size(path, LARGEST_FILE)
    try:
        return {_name(key): motion for key, motion in read_hug_mp(path).items()}
    except OSError as error:
        raise FormatError(f"{path}: cannot read it: {error.strerror}") from error


def _name(key: Key) -> str:
    return ".".join(map(str, key))
