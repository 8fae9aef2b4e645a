"""The check of a whole trajectory before anything moves."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsyn.arm import ArmDescription
from armsyn.errors import InputError, LimitError, RefusedMotionError
from armsyn.safety.command import POSITION_TOLERANCE

FloatArray = NDArray[np.float64]

START_TOLERANCE = 0.05
"""rad (or m) between where the arm is and where a trajectory may start."""

RATE_TOLERANCE = 0.02
"""Part of a speed or acceleration limit that sampling may add to a motion that keeps it."""

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
) -> None:
    """Refuse a trajectory that the arm must not follow.

    Speeds and accelerations are differences of neighbouring samples; the arm rests before the
    first and after the last, so that a trajectory that starts or ends at speed is refused too.

    Parameters
    ----------
    motion : Trajectory
        A Motion with angles, rad (or m).
    arm : ArmDescription
    present_posture : array_like, shape (n,), optional
        Where the arm is, rad (or m); not checked when it is not given.
    start_tolerance : float
        rad (or m).

    Raises
    ------
    InputError
        No angles, other joints than the arm's, or values that are not finite.
    RefusedMotionError
        Time stamps that are not uniform.
    LimitError
        A joint leaves its range, exceeds its speed or acceleration, or starts elsewhere; the
        message names joint, time, value and limit.
    """
    angles = _finite_angles(motion, arm)
    step = _uniform_step(motion)
    if present_posture is not None:
        _check_start(angles[0], present_posture, arm, start_tolerance)
    _check_range(motion.time, angles, arm)
    _check_rates(motion.time, angles, step, arm)


def _check_rates(time: FloatArray, angles: FloatArray, step: float, arm: ArmDescription) -> None:
    resting = np.concatenate([angles[:1], angles, angles[-1:]])
    velocity = np.diff(resting, axis=0) / step
    acceleration = np.diff(velocity, axis=0) / step
    for rates, quantity, limits in (
        (velocity[1:], "a speed of {:.2f} rad/s", arm.max_velocity),
        (acceleration, "an acceleration of {:.2f} rad/s2", arm.max_acceleration),
    ):
        frame, joint = _worst(rates, limits)
        if abs(rates[frame, joint]) > limits[joint] * (1.0 + RATE_TOLERANCE):
            value, limit = float(rates[frame, joint]), float(limits[joint])
            raise LimitError(
                f"joint {arm.joint_names[joint]} would have {quantity.format(value)} at"
                f" {time[min(frame, time.size - 1)]:.3f} s, its limit is"
                f" {limit:.2f}: slow the motion down",
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


def _check_start(
    start: FloatArray, present_posture: ArrayLike, arm: ArmDescription, tolerance: float
) -> None:
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
