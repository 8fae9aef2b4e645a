"""Waiting until an arm is still, so that a motion can be planned from where it is."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.driver.clock import Clock, MonotonicClock
from armsyn.errors import RefusedMotionError
from armsyn.safety import START_TOLERANCE

FloatArray = NDArray[np.float64]

STILL_ANGLE = 0.01
STILL_TIME = 0.2
"""rad that no joint moves by, and seconds for which, in an arm that is still."""

LONGEST_WAIT = 8.0
"""Seconds to wait for that."""

LEANING = 0.5 * START_TOLERANCE
"""rad that a joint may be beyond its range for a motion to begin at its limit."""

_LOOK = 0.02


class Watched(Protocol):
    """An arm whose posture can be read: a session, or a monitor."""

    arm: ArmDescription

    def read_posture(self) -> FloatArray:
        """Present angles of the joints, shape (n,), rad."""
        ...


def still_posture(watched: Watched, clock: Clock | None = None) -> FloatArray:
    """Wait until the arm is still: a limp one may be swinging, or in somebody's hands.

    Parameters
    ----------
    watched : Watched
    clock : Clock, optional
        That it is waited on; the system's monotonic clock by default.

    Returns
    -------
    array, shape (n,)
        Angles of the joints, rad; where one is beyond its range by less than `LEANING`, its limit.

    Raises
    ------
    RefusedMotionError
        It has not been still for `STILL_TIME` within `LONGEST_WAIT`.
    """
    clock = clock or MonotonicClock()
    posture, since = watched.read_posture(), clock.now()
    end = since + LONGEST_WAIT
    while clock.now() - since < STILL_TIME:
        clock.sleep_until(clock.now() + _LOOK)
        here = watched.read_posture()
        moved = np.abs(here - posture)
        if moved.max() > STILL_ANGLE:
            posture, since = here, clock.now()
        if clock.now() > end:
            name = watched.arm.joint_names[int(np.argmax(moved))]
            raise RefusedMotionError(
                f"the arm has been moving for {LONGEST_WAIT:g} s ({name} the most): wait until it"
                " is still, or hold it until its torque is on"
            )
    # a limp arm leans on its stops, which give way a little beyond the range
    chain = watched.arm.chain
    within = np.clip(here, chain.lower, chain.upper)
    return np.where(np.abs(within - here) < LEANING, within, here)
