"""The posture in which a reach is to end: the hand at its target, and turned as was asked for."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import RefusedMotionError, UnreachableError
from armsyn.planning.checking import TOLERANCE_M, reached_from, too_far, where
from armsyn.planning.posing import HandTask, settled

FloatArray = NDArray[np.float64]

_ATTEMPTS = 12
"""Random postures from which an orientation is looked for after the likely ones."""

_FREE = 0.02
"""rad/rad (or m/rad, as a share of the reach): what moves by less does not."""


def end_posture(
    arm: ArmDescription, task: HandTask, start: FloatArray, predicted: FloatArray
) -> FloatArray:
    """Return a posture within the limits in which the hand does its task, near the predicted one.

    Parameters
    ----------
    arm : ArmDescription
    task : HandTask
    start, predicted : array, shape (n,)
        Where the reach starts, and where it was predicted to end, rad or m.

    Returns
    -------
    array, shape (n,)

    Raises
    ------
    UnreachableError
        The hand stays away from its target, or cannot be turned as asked there.
    """
    chain, best, nearest = arm.chain, predicted, np.inf
    for near in _places(arm, task, start, predicted):
        found = settled(chain, task, near)
        distance, angle = task.errors(chain, found)
        if fulfilled(task, distance, angle):
            return found
        # what of the orientation is left once the position comes first
        found = settled(chain, HandTask(task.goal), found)
        distance, angle = task.errors(chain, found)
        if fulfilled(task, distance, angle):
            return found
        if distance <= TOLERANCE_M and angle < nearest:
            best, nearest = found, angle
    anywhere = reached_from(arm, start, task.goal)
    if not anywhere.success:
        raise too_far(arm, task.goal, anywhere)
    if task.orientation is None:
        return anywhere.posture
    raise _wrongly_turned(arm, task, best, nearest)


def fulfilled(task: HandTask, distance: float, angle: float) -> bool:
    """Whether a hand is as near to its task as is asked: m, rad."""
    turned = task.orientation is None or angle <= task.orientation.tolerance
    return distance <= TOLERANCE_M and turned


def freedom(arm: ArmDescription, task: HandTask, posture: FloatArray) -> int:
    """How many angles of a wanted orientation an arm can change while its hand stays, 0 to 3.

    Parameters
    ----------
    arm : ArmDescription
    task : HandTask
        With an orientation.
    posture : array, shape (n,)
        rad or m; limits do not count.
    """
    _, jacobian = task.left(arm.chain, posture)
    _, sizes, rows = np.linalg.svd(jacobian[:3])
    still = rows[int(np.count_nonzero(sizes > _FREE * arm.chain.reach)) :]
    if not still.shape[0]:
        return 0
    turns = np.linalg.svd(jacobian[3:] @ still.T, compute_uv=False)
    return int(np.count_nonzero(turns > _FREE))


def _places(
    arm: ArmDescription, task: HandTask, start: FloatArray, predicted: FloatArray
) -> Iterator[FloatArray]:
    chain = arm.chain
    yield from (predicted, start, arm.rest, 0.5 * (chain.lower + chain.upper))
    if task.orientation is not None:
        rng = np.random.default_rng(0)
        yield from rng.uniform(chain.lower, chain.upper, (_ATTEMPTS, chain.dof))


def _wrongly_turned(
    arm: ArmDescription, task: HandTask, best: FloatArray, angle: float
) -> RefusedMotionError:
    assert task.orientation is not None  # noqa: S101 - asked by who has one
    wanted, left = task.orientation.angles, freedom(arm, task, best)
    miss = "is turned as asked for in no posture that was found"
    if np.isfinite(angle):
        miss = f"comes no nearer than {np.degrees(angle):.1f} degrees to what is asked for"
    why = "its joints' ranges end before"
    if left < wanted:
        count = {0: "none", 1: "one", 2: "two"}[left]
        why = f"its {arm.chain.dof} joints leave {count} of {wanted} angles of the hand free there"
    return UnreachableError(
        f"at {where(task.goal)} the hand of {arm.name} {miss}: {why}; ask for another, or allow"
        " more by --orientation-tolerance",
        task.errors(arm.chain, best)[0],
    )
