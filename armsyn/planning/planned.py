"""What a planner gives: a trajectory, and how it came about."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import InputError
from armsyn.motion import Motion
from armsyn.planning.posing import HandOrientation
from armsyn.synergy import LearnedReach, SynergySet

FloatArray = NDArray[np.float64]

SETTLE_S = 0.1
"""The last posture is held so long, so that a recording shows the hand at rest."""


@dataclass(frozen=True)
class PlannedReach:
    """A trajectory with where it came from.

    Parameters
    ----------
    trajectory : Motion
        Joint angles and the arm's landmarks at the planning rate.
    target : array, shape (3,)
        m, base frame.
    plan : str
        Which planner: ``synergy``, ``latent``, ``linear``, ``minjerk``.
    time_scale : float
        kappa, how much slower than a person.
    duration_s : float
        How long a person would take, as the planner predicts, s; of ``minjerk`` a rule's time.
    error_m : float
        From the planned end of the hand to the target, m.
    outside_m : float or None
        How far outside the captured workspace the target lies, m; 0 inside, None where nothing
        captured is known.
    swivel_m : float or None
        By how much another swivel moves the arm (its elbow) at the end, m; None for the first.
    evened : float
        How much nearer to minimum jerk of every joint than predicted, 0 to 1, where as predicted
        the hand would speed up more than once, or no way was free.
    refused : str
        Why the motion as predicted was refused, if it was: what was planned instead is not.
    learned : LearnedReach or None
        The nearest captured reach; of ``synergy`` the one whose synergy it uses.
    synergy : SynergySet or None
        Of ``synergy`` only.
    rank : int
        Of ``synergy``: 0 when the nearest one served; more when nearer ones did not.
    orientation : HandOrientation or None
        What was asked for.
    orientation_error : float
        Angle left to it at the planned end, rad; 0 where nothing was asked for.
    """

    trajectory: Motion
    target: FloatArray
    plan: str
    time_scale: float
    duration_s: float
    error_m: float
    outside_m: float | None = None
    swivel_m: float | None = None
    evened: float = 0.0
    refused: str = ""
    learned: LearnedReach | None = None
    synergy: SynergySet | None = None
    rank: int = 0
    orientation: HandOrientation | None = None
    orientation_error: float = 0.0

    @property
    def angles(self) -> FloatArray:
        """Joint angles of the trajectory, shape (frames, n), rad or m."""
        assert self.trajectory.angles is not None  # noqa: S101 - planned
        return self.trajectory.angles


def trajectory_of(
    arm: ArmDescription, angles: FloatArray, positions: FloatArray, rate_hz: float, source: str
) -> Motion:
    """Make sampled angles a motion of an arm, which holds its last posture for `SETTLE_S`.

    Parameters
    ----------
    arm : ArmDescription
    angles : array, shape (frames, n)
        rad or m.
    positions : array, shape (frames, n + 1, 3)
        As of `SerialChain.positions`, m.
    rate_hz : float
    source : str

    Returns
    -------
    Motion
    """
    frames = len(angles) + int(np.ceil(SETTLE_S * rate_hz))
    return Motion(
        time=np.arange(frames) / rate_hz,
        joint_names=arm.joint_names,
        angles=_held(angles, frames),
        landmark_names=tuple(arm.landmarks),
        landmarks=_held(positions.take(arm.landmark_frames, axis=1), frames),
        source=source,
    )


def _held(values: FloatArray, frames: int) -> FloatArray:
    """Values, shape (fewer frames, ...), with the last again and again to the end."""
    held = np.empty((frames, *values.shape[1:]))
    held[: len(values)], held[len(values) :] = values, values[-1]
    return held


def concatenated(first: Motion, second: Motion) -> Motion:
    """Return two motions of the same joints one after the other.

    Parameters
    ----------
    first, second : Motion
        At one rate; the second starts where the first ends.

    Returns
    -------
    Motion

    Raises
    ------
    InputError
        Other joints, or a second motion that starts elsewhere.
    """
    if first.joint_names != second.joint_names:
        raise InputError(f"{second.source} has other joints than {first.source}")
    if first.angles is None or second.angles is None:
        raise InputError("only motions with joint angles can be joined")
    if not np.allclose(first.angles[-1], second.angles[0], rtol=0.0, atol=1e-3):
        raise InputError(f"{second.source} does not start where {first.source} ends")
    step = 1.0 / first.rate
    rows = [(motion.angles, motion.landmarks) for motion in (first, second)]
    angles, landmarks = (
        None if any(part is None for part in parts) else np.concatenate(parts)
        for parts in zip(*rows, strict=True)
    )
    return Motion(
        time=np.concatenate([first.time, first.time[-1] + step + second.time - second.time[0]]),
        joint_names=first.joint_names,
        angles=angles,
        landmark_names=first.landmark_names,
        landmarks=landmarks,
        source=f"{first.source}, then {second.source}",
    )
