"""The motion controller: an iterative IK step, multiplied by a synergy.

Aubry, Julliard, Gibet 2009, 3.1-3.2. One step: dX = X_d - H(theta);
dtheta = lambda dt O(J, dX); theta' = theta + phi(t) (M dtheta), clamped to the joints' limits.
lambda is a rate (1/s), so that a motion does not depend on the frame rate; the paper's scalar
per frame is lambda dt.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.errors import InputError
from armsyn.ik import optimiser_settings
from armsyn.kernels import rollout as kernels
from armsyn.kernels.rollout import Synergies, Task, Timing
from armsyn.kinematics import SerialChain
from armsyn.kinematics.rotation import checked_rotation

FloatArray = NDArray[np.float64]

RATES = {"svd": 6.0, "jt": 60.0, "njt": 3.0, "dls": 6.0}
"""lambda of each optimiser, 1/s, large enough for the paper's bounds of the gains not to bind."""


ARM_RATES = {"svd": 10.0, "jt": 60.0, "njt": 3.0, "dls": 10.0}
"""lambda for arms that move, 1/s: with gains of at least a quarter it bounds the slowest decay,
and 10 instead of 6 per second lets the hand come to rest as people do."""

RAMP_S = 0.1
"""Minimum-jerk rise of phi on arms: phi(0) > 0 would start with a jump of 200-320 rad/s2."""

LIMIT_RATE = 10.0
"""1/s: how fast an arm's joint may near its limit; a clamp would stop it within one tick."""


class RollOut(NamedTuple):
    """A synthesized motion.

    Attributes
    ----------
    time : array, shape (frames,)
        Seconds from the start.
    angles : array, shape (frames, n)
        rad or m.
    positions : array, shape (frames, n + 1, 3)
        Of every joint and the tip, base frame, m.
    distance : float
        From the tip to the target at the last frame, m.
    arrived : bool
        Whether it stopped within the tolerance.
    """

    time: FloatArray
    angles: FloatArray
    positions: FloatArray
    distance: float
    arrived: bool


@dataclass(frozen=True)
class Controller:
    """The controller of one chain with one optimiser.

    Parameters
    ----------
    chain : SerialChain
    optimiser : {"svd", "jt", "njt", "dls"}
    rate : float or None
        lambda, 1/s; the optimiser's own (`RATES`) when None.

    Raises
    ------
    InputError
        Unknown optimiser, or a rate that is no positive number.
    """

    chain: SerialChain
    optimiser: str = "svd"
    rate: float | None = None

    def __post_init__(self) -> None:
        optimiser_settings(self.optimiser)
        if not (np.isfinite(self.lambda_) and self.lambda_ > 0):
            raise InputError(f"lambda must be a positive rate in 1/s, got {self.rate}")

    @property
    def lambda_(self) -> float:
        """lambda, 1/s."""
        return RATES[self.optimiser] if self.rate is None else self.rate

    def synthesize(
        self,
        start: ArrayLike,
        target: ArrayLike,
        synergy: Synergies,
        *,
        dt: float,
        frames: int,
        orientation: ArrayLike | None = None,
        tolerance: float = -1.0,
        time_scale: float = 1.0,
        ramp: float = 0.0,
        limit_rate: float = np.inf,
    ) -> RollOut:
        """Play one motion.

        Parameters
        ----------
        start : array_like, shape (n,)
            Initial posture, rad or m.
        target : array_like, shape (3,)
            Position of the hand, base frame, m.
        synergy : Synergies
            Of one lane.
        dt : float
            Time between frames, s.
        frames : int
            How many at most.
        orientation : array_like, shape (3, 3), optional
            Of the hand; without it the task is a position.
        tolerance : float
            Stop within this distance of the target, m (and rad); negative: play every frame.
        time_scale : float
            Slow the motion as a whole: lambda / kappa, s / kappa, ramp kappa.
        ramp : float
            phi is multiplied by a minimum-jerk rise of this duration (before scaling), s.
        limit_rate : float
            A joint nears a limit at most at this rate (before scaling) times its distance to
            it, 1/s; infinite: joints are clamped at their limits.

        Returns
        -------
        RollOut

        Raises
        ------
        InputError
            Wrong counts, not finite, no rotation matrix, or times that are not positive.
        """
        if frames < 1 or not (0 < dt < np.inf and 0 < time_scale < np.inf):
            raise InputError(
                f"frames, dt and time_scale must be positive, got {frames}, {dt:g}, {time_scale:g}"
            )
        position = np.asarray(target, dtype=np.float64)
        if position.shape != (3,) or not np.isfinite(position).all():
            raise InputError(f"a target is 3 finite numbers of metres, got {position.tolist()}")
        wanted = np.empty((0, 0)) if orientation is None else checked_rotation(orientation)
        path = np.empty((frames, self.chain.dof))
        path[0] = self.chain.checked_posture(start)
        positions = np.empty((frames, self.chain.dof + 1, 3))
        filled, distance = kernels.roll_out(
            self.chain.arrays,
            optimiser_settings(self.optimiser),
            synergy.gains[0],
            synergy.slopes[0] / time_scale,
            synergy.offsets[0],
            Timing(self.lambda_ / time_scale, dt, ramp * time_scale, limit_rate / time_scale),
            Task(position, wanted),
            tolerance,
            path,
            positions,
        )
        arrived = distance <= tolerance and self._turn_left(path[filled - 1], wanted) <= tolerance
        return RollOut(
            np.arange(filled, dtype=np.float64) * dt,
            path[:filled],
            positions[:filled],
            distance,
            arrived,
        )

    def _turn_left(self, posture: FloatArray, wanted: FloatArray) -> float:
        """Angle from the hand's orientation to the wanted one, rad; 0 for a position task."""
        if not wanted.size:
            return 0.0
        dX = np.empty(6)
        tip = self.chain.forward(posture).orientations[-1]
        kernels.task_error(np.zeros(3), wanted, np.zeros(3), tip, dX)
        return float(np.linalg.norm(dX[3:]))
