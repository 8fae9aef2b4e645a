"""Whether an arm may follow an edited motion, and how much slower it would have to be."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from armsyn.arm import ArmDescription
    from armsyn.editing import Clip, EditResult
    from armsyn.motion import Motion

Again = Callable[[float], "EditResult"]
_TRIES = 4


def check_safe(result: EditResult, arm: ArmDescription, slower: float, again: Again) -> list[str]:
    """Refuse what the arm must not follow; say how it was before.

    Parameters
    ----------
    result : EditResult
        Of the arm's clip, which takes `slower` times its time.
    arm : ArmDescription
    slower : float
    again : callable
        Edits the clip that many times slower.

    Returns
    -------
    list of str
        A note for people.

    Raises
    ------
    RefusedMotionError
        A limit's says how much slower the same edit passes, where that was found.
    """
    from armsyn.errors import LimitError, RefusedMotionError
    from armsyn.safety import check_trajectory

    edited = _motion(result.clip)
    try:
        check_trajectory(dataclasses.replace(edited, source="edited"), arm)
    except LimitError as error:
        found = _slow_enough(edited, arm, slower, again)
        if found is not None:
            error.add(f"with --slower {found:g} this edit passes all checks")
        raise
    try:
        check_trajectory(_motion(result.original), arm)
    except RefusedMotionError as error:
        return [f"Safe for {arm.name}; the original was not: {error}."]
    return [f"Safe for {arm.name}: ranges, speeds, accelerations, jerk, collisions."]


def _slow_enough(edited: Motion, arm: ArmDescription, slower: float, again: Again) -> float | None:
    """Find by trying how much slower the same edit passes; None where that does not help."""
    from armsyn.errors import RefusedMotionError
    from armsyn.planning.timing import Rates
    from armsyn.safety import check_trajectory

    assert edited.angles is not None  # noqa: S101 - of an arm
    excess = float(Rates.of(arm).excess(edited.angles, edited.rate).max())
    if not excess > 1.0:
        return None
    for attempt in range(_TRIES):
        factor = math.ceil(10.0 * slower * excess * 1.1**attempt) / 10.0
        try:
            check_trajectory(_motion(again(factor).clip), arm)
        except RefusedMotionError:
            continue
        return factor
    return None


def _motion(clip: Clip) -> Motion:
    from armsyn.motion import Motion

    assert isinstance(clip, Motion)  # noqa: S101 - of an arm
    return clip
