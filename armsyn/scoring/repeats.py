"""Which captured reaches are repeats of each other: one person, one target."""

from __future__ import annotations

from typing import NamedTuple

from armsyn.motion import Motion
from armsyn.motion.captures import Capture, load_captures
from armsyn.motion.formats import hug_mp
from armsyn.scoring.floor import FEWEST_REPEATS, HumanFloor, Person, human_floor

HUG_MP = Person(hug_mp.CHAIN, (0, hug_mp.JOINT_NAMES.index("elbow_flexion"), -1))
"""Shoulder, elbow and hand of the exoskeleton's arm."""


class Repeats(NamedTuple):
    """One captured reach and the same person's other reaches to the same target."""

    captured: Motion
    others: list[Motion]
    person: Person

    def floor(self, *, as_cut: bool = False) -> HumanFloor:
        """Return the human floor of the reach; see `armsyn.scoring.floor.human_floor`."""
        return human_floor(self.captured, self.others, self.person, as_cut=as_cut)


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
    return dict(repeats_in(load_captures(f"hug_mp:{subject}:all"))).get(capture.name)


def repeats_in(captures: list[Capture]) -> list[tuple[str, Repeats]]:
    """Return each reach with its repeats among the captures of one or several persons.

    Parameters
    ----------
    captures : list of Capture
        As `load_captures` returns them.

    Returns
    -------
    list of (str, Repeats)
        By name, in their order, without those that have fewer than two others.
    """
    found = []
    for capture in captures:
        set_name, *parts = capture.name.split(":")
        if set_name != "hug_mp":
            continue
        person, target = parts[0], parts[-1]
        others = [
            other.motion
            for other in captures
            if other.name != capture.name
            and other.name.startswith(f"hug_mp:{person}:")
            and other.name.endswith(f":{target}")
        ]
        if len(others) >= FEWEST_REPEATS:
            found.append((capture.name, Repeats(capture.motion, others, HUG_MP)))
    return found
