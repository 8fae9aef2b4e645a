"""Clips as `armsyn edit` names them: captured movements, and files of bodies or of arms."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.editing import Clip
    from armsyn.motion import Motion

RATE = 200.0
"""Hz of arms' motions, as `armsyn stream` takes them."""
_STILL = 0.005
"""Of the greatest speed of any joint: an arm that is slower before and after rests."""


def load_examples(texts: tuple[str, ...], arm: ArmDescription | None) -> list[Clip]:
    """Load motions to learn from; see `load_clip`, but selections may name several."""
    from armsyn.editing import is_clip_selection, load_clips

    found: list[Clip] = []
    for text in texts:
        if arm is None and is_clip_selection(text) and not Path(text).exists():
            found += load_clips(text)
        else:
            found.append(load_clip(text, arm))
    return found


def load_clip(text: str, arm: ArmDescription | None) -> Clip:
    """Load one motion.

    Parameters
    ----------
    text : str
        A captured movement such as ``garza:ForwardHigh``, or a file.
    arm : ArmDescription or None
        Whose motion it is; None for a body's.

    Returns
    -------
    BodyMotion or Motion
        An arm's from where it starts to where it ends to move.

    Raises
    ------
    CaptureError, FormatError, InputError
        Nothing there, several, or of another kind.
    """
    from armsyn.editing import is_clip_selection, load_clips
    from armsyn.errors import CaptureError, FormatError, InputError
    from armsyn.motion.formats import FORMATS, read_body, split_take

    if not Path(text).exists() and is_clip_selection(text):
        if arm is not None:
            raise InputError(f"{text}: captured bodies are not motions of {arm.name}")
        found = load_clips(text)
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
