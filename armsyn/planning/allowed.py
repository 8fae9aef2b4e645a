"""Motions over phase made samples that an arm may follow, or refused."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import RefusedMotionError
from armsyn.kernels.judging import ALLOWED, CONTACT
from armsyn.kernels.rates import RateLimits
from armsyn.kernels.trying import Bounds, Outcomes, try_reaches
from armsyn.planning.bending import INSIDE, leaves_range, within_ranges
from armsyn.planning.evenness import measure_of, uneven_speed
from armsyn.planning.pacing import EASE, Paced
from armsyn.planning.planned import trajectory_of
from armsyn.planning.timing import SHORTEST_S, Rates, in_time
from armsyn.planning.verdicts import Verdicts, tolerances_at
from armsyn.safety import Clearances, check_trajectory

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

SWING = 1e-4
"""rad (or m) by which a spline between samples within a range may leave it, and is put right."""


class Finished(NamedTuple):
    """A motion that an arm may follow.

    Attributes
    ----------
    angles : array, shape (frames, n)
        At the rate that was asked for, rad or m.
    time_scale : float
        kappa.
    swivel_m : float or None
        By how much the elbow ends elsewhere, m; None for the motion as predicted.
    evened : float
        How much nearer to minimum jerk of every joint it is than what was predicted, 0 to 1; see
        `armsyn.planning.evening.nearer`. 1, too, where the hand is led straight instead.
    refused : str
        Why the predicted motion was, if it was.
    """

    angles: FloatArray
    time_scale: float
    swivel_m: float | None = None
    evened: float = 0.0
    refused: str = ""


class Tried(NamedTuple):
    """What came of M motions as they are.

    Attributes
    ----------
    paced : Paced
        Their samples.
    verdicts : Verdicts
        On them, but for bells and ranges, to which they are clipped; `ALLOWED` of those that
        were not judged.
    allowed, uneven : array of bool, shape (M,)
        Which may be followed, and which but for more than one bell; no such one `in_bells`.
    beyond, swung : array of bool, shape (M,)
        Which leave the ranges, or whose splines do by more than `SWING`: those are neither.
    """

    paced: Paced
    verdicts: Verdicts
    allowed: BoolArray
    uneven: BoolArray
    beyond: BoolArray
    swung: BoolArray


def tried(
    arm: ArmDescription,
    angles: FloatArray,
    durations: FloatArray,
    rate_hz: float,
    *,
    in_bells: bool = False,
) -> Tried:
    """Slow many motions, and say which of them an arm may follow.

    Each is eased, slowed and sampled as `armsyn.planning.timing.in_time` does one, and judged as
    `armsyn.safety.check_trajectory` and `uneven_speed` judge one.

    Parameters
    ----------
    arm : ArmDescription
    angles : array, shape (M, phases, n)
        rad or m, finite; the first and the last row of each within the limits.
    durations : array, shape (M,)
        s.
    rate_hz : float
    in_bells : bool
        Judge only what goes in one bell within the ranges: what else is wrong is not asked.

    Returns
    -------
    Tried
    """
    motions, count = np.ascontiguousarray(angles), len(angles)
    solids, rate = arm.solids, float(rate_hz)
    bounds = Bounds(
        INSIDE,
        SWING,
        solids.reach,
        Clearances.of(arm).required,
        RateLimits(*Rates.of(arm)),
        RateLimits(arm.max_velocity, arm.max_acceleration, arm.max_jerk),
    )
    scales, values = np.empty((2, count))
    peaks, kinds, frames, items = np.empty((4, count), dtype=np.int64)
    beyond, swung = np.empty((2, count), dtype=np.bool_)
    first, paths = try_reaches(
        arm.chain.arrays,
        solids.arrays,
        bounds,
        tolerances_at(rate),
        EASE,
        measure_of(rate),
        rate,
        in_bells,
        motions,
        np.maximum(durations, SHORTEST_S),
        Outcomes(beyond, swung, scales, peaks, kinds, frames, items, values),
    )
    verdicts = Verdicts(kinds, frames, items, values)
    good = (kinds == ALLOWED) & (first[1:] > first[:-1]) & ~(beyond | swung)
    is_bell = peaks <= 1
    uneven = good & ~is_bell & (not in_bells)  # what was not judged may be wrong otherwise, too
    return Tried(
        Paced(paths, first, scales, rate_hz), verdicts, good & is_bell, uneven, beyond, swung
    )


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
    bent, durations = angles, np.array([duration])
    found = tried(arm, bent[None], durations, rate_hz)
    if found.beyond[0]:
        bent = within_ranges(arm.chain, angles)
        found = tried(arm, bent[None], durations, rate_hz)
    if found.swung[0]:  # the spline between samples that are within
        bent = within_ranges(arm.chain, angles, inset=True)
        found = tried(arm, bent[None], durations, rate_hz)
    samples, scale = found.paced.path(0), float(found.paced.scales[0])
    if not found.allowed[0]:
        if not len(samples) or found.swung[0]:  # which is refused, by the joint's name
            samples, scale = in_time(bent, duration, arm, rate_hz)
        if refused := _why_not(arm, bent, samples, scale, rate_hz, found):
            raise refused
    return Finished(samples, scale)


def _why_not(
    arm: ArmDescription,
    bent: FloatArray,
    samples: FloatArray,
    scale: float,
    rate_hz: float,
    found: Tried,
) -> RefusedMotionError | None:
    """Say in the driver's own words what is against a motion; None where that is by rounding."""
    if outside := leaves_range(arm.chain, bent):
        return outside
    kind, frame, item, value = (part[0] for part in found.verdicts)
    if kind == CONTACT and not found.swung[0]:  # whose verdict is on what was clipped
        kept = Clearances.of(arm, start=samples[0])
        return kept.error(int(item), float(value), int(frame), float(frame) / rate_hz)
    positions = arm.chain.positions(samples)
    try:
        if not found.uneven[0]:  # but that there is nothing
            check_trajectory(trajectory_of(arm, samples, positions, rate_hz, "the reach"), arm)
    except RefusedMotionError as refused:
        return refused
    return uneven_speed(positions[:, -1], rate_hz, scale)
