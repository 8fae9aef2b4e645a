"""Which landmark of one motion is which of another, where their names do not say."""

from __future__ import annotations

import dataclasses

from armsyn.errors import InputError
from armsyn.motion import Motion

JointMap = tuple[tuple[str, str], ...]
"""(captured landmark, other's landmark) pairs, the hand last."""


def checked_joint_map(texts: tuple[str, ...]) -> JointMap:
    """Return the pairs of ``CAPTURED=OTHER`` texts.

    Parameters
    ----------
    texts : tuple of str

    Returns
    -------
    tuple of (str, str)

    Raises
    ------
    InputError
        When one is no such pair, or a landmark stands in two.
    """
    pairs = [tuple(text.split("=")) for text in texts]
    for text, pair in zip(texts, pairs, strict=True):
        if len(pair) != 2 or not all(pair):
            raise InputError(f"joint map {text!r}: say LANDMARK_OF_A=LANDMARK_OF_B")
    for side in (0, 1):
        names = [pair[side] for pair in pairs]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise InputError(f"joint map: landmark {twice} stands in it twice")
    return tuple((pair[0], pair[1]) for pair in pairs)


def mapped(motion: Motion, pairs: JointMap, *, other: bool) -> Motion:
    """Return the motion with a map's landmarks only, by the captured motion's names.

    Parameters
    ----------
    motion : Motion
        The captured one, or the other.
    pairs : tuple of (str, str)
        Empty for all as they are.
    other : bool
        Which of the two it is.

    Returns
    -------
    Motion

    Raises
    ------
    InputError
        When it has angles only, or lacks a landmark of the map.
    """
    if not pairs:
        return motion
    source = motion.source or "motion"
    if motion.landmarks is None:
        raise InputError(f"{source}: only joint angles: there is nothing for a joint map to choose")
    rows = []
    for pair in pairs:
        if pair[other] not in motion.landmark_names:
            known = ", ".join(motion.landmark_names)
            raise InputError(f"{source}: no landmark {pair[other]} to map; it has {known}")
        rows.append(motion.landmark_names.index(pair[other]))
    return dataclasses.replace(
        motion,
        landmark_names=tuple(captured for captured, _ in pairs),
        landmarks=motion.landmarks[:, rows],
    )
