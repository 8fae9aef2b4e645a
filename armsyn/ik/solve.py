"""Solve inverse kinematics by iterating an optimiser until the hand is there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.ik.optimisers import optimiser_settings
from armsyn.kernels.solver import descend
from armsyn.kinematics import SerialChain
from armsyn.kinematics.rotation import checked_rotation

FloatArray = NDArray[np.float64]


class IkResult(NamedTuple):
    """What a solver found.

    Attributes
    ----------
    posture : array, shape (n,)
        The best posture met, within the limits, rad or m.
    position_error : float
        Distance of the hand to the target, m.
    orientation_error : float
        Angle to the wanted orientation, rad; 0 for a position task.
    steps : int
        Iterations made.
    success : bool
        Both errors are within tolerance.
    """

    posture: FloatArray
    position_error: float
    orientation_error: float
    steps: int
    success: bool


def solve_ik(
    chain: SerialChain,
    target: ArrayLike,
    start: ArrayLike,
    *,
    orientation: ArrayLike | None = None,
    optimiser: str = "svd",
    tolerance: float = 1e-4,
    max_steps: int = 2000,
    restarts: int = 0,
    seed: int = 0,
) -> IkResult:
    """Find a posture that puts the hand at a target.

    Each iteration moves along the optimiser's O(J, dX), where dX is shortened to a tenth of the
    chain's reach (0.3 rad for orientations) so that the linearisation holds, by the length that
    minimises the linearised error (Buss 2004, eq. 8), a tenth less for the transposes; joints are
    clamped to their limits, and a joint that presses against its limit is left out of the step.
    As the length is chosen here, ``jt`` and ``njt`` differ by rounding only.

    Parameters
    ----------
    chain : SerialChain
    target : array_like, shape (3,)
        Position, base frame, m.
    start : array_like, shape (n,)
        Posture to start from, rad or m.
    orientation : array_like, shape (3, 3), optional
        Wanted rotation matrix of the tip; without it the task is a position.
    optimiser : {"svd", "jt", "njt", "dls"}
    tolerance : float
        m for the position, rad for the orientation.
    max_steps : int
        Of each attempt; one that comes to a standstill short of the target ends earlier.
    restarts : int
        Further attempts, from random postures, while none has succeeded.
    seed : int
        Of those postures.

    Returns
    -------
    IkResult
        Never an error for an unreachable target: `success` is False and the rest says how near
        the hand came.

    Raises
    ------
    InputError
        Wrong shapes, not finite, no rotation matrix, unknown optimiser, or a tolerance or
        counts that make no attempt.
    """
    position = np.array(target, dtype=np.float64)
    if position.shape != (3,) or not np.isfinite(position).all():
        raise InputError(f"a target is 3 finite numbers of metres, got {position.tolist()}")
    if not 0.0 < tolerance < np.inf or max_steps < 1 or restarts < 0:
        raise InputError(
            "tolerance must be above 0, max_steps at least 1 and restarts at least 0,"
            f" got {tolerance:g}, {max_steps} and {restarts}"
        )
    wanted = np.empty((0, 0)) if orientation is None else checked_rotation(orientation)
    posture = np.clip(chain.checked_posture(start), chain.lower, chain.upper)
    settings = optimiser_settings(optimiser)
    move = 0.1 * chain.reach
    rng = np.random.default_rng(seed)
    best = IkResult(posture, np.inf, np.inf, 0, success=False)
    taken = 0
    for attempt in range(restarts + 1):
        if attempt:
            posture = rng.uniform(chain.lower, chain.upper)
        steps, distance, angle = descend(
            chain.arrays, settings, position, wanted, move, tolerance, max_steps, posture
        )
        taken += steps
        if distance + angle < best.position_error + best.orientation_error:
            success = distance <= tolerance and angle <= tolerance
            best = IkResult(posture, distance, angle, taken, success)
        if best.success:
            break
    return best._replace(steps=taken)
