"""The check of a whole trajectory before anything moves."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import InputError, LimitError, RefusedMotionError
from armsyn.safety.collision import MARGIN, check_collision
from armsyn.safety.limits import POSITION_TOLERANCE

FloatArray = NDArray[np.float64]

START_TOLERANCE = 0.05
"""rad (or m) between where the arm is and where a trajectory may start."""

RATE_TOLERANCE = 0.02
"""Part of a speed, acceleration or jerk limit that sampling may add to a motion that keeps it."""

ROUNDING = 5e-7
"""rad (or m) that angles may be rounded by: six decimals, or single precision."""

JERK_SPAN = 0.005
"""s over which a jerk is taken at least. Acceleration that steps, as at the end of a reach, has no
jerk at all: that of its samples would depend on their rate."""

UNIFORM_TOLERANCE = 0.01
"""Part of a time step by which steps may differ."""


class Trajectory(Protocol):
    """What is checked: an ``armsyn.motion.Motion``, whose room lies above this one."""

    @property
    def time(self) -> FloatArray:
        """Seconds, shape (frames,)."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """One a column of `angles`."""

    @property
    def angles(self) -> FloatArray | None:
        """Rad (or m), shape (frames, n)."""

    @property
    def source(self) -> str:
        """Where it comes from, for people."""


def check_trajectory(
    motion: Trajectory,
    arm: ArmDescription,
    present_posture: ArrayLike | None = None,
    *,
    start_tolerance: float = START_TOLERANCE,
    margin: float = MARGIN,
) -> None:
    """Refuse a trajectory that the arm must not follow.

    Speeds and accelerations are differences of neighbouring samples, jerks those of accelerations
    over 5 ms (or from one sample to the next, where that is longer); the arm rests before
    the first and after the last, so that a trajectory that starts or ends at speed is refused too.
    Nothing may touch on the whole way, between the samples neither (`check_collision`); a contact
    at the start may be left.

    Parameters
    ----------
    motion : Trajectory
        A Motion with angles, rad (or m).
    arm : ArmDescription
    present_posture : array_like, shape (n,), optional
        Where the arm is, rad (or m); not checked when it is not given.
    start_tolerance : float
        rad (or m).
    margin : float
        m to keep between what must not touch.

    Raises
    ------
    InputError
        No angles, other joints than the arm's, or values that are not finite.
    RefusedMotionError
        Time stamps that are not uniform.
    LimitError
        A joint leaves its range, exceeds its speed, acceleration or jerk, or starts elsewhere;
        the message names joint, time, value and limit.
    CollisionError
        Links that touch each other, a plane or a box; the message names both and the time.
    """
    angles = _finite_angles(motion, arm)
    step = _uniform_step(motion)
    if present_posture is not None:
        check_start(angles[0], present_posture, arm, start_tolerance)
    _check_range(motion.time, angles, arm)
    _check_rates(motion.time, angles, step, arm)
    collision = check_collision(angles, arm, margin, time=motion.time, leaving=True)
    if collision is not None:
        raise collision


def _check_rates(time: FloatArray, angles: FloatArray, step: float, arm: ArmDescription) -> None:
    span = max(1, round(JERK_SPAN / step))
    resting = np.concatenate([angles[:1]] * (span + 1) + [angles] + [angles[-1:]] * (span + 1))
    velocity = np.diff(resting, axis=0) / step
    acceleration = np.diff(velocity, axis=0) / step
    jerk = (acceleration[span:] - acceleration[:-span]) / (span * step)
    for rates, quantity, limits, rounded in (
        (velocity, "a speed of {:.2f} rad/s", arm.max_velocity, 2.0 / step),
        (acceleration, "an acceleration of {:.2f} rad/s2", arm.max_acceleration, 4.0 / step**2),
        (jerk, "a jerk of {:.0f} rad/s3", arm.max_jerk, 8.0 / (span * step**3)),
    ):
        row, joint = _worst(rates, limits)
        value, limit = float(rates[row, joint]), float(limits[joint])
        if abs(value) > limit * (1.0 + RATE_TOLERANCE) + ROUNDING * rounded:
            frame = min(max(row - span if rates is not jerk else row, 0), time.size - 1)
            raise LimitError(
                f"joint {arm.joint_names[joint]} would have {quantity.format(value)} at"
                f" {time[frame]:.3f} s, its limit is"
                f" {limit:.2f}: slow the motion down, or smooth it",
                arm.joint_names[joint],
                value,
                limit,
            )


def _finite_angles(motion: Trajectory, arm: ArmDescription) -> FloatArray:
    where = motion.source or "motion"
    if motion.angles is None:
        raise InputError(f"{where}: has no joint angles, so it cannot be streamed")
    if motion.joint_names != arm.joint_names:
        raise InputError(
            f"{where}: joints are {motion.joint_names}, those of {arm.name} are {arm.joint_names}"
        )
    bad = np.argwhere(~np.isfinite(motion.angles))
    if bad.size:
        frame, joint = bad[0]
        raise InputError(
            f"{where}: joint {arm.joint_names[joint]} is {motion.angles[frame, joint]}"
            f" at {motion.time[frame]:.3f} s"
        )
    return motion.angles


def _uniform_step(motion: Trajectory) -> float:
    steps = np.diff(motion.time)
    step = float(np.median(steps))
    worst = int(np.argmax(np.abs(steps - step)))
    if abs(steps[worst] - step) > UNIFORM_TOLERANCE * step:
        raise RefusedMotionError(
            f"{motion.source or 'motion'}: a time step of {steps[worst]:.6f} s at"
            f" {motion.time[worst]:.3f} s among steps of {step:.6f} s; resample it first"
        )
    return step


def check_start(
    start: FloatArray,
    present_posture: ArrayLike,
    arm: ArmDescription,
    tolerance: float = START_TOLERANCE,
) -> None:
    """Refuse a trajectory that does not start where the arm is.

    Parameters
    ----------
    start, present_posture : array, shape (n,)
        rad (or m).
    arm : ArmDescription
    tolerance : float
        rad (or m).

    Raises
    ------
    InputError
        A present posture that is not n finite numbers.
    LimitError
        The message names the joint that is farthest away.
    """
    present = np.asarray(present_posture, dtype=np.float64)
    if present.shape != start.shape or not np.isfinite(present).all():
        raise InputError(f"the present posture is not {start.size} finite numbers: {present}")
    away = np.abs(start - present)
    joint = int(np.argmax(away))
    if away[joint] > tolerance:
        raise LimitError(
            f"joint {arm.joint_names[joint]} is at {present[joint]:.3f} rad but the trajectory"
            f" starts at {start[joint]:.3f} rad, more than {tolerance:g} rad away:"
            " plan again from where the arm is",
            arm.joint_names[joint],
            float(away[joint]),
            tolerance,
        )


def _check_range(time: FloatArray, angles: FloatArray, arm: ArmDescription) -> None:
    lower, upper = arm.chain.lower, arm.chain.upper
    outside = np.argwhere(
        (angles < lower - POSITION_TOLERANCE) | (angles > upper + POSITION_TOLERANCE)
    )
    if outside.size:
        frame, joint = outside[0]
        value = float(angles[frame, joint])
        limit = float(lower[joint] if value < lower[joint] else upper[joint])
        raise LimitError(
            f"joint {arm.joint_names[joint]} would be at {value:.3f} rad at {time[frame]:.3f} s,"
            f" its limit is {limit:.3f} rad",
            arm.joint_names[joint],
            value,
            limit,
        )


def _worst(rates: FloatArray, limits: FloatArray) -> tuple[int, int]:
    """Row and joint of the rate that is greatest by its limit."""
    row, joint = divmod(int(np.argmax(np.abs(rates) / limits)), rates.shape[1])
    return row, joint
