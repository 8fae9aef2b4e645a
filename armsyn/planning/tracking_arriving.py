"""Whether a hand that follows a target has arrived at it."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from armsyn.kinematics import SerialChain
from armsyn.planning.tracking_ahead import Following
from armsyn.planning.tracking_state import Arrival, End

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

ARRIVED_M = 1e-3
"""m between measured hand and target within which the hand has arrived."""

MISSED_M = 5e-3
"""m beyond which a hand that can be brought no nearer has missed its target."""

SETTLE_S = 0.1
"""Seconds that the commanded hand is at its target before the measured one is looked at."""

PATIENCE_S = 1.5
"""Seconds after that in which the measured hand may still be brought nearer."""


class Measured(Protocol):
    """What the joints answered last; `armsyn.driver.joints.JointState` is one."""

    @property
    def position(self) -> FloatArray:
        """rad, shape (n,)."""

    @property
    def fresh(self) -> BoolArray:
        """Which of them answered, shape (n,)."""


def looked(
    following: Following, state: Measured, seen: FloatArray, t: float, chain: SerialChain
) -> Arrival | None:
    """See whether the hand has arrived, the commanded one having been there for `SETTLE_S`.

    Parameters
    ----------
    following : Following
        Written to.
    state : Measured
    seen : array, shape (n,)
        Where the arm is, as far as is known, rad.
    t : float
        s of the stream.
    chain : SerialChain

    Returns
    -------
    Arrival or None
    """
    late = t > following.patience
    known = np.isfinite(state.position)
    task = following.aim.planned.task
    error, turn = task.errors(chain, np.where(known, state.position, seen))
    turned = task.orientation is None or turn <= task.orientation.tolerance
    if not (error <= ARRIVED_M and turned) and following.near_for < PATIENCE_S and not late:
        return None
    following.settled = True
    how: End = "arrived" if error <= MISSED_M and turned else "missed"
    return Arrival(following.aim, t, error, turn, how)
