"""Motions as commands name them: files, and captured reaches."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armsyn.motion import Motion

_ANY_ORDER = (".amc", ".bvh", ".c3d", ".trc")
"""Files of markers and skeletons: the hand is not the last there, unless by chance."""


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
        motion = read_motion(text)
        _say_hand(text, motion)
        return [(text, motion)]
    if not is_selection(text):
        known = ", ".join(FORMATS)
        raise FormatError(
            f"{text}: neither a motion file ({known}) nor a captured reach: name one, such as"
            " reach.npz or garza:ForwardHigh"
        )
    return [(capture.name, capture.motion) for capture in load_captures(text)]


def _say_hand(text: str, motion: Motion) -> None:
    """Say which landmark is the hand, where a format keeps them in any order."""
    import click

    from armsyn.motion.formats import split_take
    from armsyn.motion.points import HAND

    names = motion.landmark_names
    any_order = split_take(text)[0].suffix.lower() in _ANY_ORDER
    if any_order and names and names[-1] != HAND:
        click.echo(
            f"{text}: its last landmark, '{names[-1]}', is taken for the {HAND}, unless a map of"
            " names says otherwise",
            err=True,
        )


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
