"""What stops the joints of an arm of MuJoCo's beside the ends of their ranges: obstacles."""

from __future__ import annotations

import numpy as np

from firmware_sim.physics import kernel
from firmware_sim.physics.arm_kernel import COLUMNS, find_stops
from firmware_sim.physics.arm_model import QUICK, STIFF, ArmModel


class Stops:
    """Obstacles as narrower ranges of the joints, as hard as MuJoCo makes them.

    Parameters
    ----------
    arm : ArmModel
        Whose joints they stop.
    """

    def __init__(self, arm: ArmModel) -> None:
        model = arm.model
        self._arm = arm
        self._known = np.full((len(arm.joints), 2), [-np.inf, np.inf])
        self._tables = (model.jnt_limited, model.jnt_range, model.jnt_solref, model.jnt_solimp)
        self._own = [table.copy() for table in self._tables]

    def update(self, state: kernel.FloatArray, mounts: kernel.FloatArray) -> None:
        """Put them where they are now.

        Parameters
        ----------
        state : ndarray of float, shape (servos, kernel.COLUMNS)
            Of all axes.
        mounts : ndarray of float, shape (2, servos)
            Directions, 1 or -1, and angles of the horns at the joints' zeros, rad.
        """
        if not find_stops(state, COLUMNS, self._known):
            return
        for table, own in zip(self._tables, self._own, strict=True):
            table[:] = own
        directions, zeros = mounts
        for i, joint in enumerate(self._arm.joints):
            if np.isfinite(self._known[i]).any():
                self._narrow(joint, np.sort(directions[i] * (self._known[i] - zeros[i])))

    def _narrow(self, joint: int, stops: kernel.FloatArray) -> None:
        limited, ranges, solref, solimp = self._tables
        low, high = ranges[joint] if limited[joint] else (-np.inf, np.inf)
        ranges[joint] = max(low, stops[0]), min(high, stops[1])
        limited[joint] = True
        solref[joint], solimp[joint] = QUICK, STIFF
