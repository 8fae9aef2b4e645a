"""What an arm that follows targets will be doing, if nothing else happens until then."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.ik import optimiser_settings
from armsyn.planning.tracking_begin import STEP_S
from armsyn.planning.tracking_law import OFF, VELOCITY, Law, follow
from armsyn.planning.tracking_plan import GUARD, LawPlanner
from armsyn.planning.tracking_state import Aim, Going, State

FloatArray = NDArray[np.float64]


@dataclass
class Following:
    """What is being followed.

    Attributes
    ----------
    aim : Aim
    law : Law
        As it began.
    since : float
        s of the stream.
    near_for : float
        Seconds that the commanded hand has been at its target.
    settled : bool
    """

    aim: Aim
    law: Law
    since: float
    near_for: float = 0.0
    settled: bool = False


class Moment(NamedTuple):
    """What planning starts from; its state is never written to."""

    t: float
    state: State
    following: Following | None


class Foresight:
    """Plays ahead what an arm follows.

    Parameters
    ----------
    planner : LawPlanner

    Attributes
    ----------
    chain, settings, bounds
        As `armsyn.planning.tracking_law.follow` takes them.
    """

    def __init__(self, planner: LawPlanner) -> None:
        self._planner = planner
        self.chain = planner.arm.chain.arrays
        self.settings = optimiser_settings(planner.ik)
        self.bounds = planner.bounds(GUARD)
        self._no_path = np.empty((0, planner.arm.rest.size))

    def state_at(
        self, moment: Moment, queued: tuple[Aim, ...], begin: float
    ) -> tuple[Going | None, State]:
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
        tuple of (Going or None, State)
        """
        t, following, state = moment.t, moment.following, moment.state.copy()
        for aim in queued:
            if aim.begin < begin:
                turn = max(t, aim.begin)
                self._play(following, state, t, turn)
                following = Following(aim, self.begun(aim, state), turn)
                t = turn
        self._play(following, state, t, begin)
        if following is None:
            return None, state
        return Going(following.aim.planned, begin - following.since), state

    def _play(self, following: Following | None, state: State, t: float, until: float) -> None:
        if following is None or until <= t:
            return
        steps = max(1, int(np.ceil((until - t) / STEP_S - 1e-6)))
        follow(
            self.chain,
            self.settings,
            following.law,
            self.bounds,
            state.sensed[OFF],
            state.moving,
            t - following.since,
            (until - t) / steps,
            steps,
            -1.0,
            True,
            self._no_path,
        )

    def begun(self, aim: Aim, state: State) -> Law:
        """Law of an aim as it begins in a state."""
        law = aim.planned.law
        return self._planner.maker.begun(law, state) if state.moving[VELOCITY:].any() else law
