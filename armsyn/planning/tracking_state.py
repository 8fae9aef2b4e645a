"""What planning and following targets hand to each other: states, plans, what is going on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.rollout import Synergies
from armsyn.planning.tracking_law import EXPECTED, MOVED, OFF, POSTURE, TRAILED, Law

FloatArray = NDArray[np.float64]

LAG_S = 0.05
"""By which measured joints trail their commands, s, until it is known better."""

_BELIEF = 0.1
"""How much motion, rad2/s, it takes to change one's mind about a lag by half."""


class State(NamedTuple):
    """How an arm moves, and how far it stands off what it is told.

    Attributes
    ----------
    moving : array, shape (3, n)
        Posture, rad, velocity, rad/s, and acceleration, rad/s2, as commanded.
    sensed : array, shape (4, n)
        What `armsyn.planning.tracking_law.tick` knows of how measured joints differ from that.
    """

    moving: FloatArray
    sensed: FloatArray

    @property
    def seen(self) -> FloatArray:
        """Where the arm is, as far as is known, shape (n,), rad."""
        return np.asarray(self.moving[POSTURE] + self.sensed[OFF])

    def copy(self) -> State:
        """Arrays that nobody else writes to."""
        return State(self.moving.copy(), self.sensed.copy())

    @classmethod
    def at_rest(cls, posture: FloatArray) -> State:
        """An arm that stands still where it is told, shape (n,), rad."""
        moving, sensed = np.zeros((3, posture.size)), np.zeros((4, posture.size))
        moving[POSTURE] = sensed[EXPECTED] = posture
        sensed[TRAILED], sensed[MOVED] = _BELIEF * LAG_S, _BELIEF
        return cls(moving, sensed)


@dataclass(frozen=True)
class PlannedLaw:
    """How a target is to be followed.

    Parameters
    ----------
    law : Law
    synergy : Synergies
    chosen_for : array, shape (3,)
        The target that the synergy was chosen for, m.
    path : array, shape (frames, n)
        What comes of it if nothing else happens, `STEP_S` apart, rad.
    duration : float
        Seconds until the hand has come to rest at its target.
    learned : str
        The captured reach whose synergy it uses.
    rank : int
        0 when that is the nearest.
    time_scale : float
        kappa, how much slower than the learned reach.
    """

    law: Law
    synergy: Synergies
    chosen_for: FloatArray
    path: FloatArray
    duration: float
    learned: str
    rank: int
    time_scale: float


class Candidate(NamedTuple):
    """A synergy with which a target may be reached for, and kappa so far.

    `phase` is the time of phi at which it goes on, over kappa, s; None for a new reach.
    """

    name: str
    rank: int
    synergy: Synergies
    scale: float
    chosen_for: FloatArray
    phase: float | None = None


class Going(NamedTuple):
    """What is followed when a new target comes.

    Attributes
    ----------
    planned : PlannedLaw
    elapsed : float
        Since it began, s.
    """

    planned: PlannedLaw
    elapsed: float


@dataclass(frozen=True)
class Aim:
    """A target that the arm turns to.

    Parameters
    ----------
    target : array, shape (3,)
        m, base frame.
    planned : PlannedLaw
    begin : float
        When, s of the stream.
    tag : object
        The caller's.
    """

    target: FloatArray
    planned: PlannedLaw
    begin: float
    tag: Any = None


End = Literal["arrived", "replaced", "missed"]


class Arrival(NamedTuple):
    """The end of following a target.

    Attributes
    ----------
    aim : Aim
    time : float
        s of the stream.
    error : float
        m from the measured hand to the target.
    how : {"arrived", "replaced", "missed"}
        Replaced by another target before it arrived; missed where something keeps the hand
        away that corrections do not overcome.
    """

    aim: Aim
    time: float
    error: float
    how: End
