"""What planning and following targets hand to each other: states, plans, what is going on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.following import EXPECTED, MOVED, OFF, POSTURE, TRAILED
from armsyn.kernels.law import Law
from armsyn.kernels.rollout import Synergies
from armsyn.planning.posing import HandTask

FloatArray = NDArray[np.float64]

LAG_S = 0.05
"""By which measured joints trail their commands, s, until it is known better."""

_BELIEF = 0.1
"""How much motion, rad2/s, it takes to change one's mind about a lag by half."""


def at_rest(posture: FloatArray) -> FloatArray:
    """State, shape (7, n), of an arm that stands still where it is told, shape (n,), rad."""
    state = np.zeros((7, posture.size))
    state[POSTURE] = state[EXPECTED] = posture
    state[TRAILED], state[MOVED] = _BELIEF * LAG_S, _BELIEF
    return state


def seen(state: FloatArray) -> FloatArray:
    """Where the arm is, as far as is known, shape (n,), rad."""
    return np.asarray(state[POSTURE] + state[OFF])


class Candidate(NamedTuple):
    """A synergy with which a target may be reached for.

    Attributes
    ----------
    synergy : Synergies
    rate : float
        lambda of it, 1/s.
    chosen_for : array, shape (3,)
        The target that it was chosen for, m.
    outside : float or None
        m from that to what was captured.
    learned : str or None
        The captured reach that it was learned from; None for one of the place.
    rank : int or None
        0 when that is the nearest.
    lasts : float
        Seconds in which the synergy as it stands was fitted to bring the hand about there.
    closes : bool
        Whether what is left is to be closed by gains that rise to one at least.
    pace : float
        By how much a person's reach there is slower than the synergy as it stands.
    scale : float
        By how much this one is to be.
    phase : float or None
        The time of phi at which it goes on, over the scale, s; None for a new reach.
    """

    synergy: Synergies
    rate: float
    chosen_for: FloatArray
    outside: float | None
    lasts: float
    closes: bool = False
    learned: str | None = None
    rank: int | None = None
    pace: float = 1.0
    scale: float = 1.0
    phase: float | None = None

    @property
    def time_scale(self) -> float:
        """kappa, how much slower than a person's."""
        return self.scale / self.pace


@dataclass(frozen=True)
class PlannedLaw:
    """How a target is to be followed.

    Parameters
    ----------
    law : Law
    task : HandTask
    chosen : Candidate
        The synergy, as slow as it has to be.
    path : array, shape (frames, n)
        What comes of it if nothing else happens, `STEP_S` apart, rad.
    duration : float
        Seconds until the hand has come to rest at its target.
    """

    law: Law
    task: HandTask
    chosen: Candidate
    path: FloatArray
    duration: float


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
    planned : PlannedLaw
    begin : float
        When, s of the stream.
    tag : object
        The caller's.
    """

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
    turn : float
        rad from how it is turned to how it should be; 0 where that is nothing.
    how : {"arrived", "replaced", "missed"}
        Replaced by another target before it arrived; missed where something keeps the hand
        away that corrections do not overcome.
    """

    aim: Aim
    time: float
    error: float
    turn: float
    how: End
