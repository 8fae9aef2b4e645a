"""Motions as commands name them: files, and captured reaches."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armsyn.motion import Motion


def load_motions(text: str) -> list[tuple[str, Motion]]:
    """Return the motions that a file or a selection of captures names.

    Parameters
    ----------
    text : str
        A path with a known suffix (FILE#TAKE for one of several), or a selection such as
        `garza:all`.

    Returns
    -------
    list of (str, Motion)
        Each by the name that finds it; one for a file.

    Raises
    ------
    FormatError
        When the file is damaged, missing or of no known format.
    CaptureError
        When the selection names no capture.
    """
    from armsyn.errors import FormatError
    from armsyn.motion.captures import is_selection, load_captures
    from armsyn.motion.formats import FORMATS, read_motion, split_take

    if split_take(text)[0].suffix.lower() in FORMATS:
        return [(text, read_motion(text))]
    if not is_selection(text):
        known = ", ".join(FORMATS)
        raise FormatError(
            f"{text}: neither a motion file ({known}) nor a captured reach: name one, such as"
            " reach.npz or garza:ForwardHigh"
        )
    return [(capture.name, capture.motion) for capture in load_captures(text)]


def load_motion(text: str) -> tuple[str, Motion]:
    """Return the one motion that a file or a selection of captures names.

    Parameters
    ----------
    text : str
        As for `load_motions`.

    Returns
    -------
    (str, Motion)
        The name that finds it, and the motion as read.

    Raises
    ------
    FormatError
        When the file is damaged, missing or of no known format.
    CaptureError
        When the selection names no capture, or several.
    """
    from armsyn.errors import CaptureError

    found = load_motions(text)
    if len(found) > 1:
        raise CaptureError(
            f"{text!r} selects {len(found)} captures, one is needed: {found[0][0]}, ..."
        )
    return found[0]
