"""Which captured reaches are repeats of each other: one person, one target."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from armsyn.motion import Motion
from armsyn.motion.captures import load_captures
from armsyn.motion.filtering import CUTOFF
from armsyn.motion.formats import hug_mp
from armsyn.motion.segmentation import CUT_FRACTION
from armsyn.scoring.floor import FEWEST_REPEATS, HumanFloor, Person, human_floor

HUG_MP = Person(hug_mp.CHAIN, (0, hug_mp.JOINT_NAMES.index("elbow_flexion"), -1))
"""Shoulder, elbow and hand of the exoskeleton's arm."""


class Repeats(NamedTuple):
    """One captured reach and the same person's other reaches to the same target."""

    captured: Motion
    others: list[Motion]
    person: Person


def repeats_of(name: str) -> Repeats | None:
    """Return a captured reach with its repeats.

    Parameters
    ----------
    name : str
        Of one captured reach, such as ``hug_mp:S01:2.4.5:R-9``.

    Returns
    -------
    Repeats or None
        None where the set has one reach a target (garza), or the name is none of a capture.

    Raises
    ------
    CaptureError, FormatError
        When the captures cannot be read.
    """
    if not name.startswith("hug_mp:"):
        return None
    (capture,) = load_captures(name)
    subject = capture.name.split(":")[1]
    everything = [(one.name, one.motion) for one in load_captures(f"hug_mp:{subject}:all")]
    return dict(repeats_in(everything)).get(capture.name)


def repeats_in(captures: Sequence[tuple[str, Motion]]) -> list[tuple[str, Repeats]]:
    """Return each reach with its repeats among captures of one or several persons.

    Parameters
    ----------
    captures : sequence of (str, Motion)
        By the names that `load_captures` gives them.

    Returns
    -------
    list of (str, Repeats)
        By name, in their order, without those that have fewer than two others.
    """
    groups: dict[tuple[str, str], list[tuple[str, Motion]]] = {}
    for name, motion in captures:
        set_name, *parts = name.split(":")
        if set_name == "hug_mp":
            groups.setdefault((parts[0], parts[-1]), []).append((name, motion))
    found = {
        name: Repeats(motion, [other for one, other in group if one != name], HUG_MP)
        for group in groups.values()
        for name, motion in group
        if len(group) > FEWEST_REPEATS
    }
    return [(name, found[name]) for name, _ in captures if name in found]


class MeanFloor(NamedTuple):
    """The human floor over a set of captures, metres."""

    floor: float
    """Mean of the reaches' floors, onset to offset: what scores are set over."""
    repeat_distance: float
    floor_as_cut: float
    """The same on the segments as they were cut, as published."""
    repeat_distance_as_cut: float
    reaches: int


def mean_floor(
    captures: Sequence[tuple[str, Motion]],
    cutoff: float | None = CUTOFF,
    fraction: float = CUT_FRACTION,
    on_progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> MeanFloor | None:
    """Return the mean human floor of captured reaches.

    Parameters
    ----------
    captures : sequence of (str, Motion)
        By the names that `load_captures` gives them.
    cutoff, fraction : float
        Of the held distance; see `armsyn.scoring.pairing.trim`.
    on_progress : callable
        Given how many reaches are done, and of how many, after each.

    Returns
    -------
    MeanFloor or None
        None where no reach is repeated often enough.

    Raises
    ------
    CaptureError
        As `human_floor`.
    """
    groups = repeats_in(captures)
    trimmed, as_cut = [], []
    for done, (_, repeats) in enumerate(groups, 1):
        trimmed.append(human_floor(*repeats, cutoff=cutoff, fraction=fraction))
        as_cut.append(human_floor(*repeats, as_cut=True))
        on_progress(done, len(groups))
    if not groups:
        return None
    return MeanFloor(*_means(trimmed), *_means(as_cut), reaches=len(groups))


def _means(floors: list[HumanFloor]) -> tuple[float, float]:
    return (
        float(np.mean([floor.distance for floor in floors])),
        float(np.mean([floor.repeat_distance for floor in floors])),
    )
