"""Many predicted motions made ones that an arm may follow: `armsyn.planning.finishing`, of many.

Most motions may be followed as they are predicted; those are paced and judged together, and so are
those that are brought nearer to minimum jerk because their hands speed up more than once. What has
to be bent, or ended elsewhere, is finished one by one; a hand that is to be turned at the end is
brought there one by one, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import RefusedMotionError, UnreachableError
from armsyn.kinematics import SerialChain
from armsyn.planning.allowed import tried
from armsyn.planning.checking import TOLERANCE_M, reached_from, too_far, where
from armsyn.planning.evening import EVENINGS, evened, nearer
from armsyn.planning.finishing import brought_to_end, finished
from armsyn.planning.posing import HandOrientation, HandTask
from armsyn.planning.postures import tips

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

UNEVEN = "the hand would speed up more than once"


class Followed(NamedTuple):
    """What came of M motions.

    Attributes
    ----------
    paths : list of array, shape (frames, n), or None
        Of each reach; None of one that is refused.
    scales : array, shape (M,)
        kappa.
    evened : array, shape (M,)
        How much nearer to minimum jerk they are, 0 to 1; as of `armsyn.planning.allowed.Finished`.
    swivels : array, shape (M,)
        m by which the elbow ends elsewhere; 0 for the motion as predicted.
    changed : dict of int to str
        Why those were refused as predicted that are evened or end elsewhere.
    refused : dict of int to RefusedMotionError
        Without the frames that they came through, which would keep whole batches in memory.
    """

    paths: list[FloatArray | None]
    scales: FloatArray
    evened: FloatArray
    swivels: FloatArray
    changed: dict[int, str]
    refused: dict[int, RefusedMotionError]


def follow(
    arm: ArmDescription,
    angles: FloatArray,
    durations: FloatArray,
    targets: FloatArray,
    rate_hz: float,
    orientations: Sequence[HandOrientation] | None = None,
) -> Followed:
    """Make motions samples that an arm may follow, or refuse them, as `finished` does each.

    Parameters
    ----------
    arm : ArmDescription
    angles : array, shape (M, phases, n)
        At equal steps of phase, rad or m, finite; the first of each within the limits.
    durations : array, shape (M,)
        s.
    targets : array, shape (M, 3)
        Where the hands are to end, m.
    rate_hz : float
    orientations : sequence of M HandOrientation, optional
        How the hands are to be turned at the end.

    Returns
    -------
    Followed
    """
    count = len(angles)
    found = Followed([None] * count, np.ones(count), np.zeros(count), np.zeros(count), {}, {})
    if orientations is None:
        at_end = _ending_right(arm.chain, angles[:, -1], targets)
    else:
        angles, at_end = _turned(arm, angles, targets, orientations, found)
    left = _follow_evened(arm, angles, durations, rate_hz, at_end, found)
    for row in left.tolist():
        if row in found.refused:
            continue
        task = HandTask(targets[row], None if orientations is None else orientations[row])
        try:
            _finish(arm, angles[row], float(durations[row]), task, rate_hz, row, found)
        except RefusedMotionError as error:
            found.refused[row] = error.with_traceback(None)
    return found


def _turned(
    arm: ArmDescription,
    angles: FloatArray,
    targets: FloatArray,
    orientations: Sequence[HandOrientation],
    found: Followed,
) -> tuple[FloatArray, BoolArray]:
    """Bring motions to their ends, the hands turned as asked; say which are there."""
    ended, at_end = angles.copy(), np.zeros(len(angles), dtype=np.bool_)
    for row, (target, turned) in enumerate(zip(targets, orientations, strict=True)):
        task = HandTask(target, turned)
        try:
            if refused := _surely_too_far(arm, angles[row], task.goal):
                raise refused
            ended[row], at_end[row] = brought_to_end(arm, angles[row], task), True
        except RefusedMotionError as error:
            found.refused[row] = error.with_traceback(None)
    return ended, at_end


def _ending_right(chain: SerialChain, ends: FloatArray, targets: FloatArray) -> BoolArray:
    """Which motions end within the ranges and near enough to their targets."""
    inside = ((ends >= chain.lower) & (ends <= chain.upper)).all(axis=1)
    there = np.linalg.norm(tips(chain, ends) - targets, axis=1) <= TOLERANCE_M
    return np.asarray(inside & there)


def _follow_evened(
    arm: ArmDescription,
    angles: FloatArray,
    durations: FloatArray,
    rate_hz: float,
    at_end: BoolArray,
    found: Followed,
) -> NDArray[np.intp]:
    """Follow what may be as predicted, or evened by the first step that helps; give the others."""
    rows, left = np.flatnonzero(at_end), [np.flatnonzero(~at_end)]
    for how in (None, *EVENINGS):
        if not rows.size:
            break
        before = angles[rows] if rows.size < len(angles) else angles
        motions = evened(before, how) if how else before
        some = tried(arm, motions, durations[rows], rate_hz, in_bells=how is not None)
        good, again = some.allowed, some.uneven
        few = 2 * np.count_nonzero(good) < len(good)  # which would keep the others in memory
        for place in np.flatnonzero(good).tolist():
            path = some.paced.path(place)
            found.paths[rows[place]] = path.copy() if few else path
        found.scales[rows[good]] = some.paced.scales[good]
        if how:
            found.evened[rows[good]] = nearer(before[good], how)
            found.changed.update(dict.fromkeys(rows[good].tolist(), UNEVEN))
            again = ~(good | some.swung)  # which is bent, one by one
        left.append(rows[~good & ~again])
        rows = rows[again]
    return np.sort(np.concatenate([*left, rows]))


def _finish(
    arm: ArmDescription,
    angles: FloatArray,
    duration: float,
    task: HandTask,
    rate_hz: float,
    row: int,
    found: Followed,
) -> None:
    """Finish one; what has no posture at all is refused before any is looked for nearby."""
    if refused := _surely_too_far(arm, angles, task.goal):
        raise refused
    done = finished(arm, angles, duration, task, rate_hz)
    found.paths[row], found.scales[row] = done.angles, done.time_scale
    found.evened[row], found.swivels[row] = done.evened, done.swivel_m or 0.0
    if done.refused:
        found.changed[row] = done.refused


def _surely_too_far(
    arm: ArmDescription, angles: FloatArray, target: FloatArray
) -> UnreachableError | None:
    chain = arm.chain
    if np.linalg.norm(tips(chain, angles[-1:])[0] - target) <= TOLERANCE_M:
        return None
    away = float(np.linalg.norm(target - chain.positions(angles[:1])[0, 0]))
    if away > chain.reach + TOLERANCE_M:
        return UnreachableError(
            f"target {where(target)} cannot be reached by {arm.name}: the arm is"
            f" {chain.reach:.2f} m long, the target {away:.2f} m from its first joint",
            away - chain.reach,
        )
    anywhere = reached_from(arm, angles[0], target)
    return None if anywhere.success else too_far(arm, target, anywhere)
