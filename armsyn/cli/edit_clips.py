"""Clips as `armsyn edit` names them: captured movements, and files of bodies or of arms."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.editing import Clip
    from armsyn.motion import Motion

_STILL = 0.005
"""Of the greatest speed of any joint: an arm that is slower before and after rests."""


def load_examples(texts: tuple[str, ...], arm: ArmDescription | None) -> list[Clip]:
    """Load motions to learn from; see `load_clip`, but selections may name several."""
    from armsyn.cli.edit_captures import captured_on
    from armsyn.editing import load_clips

    found: list[Clip] = []
    for text in texts:
        if not _is_captured(text, arm):
            found.append(load_clip(text, arm))
        elif arm is None:
            found += load_clips(text)
        else:
            found += captured_on(text, arm)
    return found


def _is_captured(text: str, arm: ArmDescription | None) -> bool:
    """Whether a text names captured movements, as far as can be said before they are loaded."""
    from armsyn.editing import is_clip_selection

    captured_reaches = arm is not None and text.startswith("hug_mp:")
    return (is_clip_selection(text) or captured_reaches) and not Path(text).exists()


def load_clip(text: str, arm: ArmDescription | None) -> Clip:
    """Load one motion.

    Parameters
    ----------
    text : str
        A captured movement such as ``garza:ForwardHigh``, or a file.
    arm : ArmDescription or None
        Whose motion it is; None for a body's. Captured reaches are put on it.

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
    from armsyn.motion.formats import FORMATS, read_body, split_take

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
    body = read_body(text)
    return body if body.source else dataclasses.replace(body, source=text)


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
