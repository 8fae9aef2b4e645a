"""Which way a joint's positive direction goes, in words for who stands beside the arm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.kinematics.rotation import from_rpy

FloatArray = NDArray[np.float64]

_SHORTEST_LEVER = 0.03
"""m/rad that the hand must move by for its way to say anything."""

_SECOND = 0.5
"""Part of the main direction from which on a second one is named, too."""

_WAYS = (("forward", "backward"), ("to its left", "to its right"), ("up", "down"))
_VIEWS = (
    ("in front of it", "behind it"),
    ("its left", "its right"),
    ("above", "below"),
)


def positive_direction(arm: ArmDescription, joint: str) -> str:
    """How to move a joint from rest in its positive direction.

    Parameters
    ----------
    arm : ArmDescription
    joint : str
        A joint's name, or the gripper's.

    Returns
    -------
    str
        Such as ``the hand goes up and backward``; left and right are the arm's own, looking where
        it faces. Where the hand stays in place, the sense of turning, as in ``it turns
        counter-clockwise, seen from above``.
    """
    gripper = arm.gripper
    if gripper is not None and joint == gripper.name:
        return "it opens" if gripper.open > gripper.closed else "it closes"
    row = arm.joint_names.index(joint)
    lever = _facing(arm) @ arm.chain.jacobian(arm.rest)[:, row]
    if np.linalg.norm(lever) >= _SHORTEST_LEVER:
        return f"the hand goes {' and '.join(_main_ways(lever, _WAYS))}"
    axis = _facing(arm) @ arm.chain.jacobian(arm.rest, pose=True)[3:, row]
    view = _main_ways(axis, _VIEWS)[0]
    return f"it turns counter-clockwise, seen from {view}"


def _facing(arm: ArmDescription) -> FloatArray:
    """Rotation from the base's frame into one whose x is where the arm faces."""
    return from_rpy((0.0, 0.0, -arm.facing))


def _main_ways(vector: FloatArray, names: tuple[tuple[str, str], ...]) -> list[str]:
    largest = float(np.abs(vector).max())
    order = np.argsort(-np.abs(vector))
    return [
        names[row][0 if vector[row] > 0 else 1]
        for row in order.tolist()
        if abs(vector[row]) > _SECOND * largest
    ]
