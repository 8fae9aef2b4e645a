"""One step of prioritised inverse kinematics, whatever the unknowns are.

Baerlocher and Boulic (2004), Siciliano and Slotine (1991): with Delta_0 = 0 and P_0 = I, level i

    J~ = J_i P_(i-1),    Delta_i = Delta_(i-1) + J~^(+xi) (dx_i - J_i Delta_(i-1)),
    P_i = P_(i-1) - J~^+ J~

and last P z is added. The pseudo-inverse in P is undamped and cut at the numerical rank: with the
damped one the first priority slips by centimetres.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
RANK = 1e-6
"""Of a level's largest singular value: what is smaller once higher levels are served is not the
level's to move."""


class Level(NamedTuple):
    """The goals of one priority.

    Attributes
    ----------
    J : array, shape (p, q)
        What they move by, a unit of the unknowns.
    error : array, shape (p,)
        What is missing to the goals, m (and rad, for orientations).
    """

    J: FloatArray
    error: FloatArray


class Damping(NamedTuple):
    """How the pseudo-inverse is damped.

    Attributes
    ----------
    value : float
        Not negative.
    relative : bool
        Whether it is a share of a level's largest singular value, else it is in their units.
    """

    value: float
    relative: bool = True


def priority_step(
    levels: Sequence[Level], damping: Damping, z: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Solve one step (second paper, Eq. 10, for several levels).

    Parameters
    ----------
    levels : sequence of Level
        The first priority first.
    damping : Damping
    z : array, shape (q,), optional
        What to do with what freedom is left.

    Returns
    -------
    step : array, shape (q,)
    projector : array, shape (q, q)
        On what none of the levels moves.
    """
    q = levels[0].J.shape[1]
    step, P = np.zeros(q), np.eye(q)
    for J, error in levels:
        U, s, V = np.linalg.svd(J @ P, full_matrices=False)
        whole = float(np.linalg.norm(J, 2))
        kept = s > RANK * whole
        U, s, V = U[:, kept], s[kept], V[kept]
        xi = damping.value * whole if damping.relative else damping.value
        step = step + V.T @ (s / (s * s + xi * xi) * (U.T @ (error - J @ step)))
        P = P - V.T @ V
    if z is not None:
        step = step + P @ z
    return step, P
