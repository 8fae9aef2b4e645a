"""What an arm that follows targets will be doing, if nothing else happens until then."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.kernels.following import follow
from armsyn.kernels.law import Law
from armsyn.planning.tracking_begin import STEP_S
from armsyn.planning.tracking_state import Aim, Going

FloatArray = NDArray[np.float64]


LATE_S = 5.0
"""Seconds after which a hand that should have arrived by then is given up."""


@dataclass
class Following:
    """What is being followed.

    Attributes
    ----------
    aim : Aim
    law : Law
        Its own; written to as it begins.
    since : float
        s of the stream.
    distance : float
        m from the hand to its target, at the last tick, as far as is known.
    near_for : float
        Seconds that the commanded hand has been at its target.
    settled : bool
    """

    aim: Aim
    law: Law
    since: float
    distance: float = np.inf
    near_for: float = 0.0
    settled: bool = False

    @property
    def patience(self) -> float:
        """When, s of the stream, a hand that should have arrived by then is given up."""
        return self.since + self.aim.planned.duration + LATE_S


class Moment(NamedTuple):
    """What planning starts from; its state, shape (7, n), is never written to."""

    t: float
    state: FloatArray
    following: Following | None


def turned(aim: Aim, t: float) -> Following:
    """Begin to follow an aim, at `t` s of the stream."""
    return Following(aim, aim.planned.law.copy(), t)


@dataclass(frozen=True)
class Foresight:
    """Plays ahead what an arm follows.

    Parameters
    ----------
    arm : array
        `armsyn.kernels.arm_numbers.packed`.
    """

    arm: FloatArray

    def state_at(
        self, moment: Moment, queued: tuple[Aim, ...], begin: float
    ) -> tuple[Going | None, FloatArray]:
        """What the arm will follow, and in which state.

        Parameters
        ----------
        moment : Moment
            Now.
        queued : tuple of Aim
            What it turns to meanwhile, in order.
        begin : float
            Then, s of the stream.

        Returns
        -------
        tuple of (Going or None, array of shape (7, n))
        """
        t, following, state = moment.t, moment.following, moment.state.copy()
        for aim in queued:
            if aim.begin < begin:
                turn = max(t, aim.begin)
                self._play(following, state, t, turn)
                following = turned(aim, turn)
                t = turn
        self._play(following, state, t, begin)
        if following is None:
            return None, state
        return Going(following.aim.planned, begin - following.since), state

    def _play(self, following: Following | None, state: FloatArray, t: float, until: float) -> None:
        if following is None or until <= t:
            return
        steps = max(1, int(np.ceil((until - t) / STEP_S - 1e-6)))
        elapsed, step = t - following.since, (until - t) / steps
        law, no_path = following.law.copy(), np.empty((0, state.shape[1]))
        follow(self.arm, *law, state, elapsed, step, steps, -1.0, True, no_path)
