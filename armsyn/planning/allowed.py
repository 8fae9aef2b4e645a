"""One motion over phase made samples that an arm may follow, or refused."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.kernels.reaches import ALLOWED
from armsyn.planning.bending import leaves_range, within_ranges
from armsyn.planning.evenness import uneven_speed
from armsyn.planning.generation.judging import judge
from armsyn.planning.generation.pacing import pace
from armsyn.planning.planned import trajectory_of
from armsyn.planning.timing import in_time
from armsyn.safety import check_trajectory

FloatArray = NDArray[np.float64]

SWING = 1e-4
"""rad (or m) by which a spline between samples within a range may leave it, and is put right."""


class Finished(NamedTuple):
    """A motion that an arm may follow.

    Attributes
    ----------
    angles : array, shape (frames, n)
        At the rate that was asked for, rad or m.
    positions : array, shape (frames, n + 1, 3)
        Of every joint and the tip then, m.
    time_scale : float
        kappa.
    swivel_m : float or None
        By how much the elbow ends elsewhere, m; None for the motion as predicted.
    evened : float
        How much of it is minimum jerk of every joint instead of what was predicted, 0 to 1.
    refused : str
        Why the predicted motion was, if it was.
    """

    angles: FloatArray
    positions: FloatArray
    time_scale: float
    swivel_m: float | None = None
    evened: float = 0.0
    refused: str = ""


def checked(arm: ArmDescription, angles: FloatArray, duration: float, rate_hz: float) -> Finished:
    """Bend a motion into the ranges, slow it, and refuse it if that fails or if it touches.

    Parameters
    ----------
    arm : ArmDescription
    angles : array, shape (phases, n)
        rad or m; the first and the last row within the limits.
    duration : float
        s.
    rate_hz : float

    Returns
    -------
    Finished

    Raises
    ------
    LimitError, CollisionError
        In the words of `armsyn.safety.check_trajectory`.
    UnevenError
        The hand's speed has more than one peak.
    """
    chain = arm.chain
    bent = within_ranges(chain, angles)
    paced = pace(arm, bent[None], np.array([duration]), rate_hz)
    if _beyond(arm, paced.paths) > SWING:  # the spline between samples that are within
        bent = within_ranges(chain, angles, inset=True)
        paced = pace(arm, bent[None], np.array([duration]), rate_hz)
    if outside := leaves_range(chain, bent):
        raise outside
    samples, scale = paced.path(0), float(paced.scales[0])
    if not len(samples):  # which then is refused here, by the joint's name
        samples, scale = in_time(bent, duration, arm, rate_hz)
    if _beyond(arm, samples) < SWING:
        np.clip(samples, chain.lower, chain.upper, out=samples)
    if judge(arm, paced).kinds[0] != ALLOWED:  # said in the driver's own words
        positions = chain.positions(samples)
        check_trajectory(trajectory_of(arm, samples, positions, rate_hz, "the reach"), arm)
    positions = arm.chain.positions(samples)
    if uneven := uneven_speed(positions[:, -1], rate_hz):
        raise uneven
    return Finished(samples, positions, scale)


def _beyond(arm: ArmDescription, samples: FloatArray) -> float:
    """How far samples leave the joints' ranges, rad or m."""
    beyond = np.maximum(arm.chain.lower - samples, samples - arm.chain.upper)
    return float(beyond.max(initial=0.0))
