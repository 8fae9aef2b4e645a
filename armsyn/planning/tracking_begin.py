"""Laws that begin where an arm is, as fast as it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.ik import optimiser_settings
from armsyn.planning.tracking_law import (
    CARRIED,
    CLOCK,
    FADE,
    GAIN,
    LIMIT_RATE,
    OFF,
    OFFSET,
    POSTURE,
    RAMP,
    RATE,
    SLOPE,
    VELOCITY,
    Law,
    controller_velocity,
)
from armsyn.planning.tracking_state import Candidate, State
from armsyn.synergy.controller import LIMIT_RATE as NEARING_RATE
from armsyn.synergy.controller import RAMP_S

FloatArray = NDArray[np.float64]

STEP_S = 0.005
"""Longest step of the law: lambda dt g must stay well below 1."""

FADE_S = 0.12
"""Least time constant with which a carried velocity fades, s: of what people have left of an
abandoned movement little remains after 0.4 s."""

_CLOCKS = 201
_SATURATED = 7.0
"""phi is 0.999 where its exponent is this far past the middle."""


@dataclass(frozen=True)
class LawMaker:
    """Makes laws of one arm.

    Parameters
    ----------
    arm : ArmDescription
    ik : {"svd", "jt", "njt", "dls"}
    rate : float
        lambda of the learned reaches, 1/s.
    """

    arm: ArmDescription
    ik: str
    rate: float

    def law(self, state: State, goal: FloatArray, candidate: Candidate) -> Law:
        """Make a law that begins where the arm is, as fast as it is.

        Parameters
        ----------
        state : State
        goal : array, shape (3,)
            m, base frame.
        candidate : Candidate
            With which synergy, and how slow.

        Returns
        -------
        Law
        """
        synergy, scale = candidate.synergy, candidate.scale
        hand, joints = np.zeros(8), np.zeros((5, self.arm.rest.size))
        hand[:3] = goal
        hand[RATE], hand[RAMP] = self.rate / scale, RAMP_S * scale
        hand[LIMIT_RATE], hand[FADE] = NEARING_RATE / scale, FADE_S
        joints[GAIN], joints[OFFSET] = synergy.gains[0], synergy.offsets[0]
        joints[SLOPE] = synergy.slopes[0] / scale
        law = Law(hand, joints)
        if not state.moving[VELOCITY:].any():
            return law
        hand[CLOCK] = (
            self._clock(law, state) if candidate.phase is None else candidate.phase * scale
        )
        return self.begun(law, state)

    def begun(self, law: Law, state: State) -> Law:
        """A law as it begins in a state: it carries over what the arm has and it does not.

        Parameters
        ----------
        law : Law
        state : State

        Returns
        -------
        Law
        """
        q, v, a = state.moving
        here = self._velocity(law, state, q, law.clock)
        soon = self._velocity(law, state, q + STEP_S * v, law.clock + STEP_S)
        most = self.arm.max_acceleration
        rest, bend = v - here, np.clip(a - (soon - here) / STEP_S, -most, most)
        hand, joints = law.hand.copy(), law.joints.copy()
        # what fades so decelerates by 1/e of its speed a time constant: half of what may be
        hand[FADE] = max(FADE_S, 2.0 / np.e * float(np.max(np.abs(rest) / most)))
        joints[CARRIED:] = rest, bend
        return Law(hand, joints)

    def _velocity(self, law: Law, state: State, q: FloatArray, t: float) -> FloatArray:
        velocity = np.empty(q.size)
        settings = optimiser_settings(self.ik)
        seen = q + state.sensed[OFF]
        controller_velocity(self.arm.chain.arrays, settings, law, seen, q, t, velocity)
        return velocity

    def _clock(self, law: Law, state: State) -> float:
        """The earliest time of phi at which the controller is nearest to the present velocity.

        An arm at rest begins anew, and so does one that moves elsewhere.
        """
        slopes, offsets, ramp = law.joints[SLOPE], law.joints[OFFSET], law.hand[RAMP]
        ready = Law(law.hand.copy(), law.joints.copy())
        ready.hand[[RAMP, LIMIT_RATE]] = 0.0, np.inf
        ready.joints[[SLOPE, OFFSET]] = [[0.0], [-np.inf]]
        full = self._velocity(ready, state, state.moving[POSTURE], 0.0)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            late = np.where(np.isfinite(offsets), (offsets + _SATURATED) / slopes, 0.0)
            clocks = np.linspace(0.0, max(float(late.max()), ramp), _CLOCKS)
            phi = 1.0 / (1.0 + np.exp(offsets - clocks[:, None] * slopes))
        x = np.minimum(clocks / ramp, 1.0)
        share = phi * (x**3 * (10.0 - 15.0 * x + 6.0 * x**2))[:, None]
        gap = ((state.moving[VELOCITY] - share * full) ** 2).sum(axis=1)
        return float(clocks[int(np.argmin(gap))])
