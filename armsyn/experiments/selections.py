"""Which captures an experiment takes, and the arm that they are put on."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from armsyn.arm import ArmDescription, load_arm
from armsyn.motion.captures import load_captures
from armsyn.synergy.training import Training, prepare

_GARZA_14 = (
    *("BackHigh", "BackMediumNear", "ForwardHigh", "ForwardMediumFar", "ForwardMediumMid"),
    *("Left30MediumMid", "Left30MediumNear", "Left60MediumMid", "Left60MediumNear"),
    *("Right120High", "Right120MediumFar", "Right120MediumMid", "Right30High", "Right30Low"),
)


@dataclass(frozen=True)
class Selection:
    """Captured reaches for one experiment.

    Parameters
    ----------
    key : str
        Short, for file names and tables: the set of captures.
    title : str
        For people.
    arm : str
        Name of the arm's description.
    captures : str
        As `armsyn.motion.captures.load_captures` takes it.
    rate_hz : float
        Frame rate of roll-outs.
    at_most : int or None
        Only so many, the first in the table's order.
    everything : str or None
        Every reach of the same person, where targets were reached several times.
    """

    key: str
    title: str
    arm: str
    captures: str
    rate_hz: float
    at_most: int | None = None
    everything: str | None = None


HUG_MP = Selection(
    "hug_mp",
    "HuG-MP S01, 4 joints",
    "hug_mp4",
    "hug_mp:S01",
    100.0,
    everything="hug_mp:S01:all",
)
"""The first two usable repetitions of each of the 7 targets from rest: the paper's 14 motions."""
GARZA = Selection(
    "garza",
    "garza, chest's frame, 7 joints",
    "human7",
    ",".join(f"garza:{place}" for place in _GARZA_14),
    120.0,
)
"""In the table's order 14 reaches during which the pelvis moves by less than 10 cm; the same as in
the earlier study that figures are set beside."""
BOTH = (HUG_MP, GARZA)
GARZA_ALL = dataclasses.replace(GARZA, title="garza", captures="garza")
"""All 35 reaches from rest."""
HUG_MP_PERSONS = tuple(
    Selection(
        subject,
        f"HuG-MP {subject}",
        "hug_mp4",
        f"hug_mp:{subject}",
        100.0,
        everything=f"hug_mp:{subject}:all",
    )
    for subject in ("S01", "S02", "S03", "S04")
)
"""The same 14 of each of the four persons."""


@dataclass(frozen=True)
class Prepared:
    """A selection on its arm.

    Parameters
    ----------
    selection : Selection
    arm : ArmDescription
    trainings : list of Training
    """

    selection: Selection
    arm: ArmDescription
    trainings: list[Training]

    @property
    def names(self) -> list[str]:
        """Of the captures."""
        return [training.capture.name for training in self.trainings]


def load(selection: Selection) -> Prepared:
    """Load the captures of a selection and put them on its arm.

    Parameters
    ----------
    selection : Selection

    Returns
    -------
    Prepared
        Every capture, in order.

    Raises
    ------
    CaptureError
        Captures that are not there, or one that the arm cannot follow: an experiment leaves none
        out in silence.
    DescriptionError, FormatError
        A damaged description or capture.
    """
    arm = load_arm(selection.arm, calibrated=False)
    captures = load_captures(selection.captures)[: selection.at_most]
    return Prepared(
        selection, arm, [prepare(arm, capture, selection.rate_hz) for capture in captures]
    )


def more_repeats(prepared: Prepared, at_most: int | None) -> Prepared:
    """Add the person's other reaches to the same targets.

    Parameters
    ----------
    prepared : Prepared
    at_most : int or None
        Of each target, those that are there already counted first.

    Returns
    -------
    Prepared
        The same where targets were reached once.

    Raises
    ------
    CaptureError
        As `load`.
    """
    selection = prepared.selection
    if selection.everything is None:
        return prepared
    places = [name.rpartition(":")[2] for name in prepared.names]
    added = []
    for capture in load_captures(selection.everything):
        place = capture.name.rpartition(":")[2]
        is_new = capture.name not in prepared.names and place in places
        if is_new and (at_most is None or places.count(place) < at_most):
            places.append(place)
            added.append(prepare(prepared.arm, capture, selection.rate_hz))
    return dataclasses.replace(prepared, trainings=[*prepared.trainings, *added])
