"""Which captures an experiment takes, and the arm that they are put on."""

from __future__ import annotations

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
    """

    key: str
    title: str
    arm: str
    captures: str
    rate_hz: float
    at_most: int | None = None


HUG_MP = Selection("hug_mp", "HuG-MP S01, 4 joints", "hug_mp4", "hug_mp:S01", 100.0)
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
