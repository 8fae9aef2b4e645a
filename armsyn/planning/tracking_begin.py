"""Laws that begin where an arm is, as fast as it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.following import moves, nearest_clock
from armsyn.kernels.law import (
    CLOCK,
    END,
    END_GAP,
    ENDS,
    FADE,
    FADE_S,
    GAIN,
    HAND,
    JOINTS,
    LATE,
    LIMIT_RATE,
    OFFSET,
    RAMP,
    RATE,
    SLOPE,
    TARGET,
    Law,
)
from armsyn.planning.posing import HandTask
from armsyn.planning.tracking_state import Candidate
from armsyn.synergy.controller import LIMIT_RATE as NEARING_RATE
from armsyn.synergy.controller import RAMP_S

FloatArray = NDArray[np.float64]

STEP_S = 0.005
"""Longest step of the law: lambda dt g must stay well below 1."""


_END_SHARE = 0.25
"""Of the orientation's tolerance, that joints may stay away from where they are to end."""


@dataclass(frozen=True)
class LawMaker:
    """Makes laws of one arm.

    Parameters
    ----------
    arm : array
        `armsyn.kernels.arm_numbers.packed`.
    """

    arm: FloatArray

    def law(
        self,
        state: FloatArray,
        task: HandTask,
        candidate: Candidate,
        ending: FloatArray | None = None,
    ) -> Law:
        """Make a law that begins where the arm is, as fast as it is.

        Parameters
        ----------
        state : array, shape (7, n)
            As `armsyn.kernels.following` has it.
        task : HandTask
        candidate : Candidate
            With which synergy, and how slow.
        ending : array, shape (n,), optional
            The posture to end in, rad, of a hand that is to be turned, too.

        Returns
        -------
        Law
            What it carries over is not known before it is followed.
        """
        synergy, scale = candidate.synergy, candidate.scale
        hand, joints = np.zeros(HAND), np.zeros((JOINTS, state.shape[1]))
        hand[TARGET] = task.goal
        hand[RATE], hand[RAMP] = candidate.rate / scale, RAMP_S * scale
        closes = candidate.closes or ending is not None
        hand[LATE] = 0.5 * candidate.lasts * scale if closes else np.inf
        if ending is not None and task.orientation is not None:
            hand[ENDS], hand[END_GAP] = 1.0, _END_SHARE * task.orientation.tolerance
            joints[END] = ending
        hand[LIMIT_RATE], hand[FADE] = NEARING_RATE / scale, FADE_S
        joints[GAIN], joints[OFFSET] = synergy.gains[0], synergy.offsets[0]
        joints[SLOPE] = synergy.slopes[0] / scale
        if moves(state):
            hand[CLOCK] = (
                candidate.phase * scale
                if candidate.phase is not None
                else nearest_clock(self.arm, hand, joints, state)
            )
        return Law(hand, joints)
