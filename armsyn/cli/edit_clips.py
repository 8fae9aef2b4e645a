"""Clips as `armsyn edit` names them: captured movements, and files of bodies or of arms."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.editing import Clip, Figure
    from armsyn.motion import Motion
    from armsyn.motion.body import BodyMotion

_STILL = 0.005
"""Of the greatest speed of any joint: an arm that is slower before and after rests."""


_TALL = (0.8, 2.6)
"""m; people are between, whatever they do."""


def load_examples(
    texts: tuple[str, ...], arm: ArmDescription | None, unit: str | None = None
) -> list[Clip]:
    """Load motions to learn from; see `load_clip`, but selections may name several, and FILE#*."""
    from armsyn.cli.edit_captures import captured_on
    from armsyn.editing import load_clips

    found: list[Clip] = []
    for text in _takes_named(texts):
        if not _is_captured(text, arm):
            found.append(load_clip(text, arm, unit))
        elif arm is None:
            found += load_clips(text)
        else:
            found += captured_on(text, arm)
    return found


def _takes_named(texts: tuple[str, ...]) -> list[str]:
    """Name each motion of FILE#*."""
    from armsyn.errors import InputError
    from armsyn.motion.formats import FORMATS, takes_in

    named = []
    for text in texts:
        file = text.removesuffix("#*")
        is_file = Path(file).is_file() and Path(file).suffix.lower() in FORMATS
        takes = takes_in(file) if is_file else ()
        if len(takes) > 1 and file == text:
            raise InputError(
                f"{file}: holds {len(takes)} motions: name one, {file}#{takes[0]}, all, {file}#*,"
                " or a set of whole movements cut from captures, such as garza"
            )
        named += [text] if file == text else [f"{file}#{take}" for take in takes]
    return named


def _is_captured(text: str, arm: ArmDescription | None) -> bool:
    """Whether a text names captured movements, as far as can be said before they are loaded."""
    from armsyn.editing import is_clip_selection

    captured_reaches = arm is not None and text.startswith("hug_mp:")
    return (is_clip_selection(text) or captured_reaches) and not Path(text).exists()


def load_clip(text: str, arm: ArmDescription | None, unit: str | None = None) -> Clip:
    """Load one motion.

    Parameters
    ----------
    text : str
        A captured movement such as ``garza:ForwardHigh``, or a file.
    arm : ArmDescription or None
        Whose motion it is; None for a body's. Captured reaches are put on it.
    unit : str, optional
        Of a body's file's lengths, where it is not what the format's reader assumes.

    Returns
    -------
    BodyMotion or Motion
        An arm's from where it starts to where it ends to move.

    Raises
    ------
    CaptureError, FormatError, InputError
        Nothing there, several, or of another kind.
    """
    from armsyn.cli.edit_captures import captured_on
    from armsyn.editing import load_clips
    from armsyn.errors import CaptureError, FormatError
    from armsyn.motion.formats import FORMATS, split_take

    if _is_captured(text, arm):
        found = load_clips(text) if arm is None else captured_on(text, arm)
        if len(found) > 1:
            raise CaptureError(f"{text!r} selects {len(found)} motions, one is needed")
        return found[0]
    if split_take(text)[0].suffix.lower() not in FORMATS:
        raise FormatError(
            f"{text}: neither a motion file ({', '.join(FORMATS)}) nor a captured movement: name"
            " one, such as walk.bvh or garza:ForwardHigh"
        )
    if arm is not None:
        return _of_arm(text, arm)
    return _of_body(text, unit)


def _of_body(text: str, unit: str | None) -> BodyMotion:
    """Read a body's file; doubt on standard error what a person cannot be."""
    import click
    import numpy as np

    from armsyn.errors import InputError
    from armsyn.motion.formats import FORMATS, ReadOptions, read_file, split_take

    heard = unit is not None and "unit" in FORMATS[split_take(text)[0].suffix.lower()].options
    reading = read_file(text, ReadOptions(unit=unit) if heard else None)
    body = reading.body
    if body is None:
        raise InputError(
            f"{text}: has no skeleton, and a body's motion is needed: an arm's recordings are"
            " learned with --arm NAME, and edited by such a model"
        )
    tall = float(np.median(np.ptp(body.positions(), axis=1).max(axis=1)))
    if not _TALL[0] <= tall <= _TALL[1]:
        said = reading.facts.get("unit", "those of the file")
        click.echo(f"look: {text}: {tall:.2f} m tall by units {said}: is it? see --unit", err=True)
    return body if body.source else dataclasses.replace(body, source=text)


def on_skeleton_of(clip: Clip, figure: Figure) -> Clip:
    """Retarget a body's clip onto a model's skeleton, by its joints' names.

    Raises
    ------
    InputError
        Of an arm, whose motions are its own, or of other joints.
    """
    from armsyn.editing import SkeletonFigure, retargeted
    from armsyn.errors import InputError
    from armsyn.motion.body import BodyMotion

    if not isinstance(figure, SkeletonFigure) or not isinstance(clip, BodyMotion):
        raise InputError("--retarget is for bodies: an arm's motions are its own")
    return retargeted(clip, figure.skeleton)


def _of_arm(text: str, arm: ArmDescription) -> Motion:
    """Return what an arm's file has of movement, without the rest before and after."""
    import numpy as np

    from armsyn.cli.edit_captures import RATE
    from armsyn.driver.replay import load_replay
    from armsyn.errors import InputError

    motion = load_replay(Path(text), arm, RATE).motion
    assert motion.angles is not None  # noqa: S101 - of a replay
    speed = np.abs(np.diff(motion.angles, axis=0)).max(axis=1)
    if not speed.max() > 0.0:
        raise InputError(f"{text}: the arm does not move in it")
    moving = np.flatnonzero(speed > _STILL * speed.max())
    return dataclasses.replace(
        motion.between(int(moving[0]), min(motion.frames - 1, int(moving[-1]) + 1)), source=text
    )
