"""The golf case's sloped ground, and how club, hands and feet stand to each other and to it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from armsyn.editing import EditResult, Effector
from armsyn.experiments.edits import Method
from armsyn.experiments.tables import Column, Table, Value, centimetres
from armsyn.kinematics.pose_tree import PoseTree
from armsyn.motion import FloatArray

HIT = 94
"""Of 132 frames, from 0."""
CLUB = Effector("left_wrist", (0.855, 0.323, 0.029))
"""The club head's marker in the left wrist's frame, which follows the grip: median of swing 3."""
_SIDES = ("left", "right")
FEET = (Effector("left_ankle"), Effector("right_ankle"))
_COLUMNS = (
    Column("method", "method"),
    centimetres("clearance", "club over ground"),
    centimetres("hands_gap_change", "hands' gap"),
    centimetres("off_slope", "feet off slope"),
)
_NOTE = (
    "club over ground: the lowest that the club head's marker comes over the ground (flat before,"
    " sloped after; negative: it hits the ground); hands' gap: the most that the distance between"
    " the wrists changes, with the club in the left hand; feet off slope: the most that an ankle"
    " is from its height over the slope, of all frames."
)


class Slope(NamedTuple):
    """Ground that rises towards the target, x, about the line halfway between the feet.

    Attributes
    ----------
    middle : float
        x where it is as high as the flat ground was, m.
    angle : float
        rad.
    """

    middle: float
    angle: float

    def height(self, x: ArrayLike) -> FloatArray:
        """How much higher it is than the flat ground, m."""
        return np.asarray(math.tan(self.angle) * (np.asarray(x) - self.middle))


def slope_under(places: dict[Effector, FloatArray], angle: float) -> Slope:
    """Lay a slope halfway between the ankles at the hit."""
    return Slope(float(np.mean([places[foot][HIT, 0] for foot in FEET])), angle)


def points_of(tree: PoseTree, poses: FloatArray) -> dict[Effector, FloatArray]:
    """Return the paths of club head and ankles.

    Parameters
    ----------
    tree : PoseTree
    poses : array, shape (frames, n)

    Returns
    -------
    dict of Effector to array, shape (frames, 3)
        m.
    """
    effectors = (*FEET, CLUB)
    bodies = np.array([tree.body(effector.body) for effector in effectors])
    points = np.array([effector.point for effector in effectors])
    found = np.array([tree.points(pose, bodies, points).positions for pose in poses])
    return {effector: found[:, place] for place, effector in enumerate(effectors)}


class Standing(NamedTuple):
    """How an edited swing stands to the slope.

    Attributes
    ----------
    clearance : float
        The lowest that the club head's marker comes over the ground, m.
    gap : float
        The most that the distance between the wrists changes, m.
    off : float
        The most that an ankle is from its height over the slope, m.
    """

    clearance: float
    gap: float
    off: float


def standing(result: EditResult, angle: float) -> Standing:
    """Measure an edited swing on a slope, rad."""
    tree = result.figure.tree
    before, after = points_of(tree, result.before), points_of(tree, result.after)
    slope, wrists = slope_under(before, angle), [tree.body(f"{way}_wrist") for way in _SIDES]
    clearance = after[CLUB][:, 2] - slope.height(after[CLUB][:, 0])
    gaps = [
        np.linalg.norm(np.diff(positions[:, wrists], axis=1), axis=-1)
        for positions in result.positions
    ]
    off = [
        after[foot][:, 2] - before[foot][:, 2] - slope.height(before[foot][HIT, 0]) for foot in FEET
    ]
    gap = float(np.abs(gaps[1] - gaps[0]).max())
    return Standing(float(clearance.min()), gap, float(np.abs(off).max()))


def ground_table(title: str, methods: Sequence[Method], angle: float) -> Table:
    """Set the methods' swings on a slope, rad, beside the one before on flat ground."""
    first = methods[0].result
    flat = float(points_of(first.figure.tree, first.before)[CLUB][:, 2].min())
    rows: list[tuple[Value, ...]] = [("before the edit", flat, 0.0, None)]
    rows += [(method.name, *standing(method.result, angle)) for method in methods]
    return Table(title, _COLUMNS, rows, [_NOTE])
