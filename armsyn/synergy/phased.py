"""Synergies over normalised time: every reach is played over one reference duration.

Repeats of a reach differ in pace more than in shape. Played over normalised time (lambda, slopes
and offsets of a reference duration, stretched with the reach: the planner's ``time_scale``) a set
of parameters describes the shape alone, so that sets of neighbouring targets can be mixed, and the
movement time is predicted for itself.

Sets are mixed in coordinates in which their bounds are a box and steps count alike: logarithms of
gains and slopes, and the moment o / s at which phi is one half.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from armsyn.errors import InputError
from armsyn.ik import optimiser_settings
from armsyn.kernels.rollout import Synergies, Timing, roll_out_lanes
from armsyn.kinematics import SerialChain
from armsyn.synergy.controller import ARM_RATES, LIMIT_RATE, RAMP_S
from armsyn.synergy.models import GAINS, STABLE_GAIN, parameter_names, parameter_ties

FloatArray = NDArray[np.float64]

HALVES = (0.02, 0.9)
"""Of the duration: when phi is one half."""
STEEPNESS = (1.5, 24.0)
"""Slope of a sigmoid times the duration."""
_FRAMES_PER_PHASE = 2
_MIDDLE = 0.3


@dataclass(frozen=True)
class PhasedSynergies:
    """A family of synergies: a model with positive gains on a chain, over a reference duration.

    Parameters
    ----------
    chain : SerialChain
    model : {"C", "D"}
    duration : float
        What normalised time is stretched to while it is played, s.
    ik : {"svd", "jt", "njt", "dls"}

    Raises
    ------
    InputError
        A model without sigmoid, or a duration that is not positive.
    """

    chain: SerialChain
    model: str
    duration: float
    ik: str = "svd"

    def __post_init__(self) -> None:
        if self.model not in ("C", "D") or not 0.0 < self.duration < np.inf:
            raise InputError(
                "synergies over normalised time are those of model C or D over a positive"
                f" duration, got {self.model!r} and {self.duration:g} s"
            )

    @property
    def lambda_(self) -> float:
        """lambda, 1/s, while played over `duration`."""
        return ARM_RATES[self.ik]

    @cached_property
    def lower(self) -> FloatArray:
        """Lower bounds of the coordinates, shape (P,)."""
        return self._box(0)

    @cached_property
    def upper(self) -> FloatArray:
        """Upper bounds of the coordinates, shape (P,)."""
        return self._box(1)

    @property
    def ties(self) -> NDArray[np.int64]:
        """Which coordinate of S_C each coordinate is."""
        return parameter_ties(self.model, self.chain.dof)

    @property
    def middle(self) -> FloatArray:
        """Coordinates to begin a search from: gains of one, a bell with its peak at a third."""
        slope = np.log(6.0 / self.duration)
        return np.array(
            [
                {"gain": 0.0, "offset": _MIDDLE * self.duration, "slope": slope}[kind]
                for kind in self._kinds
            ]
        )

    @property
    def _kinds(self) -> list[str]:
        joints = tuple(str(joint) for joint in range(self.chain.dof))
        return [name.split(":")[0] for name in parameter_names(self.model, joints)]

    def _box(self, side: int) -> FloatArray:
        bounds = {
            "gain": np.log((STABLE_GAIN, GAINS[1])),
            "offset": np.array(HALVES) * self.duration,
            "slope": np.log(np.array(STEEPNESS) / self.duration),
        }
        return np.array([bounds[kind][side] for kind in self._kinds])

    def synergies(self, coordinates: FloatArray) -> Synergies:
        """Return the synergies of coordinates, shape (M, P), which are kept within their bounds."""
        n = self.chain.dof
        inside = np.clip(coordinates, self.lower, self.upper)
        half = (inside.shape[1] - n) // 2
        slopes = np.ascontiguousarray(np.exp(inside[:, n + half :]))
        offsets = np.ascontiguousarray(inside[:, n : n + half] * slopes)
        # exp(log(bound)) may round to below the bound, which is a promise
        gains = np.clip(np.exp(inside[:, :n]), STABLE_GAIN, GAINS[1])
        return Synergies(np.ascontiguousarray(gains), slopes, offsets)

    def play(
        self, coordinates: FloatArray, starts: FloatArray, targets: FloatArray, phases: int
    ) -> FloatArray:
        """Roll motions out.

        Parameters
        ----------
        coordinates : array, shape (M, P)
        starts : array, shape (M, n)
            First postures, within the limits, rad or m.
        targets : array, shape (M, 3)
            Of the hand, base frame, m.
        phases : int
            Samples of normalised time.

        Returns
        -------
        array, shape (M, phases, n)
            rad or m, within the limits; phi rises by its ramp, limits are approached softly.
        """
        frames = (phases - 1) * _FRAMES_PER_PHASE + 1
        timing = Timing(self.lambda_, self.duration / (frames - 1), RAMP_S, LIMIT_RATE)
        paths = np.empty((len(starts), frames, self.chain.dof))
        paths[:, 0] = np.clip(starts, self.chain.lower, self.chain.upper)
        roll_out_lanes(
            *(self.chain.arrays, optimiser_settings(self.ik), self.synergies(coordinates)),
            *(timing, np.ascontiguousarray(targets), paths),
        )
        return paths[:, ::_FRAMES_PER_PHASE]
